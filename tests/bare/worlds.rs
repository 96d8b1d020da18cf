//! Every shipped scene goes in plain arrays as it goes in a world.

use history::Simulation;
use motion::arrays::Bare;
use motion::{Evaluations, Method, Quarantine};
use scene::{Scene, shipped};

use super::{arrays, run, states, twin};
use crate::rigs::all_bits;

fn scenes() -> impl Iterator<Item = Scene> {
    // Plain arrays carry no wells on bodies.
    let rides = |scene: &Scene| scene.own_laws.values().any(|laws| !laws.riding_wells.is_empty());
    shipped().iter().map(|shipped| shipped.load().unwrap()).filter(move |scene| !rides(scene))
}

/// How many ticks a run is worth, and methods and substeps that a scene is run with: all, where it is small.
fn runs(scene: &Scene) -> (u32, Vec<(Method, u32)>) {
    let bodies = u32::try_from(scene.bodies.len()).unwrap();
    let few = vec![(Method::SemiImplicitEuler, 1), (Method::RungeKutta4, 3)];
    let all = Method::ALL.into_iter().flat_map(|method| [(method, 1), (method, 3)]);
    let runs = if bodies > 5_000 { few } else { all.collect() };
    ((20_000 / bodies.max(1)).clamp(3, 120), runs)
}

/// What a run in arrays has in common with that in a world that was `run` for as many ticks: everything, or that
/// they failed.
fn compare(
    bare: &Bare,
    twin: &mut Simulation,
    run: impl FnOnce(&mut Simulation),
) -> Result<(), String> {
    let quarantined = |twin: &Simulation| twin.world.resource::<Quarantine>().records().len();
    let before = quarantined(twin);
    run(twin);
    if quarantined(twin) > before {
        return if bare.has_failed() { Ok(()) } else { Err("should have failed".into()) };
    }
    if bare.has_failed() {
        return Err(format!("refused {:?}", bare.refused()));
    }
    let same = all_bits(states(bare)) == all_bits(twin.states());
    if same { Ok(()) } else { Err("has other bits".into()) }
}

#[test]
fn every_scene_has_the_bits_of_its_world() {
    let (mut seen, mut failed, mut failures) = (0, 0, Vec::new());
    for scene in scenes() {
        let (ticks, runs) = runs(&scene);
        for (method, substeps) in runs {
            let mut twin = twin(scene.clone(), method, substeps);
            let mut bare = arrays(&mut twin);
            assert_eq!(
                all_bits(states(&bare)),
                all_bits(twin.states()),
                "{} at the start",
                scene.name
            );
            run(&mut bare, ticks);
            let mut outcome = compare(&bare, &mut twin, |twin| twin.run(ticks.into()));
            let counts = twin.world.resource::<Evaluations>();
            let counted =
                (counts.accelerations(), counts.cg_iterations(), counts.newton_iterations());
            let own = (bare.evaluations(), bare.cg_iterations(), bare.newton().0);
            if outcome.is_ok() && !bare.has_failed() && own != counted {
                outcome = Err(format!("counts {own:?}, not {counted:?}"));
            }
            if let Err(what) = outcome {
                failures
                    .push(format!("{} by {method:?} in {substeps} substeps {what}", scene.name));
            }
            seen += 1;
            failed += usize::from(bare.has_failed());
        }
    }
    assert!(seen >= 250 && failed < seen / 5, "{failed} of {seen} runs were refused");
    assert!(failures.is_empty(), "{} of {seen}:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn a_scene_goes_on_in_plain_arrays_from_where_it_is() {
    for scene in scenes().filter(|scene| scene.bodies.len() < 1000) {
        for method in Method::ALL {
            let mut twin = twin(scene.clone(), method, 1);
            twin.run(17);
            let mut bare = arrays(&mut twin);
            run(&mut bare, 20);
            let outcome = compare(&bare, &mut twin, |twin| twin.run(20));
            assert_eq!(outcome, Ok(()), "{} by {method:?}", scene.name);
        }
    }
}
