//! Swarms: particles on the graphics device, against the same particles as bodies, against closed forms, and against the same
//! steps on plain arrays.

mod closed_forms;
mod going_back;
mod reference;
mod refusals;
mod side_by_side;

use cockpit::view::on_device::swarms;
use glam::{DVec3, Vec3};
use render::Gpu;
use sandbox::Session;
use swarm::{Swarm, SwarmLog, SwarmParticle, Swarms};

use crate::rigs::Drive;

/// A device and its swarms.
pub struct Device {
    pub gpu: Gpu,
    pub swarms: Swarms,
}

impl Device {
    /// # Panics
    /// Without a graphics adapter; the message says what to install.
    pub fn new() -> Self {
        let gpu = Gpu::headless().unwrap_or_else(|error| panic!("{error}"));
        Self { swarms: Swarms::new(&gpu), gpu }
    }

    /// What is in every slot of the only swarm of `session`.
    pub fn slots(&mut self, session: &mut Session) -> Vec<Option<SwarmParticle>> {
        let swarms = swarms(&session.stage);
        assert_eq!(swarms.len(), 1);
        self.swarms.follow(&self.gpu, &swarms);
        self.swarms.read(&self.gpu, 0).unwrap()
    }

    /// Number and place in the world of every living particle, by its slot.
    pub fn living(&mut self, session: &mut Session) -> Vec<(u64, DVec3)> {
        let slots = self.slots(session);
        let world = session.stage.world_mut();
        let (swarm, log) = world.query::<(&Swarm, &SwarmLog)>().single(world).unwrap();
        let dead = log.ticks.back().map_or(0, |tick| tick.dead);
        let count = slots.len() as u64;
        let place = |position: [f32; 3]| swarm.anchor + Vec3::from(position).as_dvec3();
        let living = (0..).zip(slots).filter_map(|(slot, particle): (u64, _)| {
            let SwarmParticle { generation, position, .. } = particle?;
            Some((generation * count + slot, place(position)))
        });
        living.filter(|(number, _)| *number >= dead).collect()
    }
}

/// The scene that these keys and those of its only emitter describe, at 60 ticks per second.
pub fn scene_text(keys: &str, emitter: &str) -> String {
    format!("(version: 1, step_hz: 60, seed: 3, {keys} emitters: [(name: \"e\", {emitter})])")
}

/// Sixty ticks per second, a frame each.
pub fn ticks(drive: &mut Drive, count: u32) {
    drive.run(count, 1.0 / 60.0);
}

#[test]
fn the_ticks_of_storm_are_pinned() {
    let mut simulation = history::Simulation::new(scene::load("storm").unwrap());
    simulation.run(600);
    let log = simulation.world.query::<&SwarmLog>().single(&simulation.world).unwrap();
    // Everything that a device gets, on every processor; its life is 480 ticks.
    assert_eq!((log.ticks.len(), format!("{:016x}", log.key).as_str()), (480, "9455c3cc98eb88de"));
}
