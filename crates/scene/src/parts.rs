//! Splits a scene into parts that do not act on each other.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use motion::effects::Effect;
use motion::internals::Sets;
use motion::{AxisLocks, PrescribedMotion};

use crate::entries::Entry;
use crate::scene::coupled::{EmitterSpec, SoftBodySpec, SpringSpec};
use crate::scene::names::Names;
use crate::scene::{BodySpec, OwnLawsSpec, Scene};

/// Name of the part of all bodies that nothing joins.
pub const FREE_BODIES: &str = "free bodies";

/// A part of a scene that runs alone as it does in the whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// [`FREE_BODIES`] for bodies that nothing joins; otherwise the name of the part's first soft body, or that of its
    /// first movable body and the number of other movable bodies.
    pub name: String,
    /// The entries of the whole scene's file whose bodies it moves.
    pub entries: Vec<Entry>,
    /// Stable ids of its bodies in the whole scene, ascending; in [`Part::scene`] they are counted from 0 in this
    /// order. A body that cannot move is in every part that is joined to it or attracted by it.
    pub bodies: Vec<u32>,
    /// A scene of these bodies alone, with the forces and laws on them.
    pub scene: Scene,
}

impl Scene {
    /// The independent parts of the scene, in the order of their first bodies, free bodies last.
    ///
    /// Nothing collides, so bodies act on each other only by springs, mutual gravity, and emitters and wells that
    /// ride on them. A part is a group of bodies that these join, through movable bodies. All bodies that nothing
    /// joins, including particles, are one part together. Bodies of one entry of the file have one method, so an
    /// entry is never divided. Scenery, and immovable bodies that hold nothing, are in no part.
    #[must_use]
    pub fn parts(&self) -> Vec<Part> {
        let entries = self.entries();
        let joined = Joined::of(self, &entries);
        let shell = self.shell();
        let mut parts = joined.members;
        if !joined.free.is_empty() {
            parts.push(joined.free);
        }
        parts.into_iter().map(|bodies| self.part(&shell, &entries, bodies)).collect()
    }

    /// Stable ids of the bodies of each part, as in [`Scene::parts`], ascending, and of the bodies that nothing joins.
    #[must_use]
    pub fn joined(&self) -> (Vec<Vec<u32>>, Vec<u32>) {
        let Joined { members, free } = Joined::of(self, &self.entries());
        (members, free)
    }

    /// The part of these bodies alone, by ascending stable ids; `ids` has all of a soft body or none of it, and both ends of a
    /// spring or neither. An emitter of which `ids` has a part of the pool has that part, and a rate to match.
    #[must_use]
    pub fn part_of(&self, ids: Vec<u32>) -> Part {
        self.part(&self.shell(), &self.entries(), ids)
    }

    /// The scene without anything that refers to stable ids. A clone would be as large as the scene.
    fn shell(&self) -> Self {
        Self {
            text: Arc::clone(&self.text),
            reading: self.reading,
            name: self.name.clone(),
            description: self.description.clone(),
            source: self.source.clone(),
            laws: self.laws.clone(),
            own_laws: BTreeMap::new(),
            motions: BTreeMap::new(),
            bodies: Vec::new(),
            names: Names::default(),
            labels: Vec::new(),
            emitters: Vec::new(),
            springs: Vec::new(),
            soft_bodies: Vec::new(),
            off_at_start: self.off_at_start.clone(),
            declared: self.declared.clone(),
            survival: self.survival.clone(),
            ..*self
        }
    }

    fn part(&self, shell: &Self, entries: &[Entry], ids: Vec<u32>) -> Part {
        let new = |id: u32| ids.binary_search(&id).ok().map(|i| i as u32);
        let span = |bodies: &Range<u32>| {
            new(bodies.start).map(|first| first..first + (bodies.end - bodies.start))
        };
        let mut scene = shell.clone();
        scene.bodies = ids.iter().map(|id| self.bodies[*id as usize]).collect();
        scene.names = self.names.of(&ids);
        scene.labels =
            self.labels.iter().filter_map(|(id, label)| Some((new(*id)?, label.clone()))).collect();
        scene.own_laws = self
            .own_laws
            .iter()
            .filter_map(|(id, laws)| Some((new(*id)?, laws.renumbered(new))))
            .collect();
        let motion = |(id, motion): (&u32, &PrescribedMotion)| Some((new(*id)?, motion.clone()));
        scene.motions = self.motions.iter().filter_map(motion).collect();
        let spring = |spring: &SpringSpec| {
            let [from, to] = spring.ends.map(new);
            Some(SpringSpec { ends: [from?, to?], ..*spring })
        };
        scene.springs = self.springs.iter().filter_map(spring).collect();
        let soft = |soft: &SoftBodySpec| {
            Some(SoftBodySpec { points: span(&soft.points)?, ..soft.clone() })
        };
        scene.soft_bodies = self.soft_bodies.iter().filter_map(soft).collect();
        let with_bodies = || self.emitters.iter().filter(|emitter| emitter.on_device.is_none());
        let emitter = |emitter: &EmitterSpec| {
            let rides_on = emitter.rides_on.and_then(new);
            let all = emitter.pool.len();
            let kept = emitter.pool.clone().take_while(|id| new(*id).is_some()).count();
            let pool = span(&(emitter.pool.start..emitter.pool.start + kept as u32))?;
            let launches = emitter.launches[..kept].to_vec();
            let rate = emitter.rate * (kept as f64 / all as f64);
            Some(EmitterSpec { pool, rides_on, launches, rate, ..emitter.clone() })
        };
        scene.emitters = with_bodies().filter_map(emitter).collect();
        // Particles neither attract nor are attracted.
        let particles: usize = scene.particles_in_pools();
        if particles == scene.bodies.len() {
            scene.mutual_gravity = None;
        }
        scene.take_common_setting();
        scene.keep_declared();
        let moves = |entry: &&Entry| {
            let mut bodies = entry.bodies.clone();
            bodies.any(|id| self.bodies[id as usize].is_movable() && new(id).is_some())
        };
        let entries = entries.iter().filter(moves).cloned().collect();
        Part { name: scene.part_name(), entries, bodies: ids, scene }
    }

    /// If all movable bodies have the same method and substeps, makes these the scene's own.
    fn take_common_setting(&mut self) {
        let setting = |body: &BodySpec| {
            (body.method.unwrap_or(self.method), body.substeps.unwrap_or(self.substeps))
        };
        let mut settings = self.bodies.iter().filter(|body| body.is_movable()).map(setting);
        let Some((method, substeps)) = settings.next() else { return };
        if settings.all(|other| other == (method, substeps)) {
            (self.method, self.substeps) = (method, substeps);
            for body in &mut self.bodies {
                (body.method, body.substeps) = (None, None);
            }
        }
    }

    /// Removes the declarations of effects that this part does not have.
    fn keep_declared(&mut self) {
        let mut declared = std::mem::take(&mut self.declared);
        declared.retain(|declaration| match declaration.effect {
            Effect::Wells => {
                let has_own =
                    |laws: &OwnLawsSpec| !laws.wells.is_empty() || !laws.riding_wells.is_empty();
                self.laws.wells.is_some() || self.own_laws.values().any(has_own)
            }
            Effect::Drag => {
                self.laws.drag.is_some() || self.own_laws.values().any(|laws| laws.drag.is_some())
            }
            Effect::MutualGravity => self.mutual_gravity.is_some(),
            Effect::Thrusts => self.own_laws.values().any(|laws| !laws.thrusts.is_empty()),
            Effect::Springs => !self.springs.is_empty() || !self.soft_bodies.is_empty(),
            Effect::SpeedLimits => self.bodies.iter().any(|body| body.max_speed.is_some()),
            Effect::AxisLocks => self.bodies.iter().any(|body| body.locks != AxisLocks::default()),
            Effect::Emitters => !self.emitters.is_empty(),
            // Effects on every body act in every part.
            Effect::Gravity | Effect::Damping | Effect::Wind => true,
        });
        self.declared = declared;
    }

    fn part_name(&self) -> String {
        let carries = self.emitters.iter().any(|emitter| emitter.rides_on.is_some())
            || self.own_laws.values().any(|laws| !laws.riding_wells.is_empty());
        let joins = !self.springs.is_empty()
            || !self.soft_bodies.is_empty()
            || self.mutual_gravity.is_some();
        if !joins && !carries {
            return FREE_BODIES.to_owned();
        }
        if let Some(soft) = self.soft_bodies.first() {
            return soft.name.clone();
        }
        let mut movable =
            (0..).zip(&self.bodies).filter(|(_, body)| body.is_movable()).map(|(id, _)| id);
        let first = movable.next().and_then(|id| self.names.get(id)).unwrap_or_default();
        match movable.count() {
            0 => first.into_owned(),
            more => format!("{first} and {more} more"),
        }
    }
}

/// Stable ids, grouped by what joins the bodies.
struct Joined {
    /// Each group, with the bodies that hold or attract it, ascending.
    members: Vec<Vec<u32>>,
    /// Movable bodies that nothing joins, ascending.
    free: Vec<u32>,
}

impl Joined {
    fn of(scene: &Scene, entries: &[Entry]) -> Self {
        let movable = |id: &u32| scene.bodies[*id as usize].is_movable();
        let count = scene.bodies.len();
        let (mut sets, mut joined) = (Sets::new(count), vec![false; count]);
        let mut join = |ids: &mut dyn Iterator<Item = u32>, joined: &mut [bool]| {
            let mut ids =
                ids.filter(movable).map(|id| id as usize).inspect(|id| joined[*id] = true);
            if let Some(first) = ids.next() {
                ids.for_each(|id| sets.join(first, id));
            }
        };
        scene.springs.iter().for_each(|spring| join(&mut spring.ends.into_iter(), &mut joined));
        scene.soft_bodies.iter().for_each(|soft| join(&mut soft.points.clone(), &mut joined));
        // Particles are born at the body that carries their emitter.
        let with_carrier = |emitter: &EmitterSpec| {
            let first = emitter.on_device.is_none().then_some(emitter.pool.start)?;
            Some([emitter.rides_on?, first])
        };
        let emitters = scene.emitters.iter().filter_map(with_carrier);
        // A riding well pulls toward the body that carries it.
        let wells = scene
            .own_laws
            .iter()
            .flat_map(|(id, laws)| laws.riding_wells.iter().map(|well| [well.rides_on, *id]));
        let carried: Vec<_> = emitters.chain(wells).collect();
        carried.iter().for_each(|ids| join(&mut ids.iter().copied(), &mut joined));
        let all = 0..count as u32;
        if scene.mutual_gravity.is_some() {
            join(&mut all.clone().filter(|id| !scene.is_particle(*id)), &mut joined);
        }
        for Entry { bodies, .. } in entries {
            if bodies.len() > 1 && bodies.clone().any(|id| joined[id as usize]) {
                join(&mut bodies.clone(), &mut joined);
            }
        }

        let mut members: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        for id in all.clone().filter(|id| joined[*id as usize]) {
            members.entry(sets.of(id as usize)).or_default().push(id);
        }
        let mut hold = |ids: &mut dyn Iterator<Item = u32>| {
            let (moved, held): (Vec<_>, Vec<_>) = ids.partition(movable);
            let part = moved.first().and_then(|id| members.get_mut(&sets.of(*id as usize)));
            part.into_iter().for_each(|part| part.extend(&held));
        };
        scene.springs.iter().for_each(|spring| hold(&mut spring.ends.into_iter()));
        scene.soft_bodies.iter().for_each(|soft| hold(&mut soft.points.clone()));
        carried.iter().for_each(|ids| hold(&mut ids.iter().copied()));
        if scene.mutual_gravity.is_some() {
            let sources =
                || all.clone().filter(|id| scene.bodies[*id as usize].source_mass.is_some());
            members.values_mut().for_each(|part| part.extend(sources()));
        }
        let members = members.into_values().map(|mut part| {
            part.sort_unstable();
            part.dedup();
            part
        });
        let free = all.filter(|id| movable(id) && !joined[*id as usize]).collect();
        Self { members: members.collect(), free }
    }
}

#[cfg(test)]
mod tests;
