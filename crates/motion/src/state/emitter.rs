//! Emitters: a fixed pool of particles, thrown out one after another and taken back when their time is over.

use bevy_ecs::prelude::*;

use crate::schedule::emission::Emission;
use crate::units::{Scalar, Vector};

/// Throws out particles, an entity beside them. Particle number k, counted from 0, is born `k / rate` seconds
/// after the scene's start and lives for `life`; it is the body `k % n` of a pool of n, and if that one still
/// lives, it is taken. What was due before the emitter was spawned or while it was off is not made up for.
///
/// A birth within a tick is one: what is left of the tick is a tick of the body's method, in as many substeps as a
/// whole one.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Emission)]
pub struct Emitter {
    /// Particles a second, above 0.
    pub rate: Scalar,
    /// How long each of them lives, s, above 0.
    pub life: Scalar,
    /// Where they are born, m.
    pub position: Vector,
    /// The pool; its bodies are [`Dormant`] until they are born.
    pub pool: Vec<Entity>,
    /// The velocity that each body of the pool is born with, m/s; as many as there are bodies.
    pub launches: Vec<Vector>,
    /// Reciprocal of the mass of each of them, 1/kg.
    pub inverse_mass: Scalar,
}

/// A particle that is not born yet, or no longer lives: at rest at its emitter, ignored by every system, neither
/// drawn nor hit.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dormant;
