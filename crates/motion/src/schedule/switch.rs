//! Effects: what a scene can call for, and switching them on and off.
//!
//! Off means gone: the resource or the components of the effect are taken out of the world, so that the schedule is
//! compiled without it and no column of it is walked. Their values wait in [`Off`] and [`OffResource`].

mod extent;

use std::fmt;

use bevy_ecs::prelude::*;

use crate::laws::damping::{Damping, DampingRate};
use crate::laws::own::OwnLaws;
use crate::laws::{Drag, Gravity, MutualGravity, Wells, Wind};
use crate::schedule::restart::{end_half_steps, is_prepared, restart_bodies};
use crate::state::components::{AxisLocks, SpeedLimit};
use crate::state::coupling::CouplingChanged;
use crate::state::emitter::Emitter;
use crate::state::off::{Off, OffResource, SpringsOff};
use crate::state::springs::{SoftBody, Spring};
pub use extent::column_bytes;

/// An effect that a scene can call for. In a run in which it is off, or was never declared, no system, column or
/// branch of it exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// [`Gravity`](crate::Gravity).
    Gravity,
    /// [`Damping`](crate::Damping), of the scene and of single bodies.
    Damping,
    /// [`Drag`](crate::Drag).
    Drag,
    /// [`Wind`](crate::Wind), which drag sees.
    Wind,
    /// [`Wells`](crate::Wells), of the scene and of single bodies.
    Wells,
    /// [`MutualGravity`](crate::MutualGravity).
    MutualGravity,
    /// [`Thrust`](crate::Thrust) of single bodies.
    Thrusts,
    /// [`Spring`](crate::Spring) and [`SoftBody`](crate::SoftBody).
    Springs,
    /// [`SpeedLimit`](crate::SpeedLimit) of single bodies.
    SpeedLimits,
    /// [`AxisLocks`](crate::AxisLocks) of single bodies.
    AxisLocks,
    /// [`Emitter`](crate::Emitter).
    Emitters,
}

impl Effect {
    /// Every effect, in the order of the receipt.
    pub const ALL: [Self; 11] = [
        Self::Gravity,
        Self::Damping,
        Self::Drag,
        Self::Wind,
        Self::Wells,
        Self::MutualGravity,
        Self::Thrusts,
        Self::Springs,
        Self::SpeedLimits,
        Self::AxisLocks,
        Self::Emitters,
    ];

    /// The word for it in receipts, scripts, flags and panels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gravity => "gravity",
            Self::Damping => "damping",
            Self::Drag => "drag",
            Self::Wind => "wind",
            Self::Wells => "wells",
            Self::MutualGravity => "mutual_gravity",
            Self::Thrusts => "thrusts",
            Self::Springs => "springs",
            Self::SpeedLimits => "speed_limits",
            Self::AxisLocks => "axis_locks",
            Self::Emitters => "emitters",
        }
    }

    /// The effect of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|effect| effect.name() == name)
    }

    /// Whether it accelerates bodies or slows them down, so that half a step under it cannot be ended without it.
    const fn acts_on_velocity(self) -> bool {
        !matches!(self, Self::SpeedLimits | Self::AxisLocks | Self::Emitters)
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// Whether an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EffectState {
    /// It acts.
    On,
    /// It was declared and switched off; its value is kept.
    Off,
    /// Nobody declared it: there is no value that could be switched on.
    NotDeclared,
}

impl EffectState {
    /// The words for it in receipts and panels.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::On => "on",
            Self::Off => "off",
            Self::NotDeclared => "not declared",
        }
    }

    const fn of(on: bool, off: bool) -> Self {
        match (on, off) {
            (true, _) => Self::On,
            (false, true) => Self::Off,
            (false, false) => Self::NotDeclared,
        }
    }
}

/// An effect cannot be switched that nobody declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NeverDeclared(pub Effect);

impl fmt::Display for NeverDeclared {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "this scene never declared {}", self.0)
    }
}

impl std::error::Error for NeverDeclared {}

/// The wind of a scene, off: still air.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
struct OffWind(Wind);

/// Whether `effect` acts in `world`.
pub fn state(world: &mut World, effect: Effect) -> EffectState {
    match effect {
        Effect::Gravity => world
            .get_resource::<Gravity>()
            .map_or(EffectState::NotDeclared, |gravity| EffectState::of(gravity.on, true)),
        Effect::Damping => state_of_resource::<Damping>(world),
        Effect::Drag => state_of_resource::<Drag>(world),
        Effect::Wind => {
            let on = wind(world).is_some_and(|wind| wind.is_some());
            EffectState::of(on, world.contains_resource::<OffWind>())
        }
        Effect::Wells => {
            let [on, off] = own_laws_named(world, "wells");
            EffectState::of(
                on || world.contains_resource::<Wells>(),
                off || world.contains_resource::<OffResource<Wells>>(),
            )
        }
        Effect::MutualGravity => state_of_resource::<MutualGravity>(world),
        Effect::Thrusts => {
            let [on, off] = own_laws_named(world, "thrusts");
            EffectState::of(on, off)
        }
        Effect::Springs => {
            let declared = exists::<Or<(With<Spring>, With<SoftBody>)>>(world);
            EffectState::of(declared && !world.contains_resource::<SpringsOff>(), declared)
        }
        Effect::SpeedLimits => state_of_component::<SpeedLimit>(world),
        Effect::AxisLocks => state_of_component::<AxisLocks>(world),
        Effect::Emitters => state_of_component::<Emitter>(world),
    }
}

/// Switches an effect off or on again, between two ticks; [`Stepper::recompile`](crate::Stepper::recompile) has to
/// follow. Off and on again leaves everything bit for bit as it was, with two exceptions: bodies of position Verlet
/// start anew where laws change that act on them or on their groups, and of an emitter that was off for a tick nothing
/// is born that was due meanwhile. Particles that fly when their emitter is switched off live out their lives.
///
/// # Errors
/// An effect that nobody declared.
pub fn switch(world: &mut World, effect: Effect, on: bool) -> Result<(), NeverDeclared> {
    match state(world, effect) {
        EffectState::NotDeclared => return Err(NeverDeclared(effect)),
        EffectState::On if on => return Ok(()),
        EffectState::Off if !on => return Ok(()),
        EffectState::On | EffectState::Off => {}
    }
    match bodies_of(world, effect) {
        Some(bodies) if is_prepared(world) => restart_bodies(world, &bodies),
        None if effect.acts_on_velocity() => end_half_steps(world),
        _ => {}
    }
    match effect {
        Effect::Gravity => {
            if let Some(mut gravity) = world.get_resource_mut::<Gravity>() {
                gravity.on = on;
            }
        }
        Effect::Damping => {
            switch_resource::<Damping>(world, on);
            switch_component::<DampingRate>(world, on);
        }
        Effect::Drag => switch_resource::<Drag>(world, on),
        Effect::Wind => switch_wind(world, on),
        Effect::Wells => {
            switch_resource::<Wells>(world, on);
            switch_own_laws(world, "wells", on);
        }
        Effect::MutualGravity => switch_resource::<MutualGravity>(world, on),
        Effect::Thrusts => switch_own_laws(world, "thrusts", on),
        Effect::Springs if on => drop(world.remove_resource::<SpringsOff>()),
        Effect::Springs => world.insert_resource(SpringsOff),
        Effect::SpeedLimits => switch_component::<SpeedLimit>(world, on),
        Effect::AxisLocks => switch_component::<AxisLocks>(world, on),
        Effect::Emitters => switch_component::<Emitter>(world, on),
    }
    if matches!(effect, Effect::Springs | Effect::MutualGravity) {
        CouplingChanged::set(world);
    }
    Ok(())
}

type Lawful = Or<(With<OwnLaws>, With<Off<OwnLaws>>)>;

/// Those that an effect acts on, if it is one of single bodies alone.
fn bodies_of(world: &mut World, effect: Effect) -> Option<Vec<Entity>> {
    let everywhere = state_of_resource::<Wells>(world) != EffectState::NotDeclared;
    let has = match effect {
        Effect::Thrusts => has_law("thrusts"),
        Effect::Wells if !everywhere => has_law("wells"),
        _ => return None,
    };
    let mut bodies = world.query_filtered::<(Entity, Option<&OwnLaws>, Option<&Off<OwnLaws>>), Lawful>();
    let named = bodies
        .iter(world)
        .filter(|(_, on, off)| on.is_some_and(&has) || off.is_some_and(|Off(laws)| has(laws)))
        .map(|(body, ..)| body);
    Some(named.collect())
}

fn exists<F: bevy_ecs::query::QueryFilter>(world: &mut World) -> bool {
    world.query_filtered::<(), F>().iter(world).next().is_some()
}

fn state_of_resource<R: Resource>(world: &World) -> EffectState {
    EffectState::of(world.contains_resource::<R>(), world.contains_resource::<OffResource<R>>())
}

fn state_of_component<C: Component>(world: &mut World) -> EffectState {
    EffectState::of(exists::<With<C>>(world), exists::<With<Off<C>>>(world))
}

fn switch_resource<R: Resource>(world: &mut World, on: bool) {
    if on {
        if let Some(OffResource(value)) = world.remove_resource() {
            world.insert_resource::<R>(value);
        }
    } else if let Some(value) = world.remove_resource::<R>() {
        world.insert_resource(OffResource(value));
    }
}

fn entities_with<C: Component>(world: &mut World) -> Vec<Entity> {
    world.query_filtered::<Entity, With<C>>().iter(world).collect()
}

fn switch_component<C: Component>(world: &mut World, on: bool) {
    if on {
        for entity in entities_with::<Off<C>>(world) {
            let mut entity = world.entity_mut(entity);
            if let Some(Off(value)) = entity.take::<Off<C>>() {
                entity.insert(value);
            }
        }
    } else {
        for entity in entities_with::<C>(world) {
            let mut entity = world.entity_mut(entity);
            if let Some(value) = entity.take::<C>() {
                entity.insert(Off(value));
            }
        }
    }
}

/// The wind of drag, whether that is on or off; `None`: nobody declared drag.
fn wind(world: &World) -> Option<Option<Wind>> {
    let off = || world.get_resource::<OffResource<Drag>>().map(|off| &off.0);
    world.get_resource::<Drag>().or_else(off).map(|drag| drag.wind)
}

fn switch_wind(world: &mut World, on: bool) {
    let wind = if on { world.remove_resource().map(|OffWind(wind)| wind) } else { wind(world).flatten() };
    let Some(wind) = wind else { return };
    let drag = |drag: &mut Drag| drag.wind = on.then_some(wind);
    if let Some(mut acting) = world.get_resource_mut::<Drag>() {
        drag(&mut acting);
    } else if let Some(mut off) = world.get_resource_mut::<OffResource<Drag>>() {
        drag(&mut off.0);
    }
    if !on {
        world.insert_resource(OffWind(wind));
    }
}

fn has_law(name: &str) -> impl Fn(&OwnLaws) -> bool {
    move |laws| laws.laws().iter().any(|law| law.name() == name)
}

/// Whether a body has laws of that name that are on, and off.
fn own_laws_named(world: &mut World, name: &str) -> [bool; 2] {
    let has = has_law(name);
    let on = world.query::<&OwnLaws>().iter(world).any(&has);
    let off = world.query::<&Off<OwnLaws>>().iter(world).any(|Off(laws)| has(laws));
    [on, off]
}

fn switch_own_laws(world: &mut World, name: &str, on: bool) {
    let joined = |laws: Option<OwnLaws>, more: OwnLaws| match laws {
        Some(laws) => laws.merge(more),
        None => more,
    };
    let bodies = if on { entities_with::<Off<OwnLaws>>(world) } else { entities_with::<OwnLaws>(world) };
    for body in bodies {
        let mut body = world.entity_mut(body);
        let (acting, waiting) = (body.take::<OwnLaws>(), body.take::<Off<OwnLaws>>().map(|Off(laws)| laws));
        let (from, to) = if on { (waiting, acting) } else { (acting, waiting) };
        let (named, rest) = from.map_or((None, None), |from| from.split(name));
        let to = match named {
            Some(named) => Some(joined(to, named)),
            None => to,
        };
        let (acting, waiting) = if on { (to, rest) } else { (rest, to) };
        if let Some(acting) = acting {
            body.insert(acting);
        }
        if let Some(waiting) = waiting {
            body.insert(Off(waiting));
        }
    }
}
