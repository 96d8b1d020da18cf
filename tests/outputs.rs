//! Files that the program writes: they keep what was there, are whole whenever a run ends, and are written over nothing else.

use std::fs;
use std::path::Path;
use std::process::Command;

use render::Image;
use serde_json::Value;

use crate::black_box::with_a_fault;
use crate::rigs::{command_lines, folder, listing, output, program, sandbox, sealed, wait_for};

/// A scene that falls, for as long as it is asked to.
const FALL: &str = "(version: 1, gravity: (), bodies: [(name: \"ball\")])";

/// Lines of `sandbox` that end with a fault of their flags and leave every file as it was.
#[track_caller]
fn is_refused(folder: &Path, line: &str, words: &str) {
    let contents = || {
        let files = listing(folder).into_iter();
        files.map(|path| (fs::read(&path).ok(), path)).collect::<Vec<_>>()
    };
    let before = contents();
    sandbox(folder, line).fails(2, words);
    assert_eq!(contents(), before, "{line}");
}

#[cfg(unix)]
mod on_unix {
    use std::os::unix::fs::PermissionsExt as _;
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::{Child, Stdio};
    use std::thread::{scope, sleep};
    use std::time::Instant;

    use lab::cost::{Machine, Report};

    use super::*;
    use crate::rigs::{Dice, root};

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    fn set_mode(path: &Path, mode: u32) {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn standard_output_by_name_is_the_stream_also_where_a_shell_sends_it_to_a_file() {
        let folder = folder([("fine.ron", FALL)]);
        let line =
            "(echo first; \"$0\" run fine.ron --ticks 2 --state /dev/stdout; echo last) > all.txt";
        output(Command::new("sh").args(["-c", line]).arg(program()).current_dir(&folder)).fine();
        let all = fs::read_to_string(folder.path().join("all.txt")).unwrap();
        assert!(
            all.starts_with("first\n")
                && all.ends_with("last\n")
                && all.contains("tick,time_s,body,"),
            "{all}"
        );
    }

    #[test]
    fn a_replaced_file_keeps_its_permissions_and_a_new_one_has_those_of_the_umask() {
        let folder = folder([("fine.ron", FALL), ("private.csv", ""), ("shared.csv", "")]);
        let at = |name: &str| folder.path().join(name);
        set_mode(&at("private.csv"), 0o600);
        set_mode(&at("shared.csv"), 0o664);
        for (name, expected) in [("private.csv", 0o600), ("shared.csv", 0o664), ("new.csv", 0o640)]
        {
            let line = format!("umask 027; exec \"$0\" run fine.ron --ticks 2 --state {name}");
            output(Command::new("sh").args(["-c", &line]).arg(program()).current_dir(&folder))
                .fine();
            assert!(fs::read_to_string(at(name)).unwrap().starts_with("tick,"));
            assert_eq!(format!("{:o}", mode(&at(name))), format!("{expected:o}"), "{name}");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_scene_may_have_a_path_that_is_no_text() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt as _;
        let folder = folder([("fine.ron", FALL)]);
        let name = OsStr::from_bytes(b"caf\xe9.ron");
        fs::rename(folder.path().join("fine.ron"), folder.path().join(name)).unwrap();
        for command in [&["run", "--ticks", "2"][..], &["plan"], &["effects", "--ticks", "2"]] {
            output(Command::new(program()).args(command).arg(name).current_dir(&folder)).fine();
        }
        let mut same = Command::new(program());
        same.arg("run")
            .arg(name)
            .args(["--ticks", "2", "--summary"])
            .arg(name)
            .current_dir(&folder);
        output(&mut same).fails(2, "the scene and --summary name the same file; give two");
    }

    #[test]
    fn a_replaced_file_is_no_program_of_another_user() {
        let folder = folder([("fine.ron", FALL), ("out.csv", "")]);
        let path = folder.path().join("out.csv");
        set_mode(&path, 0o6755);
        sandbox(&folder, "run fine.ron --ticks 2 --state out.csv").fine();
        assert_eq!(
            format!("{:o}", fs::metadata(&path).unwrap().permissions().mode() & 0o7777),
            "755"
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn limits_of_the_shell_are_told_in_words_and_leave_nothing() {
        let folder = folder([("fine.ron", FALL)]);
        let run = |line: &str| {
            output(Command::new("bash").args(["-c", line]).arg(program()).current_dir(&folder))
        };
        let said = run("ulimit -f 8; exec \"$0\" run fine.ron --ticks 10000 --state big.csv");
        said.fails(
            2,
            "cannot write big.csv: the file would be larger than is allowed; see `ulimit -f`",
        );
        let said = run("ulimit -v 400000; exec \"$0\" run fine.ron --ticks 2 --film film.png");
        said.fails(4, "drawing pictures takes about 640.0 MiB of address space, and ");
        assert_eq!(listing(folder.path()), [folder.path().join("fine.ron")]);
    }

    #[test]
    fn a_file_that_is_led_to_standard_output_is_alone_there() {
        let folder = folder([("fine.ron", FALL)]);
        let run = |flag: &str| {
            let line =
                format!("\"$0\" run fine.ron --ticks 2 --size 16x16 {flag} /dev/stdout > out");
            let said =
                output(Command::new("sh").args(["-c", &line]).arg(program()).current_dir(&folder))
                    .ends(0);
            assert!(said.err.contains("state_hash"), "{}", said.all());
            fs::read(folder.path().join("out")).unwrap()
        };
        let film = run("--film");
        assert!(film.starts_with(b"\x89PNG") && film.ends_with(b"IEND\xae\x42\x60\x82"));
        let summary: Value = serde_json::from_slice(&run("--summary")).unwrap();
        assert_eq!(summary["ticks"], 2);
        assert!(run("--state").starts_with(b"tick,time_s"));
    }

    #[test]
    fn a_read_only_file_is_not_replaced() {
        let folder = folder([("fine.ron", FALL), ("out.csv", "mine")]);
        set_mode(&folder.path().join("out.csv"), 0o444);
        is_refused(
            folder.path(),
            "run fine.ron --ticks 2 --state out.csv",
            "cannot write out.csv: it is not permitted",
        );
    }

    #[test]
    fn a_run_without_standard_output_says_that_its_results_are_lost_and_writes_its_files() {
        let folder = folder([("fine.ron", FALL)]);
        let line = "exec \"$0\" run fine.ron --ticks 2 --summary out.json >&-";
        let said =
            output(Command::new("sh").args(["-c", line]).arg(program()).current_dir(&folder));
        said.says(
            2,
            "sandbox: cannot write standard output: it is closed; redirect it to a file, or to /dev/null\n",
        );
        assert!(folder.path().join("out.json").exists());
        let line = "exec \"$0\" run fine.ron --ticks 2 >/dev/null";
        output(Command::new("sh").args(["-c", line]).arg(program()).current_dir(&folder))
            .says(0, "");
    }

    /// A run without an end that draws.
    struct Endless(Child);

    impl Endless {
        fn start(folder: &Path, line: &str) -> Self {
            // A test that runs in the background of a script has learned to ignore interrupts.
            let mut env = Command::new("env");
            env.arg("--default-signal=INT,TERM,HUP")
                .arg(program())
                .args(line.split(' '))
                .current_dir(folder);
            let env = env.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
            Self(env.spawn().unwrap())
        }

        fn signal(&self, signal: &str) {
            output(Command::new("kill").args([signal, &self.0.id().to_string()])).fine();
        }
    }

    impl Drop for Endless {
        fn drop(&mut self) {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }

    fn unfinished(folder: &Path) -> Vec<String> {
        let names = listing(folder)
            .into_iter()
            .map(|path| path.file_name().unwrap().to_string_lossy().into_owned());
        names.filter(|name| name.starts_with(".sandbox-")).collect()
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_run_that_draws_ends_by_a_signal_at_any_moment_and_leaves_no_part_of_a_file() {
        const LINE: &str = "run fine.ron --ticks 1000000000000 --frames out --frame-every 50 --size 64x64 --film film.png";
        const SIGNALS: [(&str, i32); 3] = [("-HUP", 1), ("-INT", 2), ("-TERM", 15)];
        let (start, first) = (Instant::now(), folder([("fine.ron", FALL)]));
        let run = Endless::start(first.path(), LINE);
        wait_for("the second picture", || {
            first.path().join("out/frame_000050.png").exists().then_some(())
        });
        let started = start.elapsed();
        drop(run);
        let signaled = |dice: &mut Dice| {
            let folder = folder([("fine.ron", FALL)]);
            let (signal, number) = SIGNALS[dice.below(3)];
            let mut run = Endless::start(folder.path(), LINE);
            // From the first instruction to some time after drawing began.
            sleep(started.mul_f64(0.75 * (1.0 + dice.number())));
            run.signal(signal);
            let status = run.0.wait().unwrap();
            // At first the signal itself ends it.
            let ended = status.code() == Some(128 + number) || status.signal() == Some(number);
            assert!(ended, "{signal} was answered by {status}");
            assert_eq!(unfinished(folder.path()), [] as [String; 0]);
        };
        // Several at a time, so that the machine is busy.
        scope(|threads| {
            for seed in 0..5 {
                threads.spawn(move || {
                    let mut dice = Dice(seed);
                    (0..20).for_each(|_| signaled(&mut dice));
                });
            }
        });
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn what_a_killed_run_leaves_is_swept_by_the_next_one_and_what_a_living_one_writes_is_not() {
        let folder = folder([("fine.ron", FALL), ("out/.sandbox-notes", "mine")]);
        let out = folder.path().join("out");
        let start = |state: &str| {
            let before = unfinished(&out);
            let run = Endless::start(
                folder.path(),
                &format!("run fine.ron --ticks 1000000000000 --state out/{state}.csv"),
            );
            wait_for("its file", || {
                (unfinished(&out).len() == 2 && unfinished(&out) != before).then_some(())
            });
            run
        };
        let killed = start("killed");
        let left = unfinished(&out);
        killed.signal("-KILL");
        drop(killed);
        assert_eq!(unfinished(&out), left);
        let living = start("living");
        let of_living = unfinished(&out);
        sandbox(&folder, "run fine.ron --ticks 2 --state out/third.csv").fine();
        assert_eq!(unfinished(&out), of_living);
        living.signal("-TERM");
        wait_for("its end", || (unfinished(&out) == [".sandbox-notes"]).then_some(()));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_second_of_two_studies_into_a_folder_is_told_until_the_first_has_ended() {
        let folder = folder([("fine.ron", FALL)]);
        let first = Endless::start(folder.path(), "cost tutorial --out study");
        wait_for("its report", || folder.path().join("study/report.json").exists().then_some(()));
        let second = "stability at_rest --ticks 1 --out study";
        for line in ["cost kepler --quick --replace --out study", second] {
            sandbox(&folder, line).fails(2, "study: another study writes into this folder");
        }
        first.signal("-KILL");
        drop(first);
        sandbox(&folder, "cost kepler --quick --out study")
            .fails(2, "study/report.json: this is the report of `sandbox cost tutorial`");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_report_of_another_origin_is_replaced_only_where_that_is_asked_for() {
        let folder = folder([("study/report.json", "mine"), ("study/summary.md", "mine")]);
        let path = folder.path().join("study/report.json");
        is_refused(
            folder.path(),
            "cost kepler --quick --out study",
            "study/report.json: not a report",
        );
        let stored = fs::read_to_string(root().join("docs/cost/report.json")).unwrap();
        let mut report: Report = serde_json::from_str(&stored).unwrap();
        report.command = "sandbox cost kepler --quick".to_owned();
        let store = |report: &Report| {
            fs::write(&path, sealed(&serde_json::to_string(report).unwrap())).unwrap();
        };
        report.machine.processor += " of another machine";
        store(&report);
        let words = "this report was made by another version or on another machine; give another folder, or --replace";
        is_refused(folder.path(), "cost kepler --quick --out study", words);
        report.machine = Machine::here();
        report.format -= 1;
        store(&report);
        is_refused(folder.path(), "cost kepler --quick --out study", words);
        report.format += 1;
        store(&report);
        let words = "this is the report of `sandbox cost kepler --quick`";
        is_refused(folder.path(), "cost duffing --quick --out study", words);
        let words = "this report has a study of kepler, which is not asked for";
        is_refused(folder.path(), "cost duffing --quick --out study --resume", words);
        for flag in ["--replace", "--resume", "--replace"] {
            let line = &format!("cost duffing --quick --out study {flag}");
            let before = fs::read(&path).unwrap();
            let _study = Endless::start(folder.path(), line);
            wait_for("its report", || (fs::read(&path).unwrap() != before).then_some(()));
        }
        let words = "study/report.json: this report is not complete; --resume continues it, --replace writes over it";
        is_refused(folder.path(), "cost duffing --quick --out study", words);
    }
}

#[test]
fn a_bundle_is_not_written_over_by_what_is_unpacked_from_it() {
    let (bundle, _) = with_a_fault();
    let bytes = bundle.write().unwrap();
    for name in ["scene.ron", "state.csv", "picture.png", "summary.json"] {
        let folder = folder([(name, &bytes)]);
        is_refused(
            folder.path(),
            &format!("replay {name} --out ."),
            &format!("{name} is a name of the files that --out writes; give another folder"),
        );
    }
}

#[test]
fn the_first_look_without_a_display_is_four_pictures_of_its_own_look_with_captions() {
    let folder = tempfile::tempdir().unwrap();
    let script = crate::rigs::root().join("assets/scripts/first_look.ron");
    let line =
        format!("run tutorial --script {} --seconds 5 --size 640x360 --captions", script.display());
    sandbox(&folder, &line).fine();
    let names = ["1_at_rest.png", "2_pushed.png", "3_through_the_floor.png", "4_ledger.png"];
    let pictures = names.map(|name| {
        let file = fs::File::open(folder.path().join(name)).unwrap();
        Image::decode_png(std::io::BufReader::new(file)).unwrap()
    });
    assert_eq!(listing(folder.path()).len(), names.len());
    // The ground of the program's own look is light; the tutorial's floor is a dark checker.
    for picture in &pictures {
        assert!(picture.pixel(20, 300).unwrap()[..3].iter().all(|channel| *channel > 150));
    }
    // The words of each: white pixels with a dark rim at the bottom left.
    let words = |picture: &Image| picture.crop([0, 330], [600, 28]).unwrap();
    assert!((1..4).all(|n| words(&pictures[n]) != words(&pictures[n - 1])));
}

#[test]
fn a_script_that_presses_the_key_of_screenshots_writes_them_without_other_pictures() {
    let folder =
        folder([("fine.ron", FALL), ("f12.script", "[(at_frame: 2, do: press(\"F12\"))]")]);
    sandbox(
        &folder,
        "run fine.ron --seconds 0.1 --size 16x16 --script f12.script --summary out.json",
    )
    .fine();
    let picture = Image::read_png(folder.path().join("screenshot_000002.png")).unwrap();
    assert_eq!(picture.size_px, [16, 16]);
    let summary: Value =
        serde_json::from_slice(&fs::read(folder.path().join("out.json")).unwrap()).unwrap();
    assert_eq!(summary["frames"], 1);
}

#[test]
fn no_command_writes_over_what_it_reads_or_what_it_did_not_write() {
    command_lines("outputs");
}

/// A lesson over the scene "oscillator" with a run of other.ron, whose solution saves what can be saved.
const LESSON: &str = r#"(
    version: 1, title: "T", about: "A.", page: "P", scene: "oscillator",
    measure: (x: position("ball", x)),
    runs: [(scene: "other.ron", seconds: 0.1, measure: (e: energy))],
    steps: [(
        task: "Push it.", done: "x > x_before + 0.5",
        solution: [press("Ctrl+S"), press("F12"), push("ball", (5000, 0, 0))],
        wrong: [[press("Ctrl+S"), press("G")], [push("ball", (-50, 0, 0))]],
        then: "At {x} m.", holds: "x > 3",
    )],
)"#;

#[test]
#[cfg(target_os = "linux")]
fn a_recording_is_not_written_over_the_settings_of_the_window() {
    let folder = folder([("w.ron", FALL), ("config/inertia/window", "settings")]);
    let config = folder.path().join("config");
    let mut record = Command::new(program());
    record.args(["w.ron", "--record", "config/inertia/window"]).env("XDG_CONFIG_HOME", &config);
    output(record.current_dir(&folder))
        .fails(2, "the window's settings and --record name the same file; give two");
    assert_eq!(fs::read_to_string(config.join("inertia/window")).unwrap(), "settings");
}

#[test]
fn a_lesson_that_saves_writes_nothing_where_no_folder_is_named() {
    let folder = folder([("my.ron", LESSON), ("other.ron", FALL), ("bundle.zip", "mine")]);
    let before = listing(folder.path());
    sandbox(&folder, "lessons check my.ron").fine();
    let line = "run oscillator --lesson my.ron --seconds 6 --fps 10 --size 16x16";
    let said = sandbox(&folder, line).ends(0);
    let words = "the bundle of the lesson is not written; name a folder for it with --frames";
    assert!(said.err.contains(words), "{}", said.all());
    assert_eq!(listing(folder.path()), before);
    assert_eq!(fs::read_to_string(folder.path().join("bundle.zip")).unwrap(), "mine");
    sandbox(&folder, &format!("{line} --frames out --frame-every 1000")).fine();
    let written = listing(&folder.path().join("out"));
    let ends =
        |end: &str| written.iter().any(|path| path.extension().is_some_and(|found| found == end));
    assert!(ends("zip") && ends("png"), "{written:?}");
}
