//! Twins: simulations that repeat another one in step with it, with the same scene and inputs, by their own method.

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::{
    Damping, DampingModel, Method, OwnMethod, OwnSubsteps, Request, TimeStep, remember_positions,
};
use scene::{Scene, Substepping};

use crate::change::Change;
use crate::simulation::{FirstQuarantine, Simulation};

/// The method of references: of those that can solve every law, the one of the highest order.
pub const REFERENCE_METHOD: Method = Method::RungeKutta4;

/// Substeps of the reference, or twice as many as the scene has if that is more. Its error is then some `16^4 =
/// 65,536` times smaller than that of Runge-Kutta 4 in whole ticks. Substeps instead of shorter ticks, because a push
/// is a force over a tick: other ticks would be another problem.
pub const REFERENCE_SUBSTEPS: u32 = 16;

/// A simulation of the scene of another one, its leader, that takes in the same changes.
///
/// All of its bodies have the method of the twin, even those that have their own in the leader.
pub struct Twin {
    simulation: Simulation,
}

/// Substeps of the reference of `scene`: twice as many as any of its bodies, and at least [`REFERENCE_SUBSTEPS`]. If a body chooses,
/// the reference chooses for the smallest error of any, divided by 4,096.
#[must_use]
pub fn reference_substeps(scene: &Scene) -> Substepping {
    let own = || scene.bodies.iter().filter_map(|body| body.substeps).chain([scene.substeps]);
    let most = own().map(Substepping::least).fold(0, u32::max);
    let chosen = own().filter(|substeps| substeps.choice().is_some()).min();
    chosen.map_or_else(
        || REFERENCE_SUBSTEPS.max(most.saturating_mul(2)).into(),
        |chosen| chosen.finer(8),
    )
}

impl Twin {
    /// A twin that starts from the present state of `leader`, between two ticks, with these substeps for every
    /// body, or with those of the leader if `None`.
    ///
    /// Before the first tick it has the bits of a scene with this method. Later it takes over the method state of the
    /// leader, and changes the method as [`Simulation::set_method`] does: the velocities of position Verlet, which
    /// lag half a step behind, are first brought to the time of the positions. Pushes that wait in the leader for the next
    /// tick wait in the twin as well; later ones are [given](Twin::give).
    ///
    /// # Panics
    /// If the bodies of `leader` are not those of its scene.
    #[must_use]
    pub fn new(leader: &Simulation, method: Method, substeps: Option<Substepping>) -> Self {
        let begins = leader.world.resource::<StepClock>().scene_seconds() == 0.0;
        let mut scene = Scene::clone(&leader.scene);
        scene.bodies.iter_mut().for_each(|body| body.method = None);
        scene.method = if begins { method } else { leader.method() };
        let mut start = leader.snapshot().without_history();
        if begins {
            start.begin_by_method_of(&scene);
        }
        let mut simulation =
            Simulation::restore(scene, &start).expect("it was taken of a simulation of that scene");
        unify_methods(&mut simulation, method);
        let Simulation { world, stepper, .. } = &mut simulation;
        if let Some(substeps) = substeps {
            for body in entities::<With<OwnSubsteps>>(world) {
                world.entity_mut(body).remove::<OwnSubsteps>();
            }
            substeps.put(world);
        }
        stepper.recompile(world);
        Self { simulation }
    }

    /// The reference for twins of `leader`, with at least [`REFERENCE_SUBSTEPS`].
    ///
    /// # Panics
    /// As [`Twin::new`].
    #[must_use]
    pub fn reference(leader: &Simulation) -> Self {
        let substeps = reference_substeps(&leader.scene);
        Self::new(leader, REFERENCE_METHOD, Some(substeps))
    }

    /// A far finer run of `leader`: `ticks` ticks of the reference method in place of each, with these substeps. Damping is the
    /// law that its model approximates.
    ///
    /// # Panics
    /// As [`Twin::new`].
    #[must_use]
    pub fn finer(leader: &Simulation, ticks: u32, substeps: Substepping) -> Self {
        let mut twin = Self::new(leader, REFERENCE_METHOD, Some(substeps));
        let Simulation { world, stepper, .. } = &mut twin.simulation;
        let TimeStep(tick) = *world.resource();
        world.insert_resource(TimeStep(tick / f64::from(ticks)));
        if let Some(mut damping) = world.get_resource_mut::<Damping>() {
            damping.model = DampingModel::Exact;
        }
        stepper.recompile(world);
        twin
    }

    /// The simulation of the twin, which then follows no other.
    #[must_use]
    pub fn into_simulation(self) -> Simulation {
        self.simulation
    }

    /// The method of all of its bodies.
    #[must_use]
    pub const fn method(&self) -> Method {
        self.simulation.method()
    }

    /// The simulation of the twin.
    #[must_use]
    pub const fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Why the twin stopped, if it did.
    #[must_use]
    pub fn failure(&self) -> Option<FirstQuarantine> {
        self.simulation.failure()
    }

    /// Makes a change that its leader got: at once, but a push waits for the coming tick. Method and substeps stay.
    pub fn give(&mut self, change: &Change) {
        if self.failure().is_some() {
            return;
        }
        match change {
            Change::Requests(requests) => {
                let of_twins =
                    |request: &Request<u32>| !matches!(request, Request::SetBodyMethod(..));
                let requests = requests.iter().copied().filter(of_twins).collect();
                self.simulation.give(&Change::Requests(requests));
            }
            Change::Step(_) | Change::Push(..) => self.simulation.give(change),
            Change::Method(_) | Change::Substeps(_) => {}
        }
    }

    /// Simulates a tick.
    pub fn tick(&mut self) {
        if self.failure().is_none() {
            self.simulation.tick();
        }
    }

    /// Remembers every position for drawing between two ticks. To be called only if the leader does the same.
    pub fn remember_positions(&mut self) {
        self.simulation
            .world
            .run_system_cached(remember_positions)
            .expect("a query and nothing else");
    }
}

fn entities<Who: bevy_ecs::query::QueryFilter>(world: &mut World) -> Vec<Entity> {
    world.query_filtered::<Entity, Who>().iter(world).collect()
}

/// Changes the method of every body to `method`.
fn unify_methods(simulation: &mut Simulation, method: Method) {
    for body in entities::<With<OwnMethod>>(&mut simulation.world) {
        simulation.request(Request::SetBodyMethod(body, None));
    }
    simulation.carry_out_requests();
    simulation.set_method(method);
}
