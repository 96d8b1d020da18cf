//! The memory of a snapshot.

use motion::Iterations;
use motion::effects::Effect;
use motion::snapshot::{Effects, EmissionState};

use super::*;
use crate::simulation::Simulation;

#[test]
fn every_list_counts_as_it_is_allocated() {
    let mut snapshot = Snapshot::default();
    assert_eq!(snapshot.bytes(), size_of::<Snapshot>());
    let slots = EmissionState { slots: Vec::with_capacity(7), ..EmissionState::default() };
    snapshot.state.emissions = Vec::with_capacity(3);
    snapshot.state.emissions.push((0, slots));
    // The counts of nine laws are in an allocated list.
    let laws = [("law", 1); 9];
    snapshot.state.evaluations = Evaluations::from_counts(0, laws, Iterations::default());
    let counts = snapshot.state.evaluations.list_bytes();
    assert!(counts >= size_of_val(&laws));
    let lists = 7 * size_of::<Option<u64>>() + 3 * size_of::<(u32, EmissionState)>() + counts;
    assert_eq!(snapshot.bytes(), size_of::<Snapshot>() + lists);
    let scene = Scene::parse("t", "(version: 1, drag: (linear_per_s: 1))").unwrap();
    let mut world = Simulation::new(scene).world;
    motion::effects::switch(&mut world, Effect::Drag, false).unwrap();
    snapshot.state.effects = Effects::of(&world);
    assert!(snapshot.bytes() > size_of::<Snapshot>() + lists);
}
