//! What a person gets wrong: each case of bad input with its exit code and our message, word for word.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::rigs::{
    self, Said, command_lines, commands, contents, listing, output, program, sandbox, wait_for,
    without_display,
};

fn folder() -> TempDir {
    rigs::folder([
        ("fine.ron", r#"(version: 1, gravity: (), bodies: [(name: "ball")])"#),
        ("damped.ron", "(version: 1, damping: (rate_per_s: 0.4))"),
        ("folder/inside.txt", ""),
        ("file", "not a folder"),
        ("shot.script", r#"[(at_s: 0.5, do: screenshot("shot.png"))]"#),
        (
            "recorded.script",
            r#"(version: 1, scene: "tutorial", size_px: (16, 16), frame_ends_s: [0.1, 0.2], steps: [])"#,
        ),
    ])
}

fn write(folder: &Path, name: &str, bytes: &str) {
    fs::write(folder.join(name), bytes).unwrap();
}

fn run(folder: &Path, line: &str) -> Said {
    without_display(folder, line, &[])
}

/// Runs `line` in a folder of its own and fails if it leaves or changes anything there.
fn refused(line: &str, variables: &[(&str, &str)]) -> Said {
    let folder = folder();
    let before = contents(folder.path());
    let said = without_display(folder.path(), line, variables);
    assert!(contents(folder.path()) == before, "{line}: a file was left behind or changed");
    assert_eq!(said.out, "", "{line}: printed results");
    said
}

/// The same, and fails unless it ends with `code` and one line that begins so.
#[track_caller]
fn refused_in_a_line(line: &str, variables: &[(&str, &str)], code: i32, start: &str) {
    let said = refused(line, variables).ends(code);
    assert!(said.err.lines().count() == 1 && said.err.starts_with(start), "{}", said.all());
}

/// Each option of each command that takes a value, without one.
#[test]
fn every_command_refuses_unknown_flags_and_options_without_their_value() {
    let mut seen = 0;
    for command in commands() {
        let help = sandbox(".", &format!("{command} --help")).fine();
        let options = help.lines().map(str::trim_start).filter(|line| line.starts_with("--"));
        let options: Vec<_> = options
            .filter(|line| line.split_whitespace().nth(1).is_some_and(|word| word.starts_with('<')))
            .collect();
        for option in options
            .iter()
            .map(|line| line.split_whitespace().next().unwrap())
            .chain(["--no-such-flag"])
        {
            let said = sandbox(".", &format!("{command} {option}"));
            assert!(
                said.code == 2 && said.err.contains(option),
                "{command} {option}: {}",
                said.all()
            );
            seen += 1;
        }
    }
    assert!(seen > 50, "only {seen} options");
}

#[test]
fn bad_input_is_refused_with_a_message_that_names_the_cure() {
    command_lines("bad_input");
}

#[test]
fn runs_write_what_they_should_and_say_what_went_wrong() {
    command_lines("runs");
}

#[test]
#[cfg(target_os = "linux")]
fn devices_and_links_are_not_replaced() {
    command_lines("devices_and_links");
}

#[test]
fn bytes_that_are_no_plain_text_are_refused() {
    let latin: &[u8] = b"(version: 1,\n name: \"caf\xe9\")";
    let folder = folder();
    fs::write(folder.path().join("latin.ron"), latin).unwrap();
    write(folder.path(), "key.ron", "(version: 1, \u{9b}2J: 1)");
    for line in ["run latin.ron", "run fine.ron --script latin.ron"] {
        let message = "sandbox: latin.ron: line 2 is not UTF-8 text; save the file as UTF-8\n";
        run(folder.path(), line).says(2, message);
    }
    let words = "a bare word is expected here; write it without quotes";
    run(folder.path(), "run key.ron")
        .says(2, &format!("sandbox: key.ron:1:14: \\u{{9b}}2J: {words}\n"));
}

#[test]
fn a_window_that_cannot_open_says_so_in_one_line_that_names_the_way_without_one() {
    let message = "sandbox: no display found; type `sandbox run fine.ron` to run without a window, `sandbox --help` for everything else (";
    for variables in [[("DISPLAY", ":4711")], [("WAYLAND_DISPLAY", "gone")]] {
        refused_in_a_line("fine.ron --record out.ron", &variables, 5, message);
    }
}

/// No driver can be found with these.
const NO_DRIVERS: [(&str, &str); 2] =
    [("VK_ICD_FILENAMES", "/nonexistent"), ("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent")];

#[test]
#[cfg(target_os = "linux")]
fn without_an_adapter_a_run_with_pictures_ends_and_one_without_does_not() {
    let message = "sandbox: no graphics adapter found; a GPU is not required: on Debian or Ubuntu install \
                   `mesa-vulkan-drivers` (software rendering), or run without pictures (";
    for line in [
        "run fine.ron --ticks 2 --frames pictures --state out.csv --summary out.json",
        "run fine.ron --ticks 2 --script shot.script",
    ] {
        refused_in_a_line(line, &NO_DRIVERS, 4, message);
    }
    let folder = folder();
    without_display(folder.path(), "run fine.ron --ticks 2", &NO_DRIVERS).fine();
}

#[test]
fn an_adapter_that_is_not_there_is_named_beside_those_that_are() {
    let message = "sandbox: WGPU_ADAPTER_NAME is `nonsense`, but no usable adapter has that in its name; found: ";
    let line = "run fine.ron --ticks 2 --frames pictures";
    refused_in_a_line(line, &[("WGPU_ADAPTER_NAME", "nonsense")], 4, message);
}

#[test]
fn a_picture_that_no_adapter_can_draw_is_a_bad_size_and_not_a_missing_adapter() {
    let message = "sandbox: --size: a picture of 16384 x 16384 pixels cannot be drawn: ";
    refused_in_a_line(
        "run fine.ron --ticks 2 --frames pictures --size 16384x16384",
        &[],
        2,
        message,
    );
}

#[test]
fn a_picture_that_cannot_be_written_ends_the_run_without_a_part_of_a_file() {
    let folder = folder();
    fs::create_dir_all(folder.path().join("pictures/frame_000001.png/taken")).unwrap();
    let before = listing(folder.path());
    let line =
        "run fine.ron --ticks 9 --frames pictures --state out.csv --summary out.json --size 16x16";
    run(folder.path(), line).warns(2, "\nsandbox: cannot write pictures/frame_000001.png: ");
    let mut expected = before;
    expected.push(folder.path().join("pictures/frame_000000.png"));
    expected.sort();
    assert_eq!(listing(folder.path()), expected);
}

#[test]
#[cfg(target_os = "linux")]
fn places_that_take_no_files_are_refused() {
    for place in ["/proc", "/sys"] {
        for line in [
            format!("--state {place}/out.csv --summary out.json"),
            format!("--summary {place}/out.json"),
        ] {
            let said = refused(&format!("run fine.ron --ticks 2 {line}"), &[]).ends(2);
            let named = said.err.starts_with(&format!("sandbox: cannot write {place}/out."));
            assert!(
                named && said.err.lines().count() == 1 && !said.err.contains(".sandbox-"),
                "{}",
                said.err
            );
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_is_told() {
    let folder = folder();
    // The shell leads standard output to where nothing can be written.
    let mut shell = Command::new("sh");
    let said = output(
        shell.args(["-c", "\"$0\" list methods > /dev/full"]).arg(program()).current_dir(&folder),
    );
    said.warns(2, "cannot write standard output: the disk is full");
}

/// Sends `signals` to a run without an end, started with the signal `ignored`: its exit code, once it has left nothing.
#[cfg(target_os = "linux")]
fn ended_by(signals: &[&str], ignored: Option<&str>) -> Option<i32> {
    let folder = folder();
    let before = listing(folder.path());
    let line =
        "run fine.ron --ticks 1000000000000 --state out.csv --summary out.json --black-box out.zip";
    // A test that runs in the background of a script has learned to ignore interrupts.
    let mut env = Command::new("env");
    env.arg("--default-signal=INT,TERM,HUP")
        .args(ignored.map(|signal| format!("--ignore-signal={signal}")));
    let run = env
        .arg(program())
        .args(line.split(' '))
        .current_dir(&folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let mut run = run.spawn().unwrap();
    wait_for("the files of the run", || {
        assert!(run.try_wait().unwrap().is_none(), "it has ended by itself");
        (listing(folder.path()).len() == before.len() + 3).then_some(())
    });
    for signal in signals {
        assert!(
            output(Command::new("kill").args([signal, run.id().to_string().as_str()])).code == 0
        );
    }
    let status = wait_for("the end of the run", || run.try_wait().unwrap());
    assert_eq!(listing(folder.path()), before, "{signals:?}");
    status.code()
}

#[test]
#[cfg(target_os = "linux")]
fn a_run_that_a_signal_ends_leaves_nothing() {
    for (signal, code) in [("-HUP", 129), ("-INT", 130), ("-TERM", 143)] {
        assert_eq!(ended_by(&[signal], None), Some(code), "{signal}");
    }
    // As under `nohup`.
    assert_eq!(ended_by(&["-HUP", "-TERM"], Some("HUP")), Some(143));
}

#[test]
#[cfg(target_os = "linux")]
fn a_run_with_pictures_says_nothing_about_displays_where_nothing_is_wrong() {
    let folder = folder();
    let mut command = Command::new(program());
    command
        .args(["run", "fine.ron", "--ticks", "2", "--frames", "folder", "--size", "16x16"])
        .current_dir(&folder);
    for variable in
        ["XDG_RUNTIME_DIR", "DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET", "NODEVICE_SELECT"]
    {
        command.env_remove(variable);
    }
    let said = output(&mut command);
    let told = said.ends(0).err;
    assert!(told.starts_with("drawing with ") && told.lines().count() == 1, "{told}");
}

/// Devices are reached by links: a program that renames over what it writes destroys the link and no device.
#[cfg(target_os = "linux")]
fn with_link(to: &str) -> TempDir {
    let folder = folder();
    std::os::unix::fs::symlink(to, folder.path().join("link")).unwrap();
    folder
}

#[test]
#[cfg(target_os = "linux")]
fn a_device_is_written_to_and_not_replaced_and_a_link_stays_a_link() {
    let folder = with_link("/dev/null");
    run(folder.path(), "run fine.ron --ticks 2 --state link").fine();
    assert!(folder.path().join("link").is_symlink());
    let folder = with_link("file");
    run(folder.path(), "run fine.ron --ticks 2 --state link").fine();
    assert!(folder.path().join("link").is_symlink());
    assert!(
        fs::read_to_string(folder.path().join("file")).unwrap().starts_with("tick,time_s,body,")
    );
    let folder = with_link("/dev/stdout");
    let out = run(folder.path(), "run fine.ron --ticks 2 --summary link").fine();
    assert!(out.contains("\"scene\": \"fine\""), "{out}");
}

#[test]
fn a_good_run_is_exit_code_0_and_says_nothing_on_standard_error() {
    let folder = folder();
    write(folder.path(), "mark.ron", "\u{feff}(version: 1, gravity: ())");
    write(folder.path(), "mark.script", "\u{feff}[(at_s: 0, do: press(\"toggle_gravity\"))]");
    write(folder.path(), "good.times", "\u{feff}0.1\r\n0.2\r\n");
    for line in [
        "run fine.ron --ticks 0",
        "run fine.ron --seconds 0.5 --state folder/out.csv --summary out.json",
        "run damped.ron --damping clamped --hz 50 --fps 24",
        "run mark.ron --script mark.script --frame-times good.times",
        "run tutorial --script recorded.script",
        "plan fine.ron --method explicit_euler",
        "list",
        "list scenes",
        "--version",
        "--help",
        "run --help",
    ] {
        let said = run(folder.path(), line);
        said.says(0, "");
        assert!(!said.out.is_empty(), "{line}");
    }
}
