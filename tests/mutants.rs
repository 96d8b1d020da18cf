//! Mistakes that are easily made, and for each the test that fails when it is made.
//!
//! Mistakes in a method are kept as broken methods beside the tests, which reject them in every run. Others are edits of
//! the sources: `cargo run -p acceptance --bin mutants` lists all, with `--run` it makes the edits one after the other in a
//! copy and runs the tests that have to fail.

/// A mistake.
#[derive(Clone, Copy, Debug)]
pub struct Mutant {
    /// What is wrong.
    pub mistake: &'static str,
    /// How it is made.
    pub made: Made,
    /// The test that fails, by its path in the binary of the acceptance tests.
    pub killed_by: &'static str,
}

/// How a mistake is made.
#[derive(Clone, Copy, Debug)]
pub enum Made {
    /// By broken code in a file beside the tests, which has these words for it.
    BesideTheTests(&'static str, &'static [&'static str]),
    /// By edits of the sources.
    ByEdits(&'static [Edit]),
}

/// A text that stands once in a file, and what replaces it.
#[derive(Clone, Copy, Debug)]
pub struct Edit {
    /// Path from the root of the repository.
    pub file: &'static str,
    /// The text.
    pub from: &'static str,
    /// What replaces it.
    pub to: &'static str,
}

const fn method(mistake: &'static str, names: &'static [&'static str]) -> Mutant {
    let made = Made::BesideTheTests("tests/methods/mutants/broken.rs", names);
    Mutant { mistake, made, killed_by: "methods::mutants::every_broken_method_is_rejected" }
}

const fn edited(mistake: &'static str, edits: &'static [Edit], killed_by: &'static str) -> Mutant {
    Mutant { mistake, made: Made::ByEdits(edits), killed_by }
}

/// All of them.
pub const MUTANTS: &[Mutant] = &[
    method(
        "the order of the two updates swapped",
        &["semi-implicit Euler, order swapped", "explicit Euler, order swapped"],
    ),
    method(
        "one evaluation of the forces for all stages",
        &[
            "midpoint, forces of the start",
            "Heun, forces of the start",
            "Runge-Kutta 4, forces of the start",
            "velocity Verlet, forces of the start",
        ],
    ),
    method("implicit Euler with the forces of the start", &["implicit Euler, forces of the start"]),
    method("Runge-Kutta 4 with equal weights", &["Runge-Kutta 4, equal weights"]),
    method(
        "stages at the time of the start",
        &["Runge-Kutta 4, stages at the start", "midpoint, stage at the start", "Heun, stage at the start"],
    ),
    method("Heun without the mean of both slopes", &["Heun, slope of the end"]),
    method("position Verlet started without a h²/2", &["position Verlet, no Taylor start"]),
    method("position Verlet with the origin for the last position", &["position Verlet, from the origin"]),
    method("velocity Verlet with the drag of the start at the end", &["velocity Verlet, drag of the start"]),
    method("position Verlet as 2 x - x0 + a h² in single precision", &["position Verlet, of two positions"]),
    method("damping at every stage", &["Runge-Kutta 4, damped at every stage"]),
    method("damping twice in a substep", &["semi-implicit Euler, damped twice"]),
    method(
        "damping before the move instead of after it, and the other way round",
        &[
            "semi-implicit Euler, tutorial's damping before the move",
            "semi-implicit Euler, clamped damping after the move",
        ],
    ),
    edited(
        "clamped damping without its clamp",
        &[Edit {
            file: "crates/motion/src/effects.rs",
            from: "let factor = if q > T::ONE { stopped }",
            to: "let factor = if q > T::MAX { stopped }",
        }],
        "damping::strong_damping_flips_the_tutorial_stops_clamped_and_decays_exactly",
    ),
    Mutant {
        mistake: "gravity on what has inverse mass 0",
        made: Made::BesideTheTests("tests/methods/mutants.rs", &["gravity_on_immovable_bodies_is_rejected"]),
        killed_by: "methods::mutants::gravity_on_immovable_bodies_is_rejected",
    },
    Mutant {
        mistake: "gravity multiplied by the inverse mass",
        made: Made::BesideTheTests("tests/methods/mutants.rs", &["gravity_by_mass_is_rejected"]),
        killed_by: "methods::mutants::gravity_by_mass_is_rejected",
    },
    edited(
        "forces not cleared",
        &[Edit {
            file: "crates/motion/src/forces.rs",
            from: "force.bypass_change_detection().0 = Vector::ZERO;",
            to: "force.bypass_change_detection().0 += Vector::ZERO;",
        }],
        "newton::two_pushes_in_one_tick_add_and_a_push_is_gone_in_the_next",
    ),
    method("forces cleared between stages", &["Runge-Kutta 4, pushed at one stage"]),
    method("a push once a stage", &["Runge-Kutta 4, pushed at every stage"]),
    edited(
        "the force of a spring on its second end rounded otherwise",
        &[Edit {
            file: "crates/motion/src/groups/pull.rs",
            from: "T::Lanes::of(simd, forces[b]) - pull;",
            to: "T::Lanes::of(simd, forces[b]) - pull * T::Lanes::splat(simd, T::of(1.0 + 1e-12));",
        }],
        "groups::conserved::springs_and_mutual_gravity_keep_momentum_to_rounding_under_every_method",
    ),
    edited(
        "compressed springs with their negative stiffness across",
        &[Edit {
            file: "crates/motion/src/groups/pull.rs",
            from: "if taut > T::ZERO { taut } else { T::ZERO }",
            to: "taut",
        }],
        "groups::implicit::a_spring_of_half_its_length_comes_to_its_length",
    ),
    Mutant {
        mistake: "conjugate gradients preconditioned by the diagonal and stopped after 3 iterations",
        made: Made::BesideTheTests("tests/groups/implicit.rs", &["gradients(&net, &diagonal, 3)"]),
        killed_by: "groups::implicit::an_iteration_that_is_stopped_early_keeps_momentum",
    },
    edited(
        "time reckoned in single precision",
        &[Edit {
            file: "crates/motion/src/clock.rs",
            from: "let passed = self.carried + (frame.total - self.anchor) * self.pace * self.rate;",
            to: "let passed = self.carried + Scalar::from((frame.total - self.anchor) as f32) * self.pace * self.rate;",
        }],
        "time::ticks_due_come_from_total_time_and_never_drift",
    ),
    edited(
        "no limit of what a frame catches up with",
        &[Edit {
            file: "crates/motion/src/clock.rs",
            from: "        if owed > most {",
            to: "        if owed > most && most == 0 {",
        }],
        "time::a_hitch_is_capped_and_its_dropped_time_is_reported",
    ),
    edited(
        "a comparison that lets pass what is not a number",
        &[Edit {
            file: "crates/motion/src/real.rs",
            from: "self.bitcast::<$bytes<S>>().simd_eq(0).all_true()",
            to: "!(self.simd_lt(0.0) | self.simd_gt(0.0)).any_true()",
        }],
        "quarantine::a_non_finite_push_freezes_its_body_and_no_other",
    ),
    edited(
        "a hash over bodies in the order of a hash table",
        &[Edit {
            file: "crates/sandbox/src/session/read.rs",
            from: "self.entities.iter().copied().filter(",
            to: "self.ids.keys().copied().filter(",
        }],
        "determinism::the_program_gives_the_pinned_hashes",
    ),
    method(
        "position Verlet without the ratio of changing steps",
        &["position Verlet, no ratio of steps", "position Verlet, half the ratio"],
    ),
];
