//! Mistakes that are easily made in the sources, and for each the test that has to fail.
//!
//! `cargo run -p acceptance --bin mutants` lists them. With `--run`, or `--run WORDS` for those that have these words, it
//! makes one after the other in a copy under `target/mutants` and fails if a test passes, or if the text that a mistake
//! replaces has changed: then say it anew here. Mistakes in a method are in `tests/methods/mutants`, and rejected in
//! every test run.
#![allow(clippy::print_stdout, reason = "it is a program")]

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

/// A mistake, made by an edit of the sources.
struct Mutant {
    /// What is wrong.
    mistake: &'static str,
    /// Path from the root of the repository.
    file: &'static str,
    /// A text that stands once in the file.
    from: &'static str,
    /// What replaces it.
    to: &'static str,
    /// The test that fails, by its path in the binary of the acceptance tests.
    killed_by: &'static str,
}

const MUTANTS: &[Mutant] = &[
    Mutant {
        mistake: "clamped damping without its clamp",
        file: "crates/motion/src/laws/damping.rs",
        from: "let factor = if q > T::ONE { stopped }",
        to: "let factor = if q > T::MAX { stopped }",
        killed_by: "damping::strong_damping_flips_the_tutorial_stops_clamped_and_decays_exactly",
    },
    Mutant {
        mistake: "forces not cleared",
        file: "crates/motion/src/state/forces.rs",
        from: "force.bypass_change_detection().0 = Vector::ZERO;",
        to: "force.bypass_change_detection().0 += Vector::ZERO;",
        killed_by: "newton::two_pushes_in_one_tick_add_and_a_push_is_gone_in_the_next",
    },
    Mutant {
        mistake: "the force of a spring on its second end rounded otherwise",
        file: "crates/motion/src/groups/pull.rs",
        from: "T::Lanes::of(simd, forces[b]) - pull;",
        to: "T::Lanes::of(simd, forces[b]) - pull * T::Lanes::splat(simd, T::of(1.0 + 1e-12));",
        killed_by: "groups::conserved::springs_and_mutual_gravity_keep_momentum_to_rounding_under_every_method",
    },
    Mutant {
        mistake: "compressed springs with their negative stiffness across",
        file: "crates/motion/src/groups/pull.rs",
        from: "if taut > T::ZERO { taut } else { T::ZERO }",
        to: "taut",
        killed_by: "groups::implicit::a_spring_of_half_its_length_comes_to_its_length",
    },
    Mutant {
        mistake: "time computed in single precision",
        file: "crates/motion/src/state/clock.rs",
        from: "let passed = self.carried + (frame.total - self.anchor) * self.pace * self.rate;",
        to: "let passed = self.carried + Scalar::from((frame.total - self.anchor) as f32) * self.pace * self.rate;",
        killed_by: "time::ticks_due_come_from_total_time_and_never_drift",
    },
    Mutant {
        mistake: "no limit of what a frame catches up with",
        file: "crates/motion/src/state/clock.rs",
        from: "        if owed > most {",
        to: "        if owed > most && most == 0 {",
        killed_by: "time::a_hitch_is_capped_and_its_dropped_time_is_reported",
    },
    Mutant {
        mistake: "a comparison that lets pass what is not a number",
        file: "crates/motion/src/real.rs",
        from: "self.bitcast::<$bytes<S>>().simd_eq(0).all_true()",
        to: "!(self.simd_lt(0.0) | self.simd_gt(0.0)).any_true()",
        killed_by: "quarantine::a_non_finite_push_freezes_its_body_and_no_other",
    },
    Mutant {
        mistake: "records of quarantine ordered by body over all ticks",
        file: "crates/motion/src/tick/quarantine.rs",
        from: "records[before..].sort_by_key",
        to: "records.sort_by_key",
        killed_by: "quarantine::records_are_in_the_order_of_ticks_and_within_a_tick_of_stable_ids",
    },
    Mutant {
        mistake: "a hash over bodies in the order of a hash table",
        file: "crates/history/src/simulation.rs",
        from: "let bodies = (0..).zip(&self.bodies);",
        to: "let bodies = (0..).zip(&self.bodies).collect::<std::collections::HashMap<u32, _>>().into_iter();",
        killed_by: "determinism::the_program_gives_the_pinned_hashes",
    },
    Mutant {
        mistake: "a restored snapshot forgets the steps that did not converge",
        file: "crates/history/src/snapshot/restore.rs",
        from: "unconverged_steps: counts.unconverged_steps,",
        to: "unconverged_steps: 0,",
        killed_by: "snapshot::steps_that_did_not_converge_are_counted_on",
    },
    Mutant {
        mistake: "the oldest keyframe takes the events of the new first tick with it",
        file: "crates/history/src/timeline.rs",
        from: "self.events.pop_front_if(|event| event.tick < first)",
        to: "self.events.pop_front_if(|event| event.tick <= first)",
        killed_by: "black_box::opened::a_bundle_of_the_last_minute_of_a_longer_run_with_inputs_repeats_it",
    },
    Mutant {
        mistake: "an energy jump hides a quarantine of the same tick",
        file: "crates/history/src/timeline/watch.rs",
        from: "self.look_for_quarantined(world).or(jump)",
        to: "jump.or(self.look_for_quarantined(world))",
        killed_by: "black_box::program::a_quarantine_wins_over_an_energy_jump_of_the_same_tick",
    },
    Mutant {
        mistake: "the last triangle of a surface on a ray in place of the closest",
        file: "crates/pick/src/soft.rs",
        from: "&& met.time_of_impact < closest",
        to: "&& met.time_of_impact < f32::INFINITY",
        killed_by: "soft_picking::of_the_layers_of_a_fold_the_closest_is_pushed",
    },
    Mutant {
        mistake: "a signal that unloads the graphics driver below its threads",
        file: "crates/sandbox/src/output/files.rs",
        from: "signal_hook::low_level::exit(code);",
        to: "std::process::exit(code);",
        killed_by: "outputs::on_unix::a_run_that_draws_ends_by_a_signal_at_any_moment_and_leaves_no_part_of_a_file",
    },
    Mutant {
        mistake: "a sweep that takes the files of runs that live",
        file: "crates/sandbox/src/output/files.rs",
        from: "            && file.try_lock().is_ok()\n",
        to: "            && file.metadata().is_ok()\n",
        killed_by: "outputs::on_unix::what_a_killed_run_leaves_is_swept_by_the_next_one_and_what_a_living_one_writes_is_not",
    },
    Mutant {
        mistake: "a scene that could not be saved is left",
        file: "crates/sandbox/src/window.rs",
        from: "Order::Quit | Order::Open(_) if unsaved => {}",
        to: "Order::Quit | Order::Open(_) if unsaved && false => {}",
        killed_by: "window::a_scene_that_could_not_be_saved_is_not_left",
    },
    Mutant {
        mistake: "undo and redo that drop what was set since",
        file: "crates/sandbox/src/app/editing.rs",
        from: "if let Ok(scene) = self.with_settings(&text, &settings) {",
        to: "if let Ok(scene) = self.with_settings(&text, &settings[..0]) {",
        killed_by: "editor::undo_and_redo_keep_a_method_that_was_chosen_after_the_change",
    },
    Mutant {
        mistake: "a scene that is saved without the effects that are switched off",
        file: "crates/sandbox/src/app/editing.rs",
        from: "changes.extend(off);",
        to: "drop(off);",
        killed_by: "editor::what_is_switched_off_stays_off_through_a_change_and_a_save",
    },
];

fn main() -> ExitCode {
    let arguments: Vec<_> = env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => {
            for (number, Mutant { mistake, file, killed_by, .. }) in (1..).zip(MUTANTS) {
                println!("{number:>2}. {mistake}\n    in {file}, killed by {killed_by}");
            }
            ExitCode::SUCCESS
        }
        ["--run"] => run(""),
        ["--run", words] => run(words),
        _ => {
            eprintln!("usage: mutants [--run [WORDS OF A MISTAKE]]");
            ExitCode::from(2)
        }
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
}

fn run(words: &str) -> ExitCode {
    let copy = root().join("target/mutants/copy");
    let mut failed = false;
    for mutant in MUTANTS.iter().filter(|mutant| mutant.mistake.contains(words)) {
        println!("{}", mutant.mistake);
        copy_sources(&copy);
        let verdict = make(&copy, mutant).and_then(|()| verdict(&copy, mutant.killed_by));
        failed |= verdict.is_err();
        println!("    {}", verdict.unwrap_or_else(|why| why));
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Makes the copy equal to the files that git knows here; files that are equal keep their times, and need no build.
fn copy_sources(copy: &Path) {
    let files = Command::new("git").arg("-C").arg(root()).args(["ls-files", "-z"]).output();
    let files = files.expect("git lists the sources").stdout;
    for file in String::from_utf8_lossy(&files).split('\0').filter(|file| !file.is_empty()) {
        let (from, to) = (root().join(file), copy.join(file));
        let Ok(text) = fs::read(&from) else { continue };
        if fs::read(&to).is_ok_and(|old| old == text) {
            continue;
        }
        fs::create_dir_all(to.parent().expect("a file is in a folder")).expect("folders can be made");
        fs::write(&to, text).expect("files can be written");
    }
}

fn make(copy: &Path, mutant: &Mutant) -> Result<(), String> {
    let Mutant { file, from, to, .. } = mutant;
    let path = copy.join(file);
    let text = fs::read_to_string(&path).map_err(|error| format!("{file}: {error}"))?;
    match text.matches(from).count() {
        1 => fs::write(&path, text.replace(from, to)).map_err(|error| format!("{file}: {error}")),
        times => Err(format!("{file} has {times} times {from:?}; say it anew in tests/bin/mutants.rs")),
    }
}

/// What becomes of the test; an error if it does not fail.
fn verdict(copy: &Path, test: &str) -> Result<String, String> {
    let cargo = |arguments: &[&str]| {
        Command::new(env!("CARGO"))
            .args(arguments)
            .current_dir(copy)
            .env("CARGO_TARGET_DIR", root().join("target/mutants/build"))
            .output()
            .expect("cargo can be started")
    };
    let build = cargo(&["build", "--locked", "-p", "sandbox"]);
    let tests = cargo(&["test", "--locked", "-p", "acceptance", "--test", "acceptance", "--no-run"]);
    if !build.status.success() || !tests.status.success() {
        let text = [build.stderr, tests.stderr].concat();
        return Err(format!("does not compile:\n{}", String::from_utf8_lossy(&text)));
    }
    let result =
        cargo(&["test", "--locked", "-p", "acceptance", "--test", "acceptance", "--", "--exact", test]);
    let said = String::from_utf8_lossy(&result.stdout);
    if said.contains("1 passed") {
        Err(format!("SURVIVED {test}"))
    } else if said.contains("1 failed") {
        Ok(format!("killed by {test}"))
    } else {
        Err(format!("{test} was not run:\n{said}"))
    }
}
