//! What a snapshot takes.

use motion::effects::Effect;
use motion::snapshot::EmissionState;

use super::*;
use crate::simulation::Simulation;

#[test]
fn every_list_counts_as_it_is_allocated() {
    let mut snapshot = Snapshot::default();
    assert_eq!(snapshot.bytes(), size_of::<Snapshot>());
    let slots = EmissionState { slots: Vec::with_capacity(7), ..EmissionState::default() };
    snapshot.emissions = Vec::with_capacity(3);
    snapshot.emissions.push((0, EmissionEntry(slots)));
    snapshot.counts.laws = Vec::with_capacity(5);
    let lists = 7 * size_of::<Option<u64>>()
        + 3 * size_of::<(u32, EmissionEntry)>()
        + 5 * size_of::<(Name<&str>, u64)>();
    assert_eq!(snapshot.bytes(), size_of::<Snapshot>() + lists);
    let scene = Scene::parse("t", "(version: 1, drag: (linear_per_s: 1))").unwrap();
    let mut world = Simulation::new(scene).world;
    motion::effects::switch(&mut world, Effect::Drag, false).unwrap();
    snapshot.effects = Effects::of(&mut world);
    assert!(snapshot.bytes() > size_of::<Snapshot>() + lists);
}
