//! Bad input, its exit codes and its messages.

/// The files of the folder that every case runs in.
pub const FILES: &[(&str, &[u8])] = &[
    ("fine.ron", br#"(version: 1, gravity: (), bodies: [(name: "ball")])"#),
    ("damped.ron", b"(version: 1, damping: (rate_per_s: 0.4))"),
    ("folder/inside.txt", b""),
    ("file", b"not a folder"),
    ("latin.ron", b"(version: 1,\n name: \"caf\xe9\")"),
    (
        "comma.ron",
        b"(version: 1,
 step_hz: 60
 seed: 3)",
    ),
    ("open.ron", br#"(version: 1, bodies: [(name: "ball")"#),
    ("text.ron", br#"(version: 1, bodies: [(mass_kg: "1")])"#),
    (
        "faults.ron",
        b"(version: 1, step_hz: 0, gravty: (),
 bodies: [(mass_kg: -1), (mass_kg: 0)], grids: [(rows: 0, columns: 5)])",
    ),
    ("unknown.ron", b"(version: 1, bodies: [(positon_m: (0, 1, 0), wobble: 1)])"),
    ("names.ron", br#"(version: 1, bodies: [(name: "a"), (name: "a"), (name: "the ball")])"#),
    ("escape.ron", br#"(version: 1, name: "\x1b]0;title\x07")"#),
    ("forged.ron", br#"(version: 1, name: "fine\nsandbox: all is well")"#),
    ("long.ron", br#"(version: 1, bodies: [(name: "longlonglonglonglonglonglonglonglonglonglonglonglonglonglonglonglonglonglonglonglonglonglonglonglonger")])"#),
    ("key.ron", b"(version: 1, \xc2\x9b2J: 1)"),
    ("infinite.ron", b"(version: 1, bodies: [(position_m: (0, inf, nan))])"),
    ("moving_wall.ron", b"(version: 1, bodies: [(immovable: true, velocity_m_s: (1, 0, 0))])"),
    ("no_version.ron", br#"(name: "old")"#),
    ("version_2.ron", b"(version: 2, bodies: {}, portals: [1, 2])"),
    ("coupled.ron", br#"(version: 1, wind: (), springs: [(between: ("a", "b"))])"#),
    (
        "laws.ron",
        br#"(version: 1, method: rk4, substeps: 0, drag: (), bodies: [(name: "ship"), (name: "rock", immovable: true)],
 wells: [(softening_m: -1, bodies: ["sip"])],
 thrusts: [(body: "rock", curve: polynomial([]), from_s: 2, until_s: 1)])"#,
    ),
    ("curve.ron", br#"(version: 1, thrusts: [(body: "ship", curve: sinus(amplitude_n: (1, 0, 0)))])"#),
    ("many.ron", b"(version: 1, clouds: [(count: 4000001)])"),
    ("comma.script", br#"[(at_s: 0.5 do: press("G"))]"#),
    (
        "keys.script",
        br#"[(at_s: 0.5, do: press("Foo")),
 (at_s: 1, do: hold("toggle_gravty", 1))]"#,
    ),
    ("action.script", br#"[(at_s: 0.5, do: pres("G"))]"#),
    (
        "body.script",
        br#"[(at_s: 0.5, do: push("bal", (1, 0, 0))),
 (at_s: 0.6, do: remove("cloud.3"))]"#,
    ),
    (
        "unfit.script",
        br#"[(at_s: 0, do: set_damping(1)),
 (at_s: 1, do: remove("ball")),
 (at_s: 2, do: push("ball", (1, 0, 0)))]"#,
    ),
    ("empty.script", b""),
    ("slash.script", br#"[(at_s: 0.5, do: screenshot("../shot.png"))]"#),
    ("backwards.script", br#"[(at_s: 0.5, do: press("G")), (at_s: 0.25, do: press("G"))]"#),
    (
        "faults.script",
        br#"[(do: press("G")),
 (at_s: -1, do: press("G")),
 (at_s: 1, at_tick: 1, do: press("")),
 (at_s: 2, od: press("G"))]"#,
    ),
    ("shot.script", br#"[(at_s: 0.5, do: screenshot("shot.png"))]"#),
    (
        "recorded.script",
        br#"(version: 1, scene: "tutorial", size_px: (16, 16), frame_ends_s: [0.1, 0.2], steps: [])"#,
    ),
    ("header.script", b"(version: 3, frame_ends_s: [0.2, 0.1])"),
    (
        "bad.times",
        b"0.1 # fine
-1
nan
inf
soon
",
    ),
    (
        "empty.times",
        b"# nothing
",
    ),
];

/// A command line in that folder and what has to come of it: the exit code, nothing on standard output, nothing
/// left behind, and on standard error this text. `{SCENES}`, `{CASES}`, `{PROBLEMS}` and `{METHODS}` stand for the names that there are.
pub struct Case {
    pub name: &'static str,
    pub line: &'static str,
    pub code: i32,
    pub message: &'static str,
}

pub const CASES: &[Case] = &[
    Case { name: "a scene that is misspelled", line: "run tutorail", code: 2, message: "sandbox: tutorail: there is no such scene; did you mean tutorial? shipped scenes are {SCENES}; a file needs its path" },
    Case { name: "a scene that is like no other", line: "run xyzzy", code: 2, message: "sandbox: xyzzy: there is no such scene; shipped scenes are {SCENES}; a file needs its path" },
    Case { name: "a misspelled scene for the window", line: "tutorail", code: 2, message: "sandbox: tutorail: there is no such scene; did you mean tutorial? shipped scenes are {SCENES}; a file needs its path" },
    Case { name: "copies of a scene", line: "cost flag --bodies 10", code: 2, message: "sandbox: --bodies is for problems: a scene is timed with the bodies that it has; leave it out" },
    Case { name: "a command as a scene", line: "run run", code: 2, message: "sandbox: run: there is no such scene; shipped scenes are {SCENES}; a file needs its path" },
    Case { name: "a scene file that is not there", line: "run missing.ron", code: 2, message: "sandbox: missing.ron: there is no such file; check the path" },
    Case { name: "a folder as a scene", line: "run folder", code: 2, message: "sandbox: folder: this is a folder; give the path of a file in it" },
    Case { name: "a scene that is not UTF-8", line: "run latin.ron", code: 2, message: "sandbox: latin.ron: line 2 is not UTF-8 text; save the file as UTF-8" },
    Case { name: "a scene without a comma", line: "run comma.ron", code: 2, message: "sandbox: comma.ron:3:2: seed: a comma is expected here; put one between two entries" },
    Case { name: "a scene that ends too early", line: "run open.ron", code: 2, message: r#"sandbox: open.ron:1:37: bodies[0].name: the text ends too early; close every `(`, `[` and `"` that was opened"# },
    Case { name: "a text for a number", line: "run text.ron", code: 2, message: "sandbox: text.ron:1:33: bodies[0].mass_kg: a number is expected here; write one such as 1.5" },
    Case { name: "several faults at once", line: "run faults.ron --state out.csv --summary out.json", code: 2, message: "sandbox: faults.ron:1:14: step_hz: 0 is not a step rate; give a positive number of steps per second
faults.ron:1:26: gravty: unknown key `gravty`; did you mean `gravity`?
faults.ron:2:12: bodies[0].mass_kg: -1 is not a mass; give a positive number of kilograms, or immovable: true
faults.ron:2:27: bodies[1].mass_kg: 0 is not a mass; give a positive number of kilograms, or immovable: true
faults.ron:2:50: grids[0].rows: rows is 0, which makes no body; give a whole number from 1 up" },
    Case { name: "unknown keys", line: "run unknown.ron", code: 2, message: "sandbox: unknown.ron:1:24: bodies[0].positon_m: unknown key `positon_m`; did you mean `position_m`?
unknown.ron:1:46: bodies[0].wobble: unknown key `wobble`; known here: name, shape, position_m, rotation_deg, velocity_m_s, verlet_previous_position_m, mass_kg, immovable, scenery, texture, color, label, method, substeps, damping_per_s, linear_drag_kg_s, quadratic_drag_kg_m, drag_area_m2, max_speed_m_s, locked_axes, gravity_off" },
    Case { name: "a name taken twice", line: "run names.ron", code: 2, message: r#"sandbox: names.ron:1:37: bodies[1].name: the name `a` is taken; give every body a name of its own
names.ron:1:50: bodies[2].name: "the ball" cannot be a name; use letters, digits, `_` and `-`"# },
    Case { name: "a name that steers the terminal", line: "run escape.ron", code: 2, message: "sandbox: escape.ron:1:14: name: a name is one line of plain characters; give at most 100 characters, or remove it" },
    Case { name: "a name that forges a line", line: "effects forged.ron", code: 2, message: "sandbox: forged.ron:1:14: name: a name is one line of plain characters; give at most 100 characters, or remove it" },
    Case { name: "a name that is too long", line: "run long.ron", code: 2, message: "sandbox: long.ron:1:24: bodies[0].name: 102 characters are too many for a name; give at most 100" },
    Case { name: "a key that steers the terminal", line: "run key.ron", code: 2, message: "sandbox: key.ron:1:14: \\u{9b}2J: a bare word is expected here; write it without quotes" },
    Case { name: "a position that is not finite", line: "run infinite.ron", code: 2, message: "sandbox: infinite.ron:1:24: bodies[0].position_m: (0, inf, NaN) is not finite; give three finite numbers" },
    Case { name: "an immovable body that moves", line: "run moving_wall.ron", code: 2, message: "sandbox: moving_wall.ron:1:41: bodies[0].velocity_m_s: an immovable body has no velocity; remove it, or immovable: true" },
    Case { name: "a scene without a version", line: "plan no_version.ron", code: 2, message: "sandbox: no_version.ron:1:1: version: the version is missing; add `version: 1`" },
    Case { name: "a scene of a later version", line: "plan version_2.ron", code: 2, message: "sandbox: version_2.ron:1:2: version: version 2 of the format is newer than this program, which reads version 1; use a newer program" },
    Case { name: "wind without drag, a spring without ends", line: "plan coupled.ron", code: 2, message: r#"sandbox: coupled.ron:1:14: wind: `velocity_m_s` is missing; add one such as `velocity_m_s: (3.0, 0.0, 0.0)`
coupled.ron:1:14: wind: wind moves the air that drag sees, and there is no drag; declare `drag`, or remove it
coupled.ron:1:34: springs[0]: `stiffness_n_m` is missing; add one such as `stiffness_n_m: 100.0`
coupled.ron:1:45: springs[0].between[0]: there is no body "a"; give the name of a body of the scene
coupled.ron:1:50: springs[0].between[1]: there is no body "b"; give the name of a body of the scene"# },
    Case { name: "laws with faults", line: "run laws.ron", code: 2, message: r#"sandbox: laws.ron:1:14: method: unknown word `rk4`; give explicit_euler, semi_implicit_euler, implicit_euler, position_verlet, velocity_verlet, runge_kutta_2_midpoint, runge_kutta_2_heun, runge_kutta_4 or yoshida_4
laws.ron:1:27: substeps: 0 is not a number of substeps; give a whole number from 1 to 100000
laws.ron:1:40: drag: drag needs at least one coefficient; add `linear_per_s`, `quadratic_per_m` or both
laws.ron:2:10: wells[0]: `strength_m3_s2` is missing; add one such as `strength_m3_s2: 1000.0`
laws.ron:2:11: wells[0].softening_m: -1 is not a softening; give a number of meters from 0 up
laws.ron:2:37: wells[0].bodies[0]: there is no body "sip"; did you mean "ship"?
laws.ron:3:13: thrusts[0].body: "rock" is immovable, so no engine moves it; name a body that can move
laws.ron:3:27: thrusts[0].curve: a polynomial needs at least one coefficient; give at least the constant force, as in `polynomial([(10.0, 0.0, 0.0)])`
laws.ron:3:61: thrusts[0].until_s: 1 s is not after the start at 2 s; give a later time, or leave it out"# },
    Case { name: "an unknown curve", line: "run curve.ron", code: 2, message: "sandbox: curve.ron:1:46: thrusts[0].curve: unknown word `sinus`; did you mean `sine`?" },
    Case { name: "too many bodies", line: "run many.ron", code: 2, message: "sandbox: many.ron:1:14: clouds: 4000001 bodies are too many; give at most 4000000 in all" },
    Case { name: "a damping model for no damping", line: "run fine.ron --damping exact --state out.csv --summary out.json", code: 2, message: "sandbox: fine.ron declares no damping; leave --damping out" },
    Case { name: "more ticks than can be", line: "run fine.ron --seconds 1e300", code: 2, message: "sandbox: 1e300 s at 120 Hz are too many ticks for one run; give fewer" },
    Case { name: "a rate of more ticks than can be", line: "run fine.ron --hz 1e308", code: 2, message: "sandbox: 10 s at 1e308 Hz are too many ticks for one run; give fewer" },
    Case { name: "a command that is misspelled", line: "lesons", code: 2, message: "sandbox: lesons: no such scene or command; did you mean `sandbox lessons`?" },
    Case { name: "a lesson that is misspelled", line: "lessons check forc", code: 2, message: "sandbox: forc: there is no such lesson; did you mean force? the lessons are force, mass, gravity, feather, eulers, verlet, runge_kutta, frame_time, springs, momentum, energy, further_work; a file needs its path" },
    Case { name: "a problem that is misspelled", line: "cost keplr --quick", code: 2, message: "sandbox: keplr: there is no such scene; shipped scenes are {SCENES}; a file needs its path\ndid you mean the problem kepler? the problems are {PROBLEMS}" },
    Case { name: "a file with the end of a folder", line: "run fine.ron --ticks 1 --state folder/new/", code: 2, message: "sandbox: cannot write folder/new/: the path ends with a folder separator; give the path of a file" },
    Case { name: "more frames than can be", line: "run fine.ron --ticks 5 --fps 1e300 --frames out", code: 2, message: "sandbox: 5 ticks at 120 Hz are more frames than a run can have, at 1e300 per second; give a lower --fps, or fewer ticks" },
    Case { name: "a body whose distance is asked for", line: "run fine.ron --state s.csv --columns distance:bal", code: 2, message: "sandbox: --columns distance:bal: there is no body \"bal\"; did you mean \"ball\"?" },
    Case { name: "a pattern like no name", line: "run fine.ron --state s.csv --bodies b?", code: 2, message: "sandbox: --bodies b?: no body has such a name; * is any letters of a name, ? is one" },
    Case { name: "a pattern that only scenery has", line: "run projectile --state s.csv --bodies ground", code: 2, message: "sandbox: --bodies ground: only scenery, which never moves, has such a name; name a body with physics" },
    Case { name: "a rate of ticks where frames are ticks", line: "forecast frame_step --hz 30", code: 2, message: "sandbox: frame_step has one tick per frame; leave --hz out" },
    Case { name: "a place that is not there", line: "sweep fine.ron --vary bodies[0].mas_kg=1,2 --out out", code: 2, message: "sandbox: fine.ron:1:36: bodies[0].mas_kg: there is no such place in the scene; did you mean bodies[0].mass_kg?" },
    Case { name: "a place that is not there and like no other", line: "sweep fine.ron --vary qqq=1,2", code: 2, message: "sandbox: fine.ron:1:1: qqq: there is no such place in the scene; give a place as messages name it, such as bodies[0].mass_kg" },
    Case { name: "a value that is not allowed", line: "sweep fine.ron --vary bodies[0].mass_kg=1,-2 --out out", code: 2, message: "sandbox: fine.ron:1:51: bodies[0].mass_kg: -2 is not a mass; give a positive number of kilograms, or immovable: true" },
    Case { name: "a place twice", line: "sweep fine.ron --vary step_hz=1,2 --vary step_hz=3,4", code: 2, message: "sandbox: fine.ron:1:1: step_hz: step_hz varies the same value; leave one of them out" },
    Case { name: "a case that is misspelled", line: "stability stif_spring --out out", code: 2, message: "sandbox: stif_spring: there is no such case; did you mean stiff_spring? the cases are {CASES}; a file needs its path" },
    Case { name: "a scene that is no case", line: "stability hitch fine.ron --out out", code: 2, message: "sandbox: fine.ron: the scene is no hard case; add `expect: (survival: (measure: energy, seconds: 10, bounded_below: 0.1))`, or name a case of `sandbox list cases`" },
    Case { name: "a script that is not there", line: "run fine.ron --script missing.script --state out.csv --summary out.json", code: 2, message: "sandbox: missing.script: there is no such file; check the path" },
    Case { name: "a folder as a script", line: "run fine.ron --script folder", code: 2, message: "sandbox: folder: this is a folder; give the path of a file in it" },
    Case { name: "a script that is not UTF-8", line: "run fine.ron --script latin.ron", code: 2, message: "sandbox: latin.ron: line 2 is not UTF-8 text; save the file as UTF-8" },
    Case { name: "a script without a comma", line: "run fine.ron --script comma.script --state out.csv --summary out.json", code: 2, message: "sandbox: comma.script:1:13: steps[0].do: a comma is expected here; put one between two entries" },
    Case { name: "keys that there are not", line: "run fine.ron --script keys.script --state out.csv --summary out.json", code: 2, message: "sandbox: keys.script:1:14: steps[0].do: there is no key or action `Foo`; `sandbox list keys` names them all
keys.script:2:12: steps[1].do: there is no key or action `toggle_gravty`; `sandbox list keys` names them all" },
    Case { name: "an unknown action", line: "run fine.ron --script action.script --state out.csv --summary out.json", code: 2, message: "sandbox: action.script:1:18: steps[0].do: unknown word `pres`; did you mean `press`?" },
    Case { name: "bodies that there are not", line: "run fine.ron --script body.script --state out.csv --summary out.json", code: 2, message: r#"sandbox: body.script:1:14: steps[0].do: there is no body "bal"; did you mean "ball"?
body.script:2:14: steps[1].do: there is no body "cloud.3"; give the name of a body of the scene"# },
    Case { name: "a picture outside its folder", line: "run fine.ron --script slash.script --frames pictures", code: 2, message: r#"sandbox: slash.script:1:14: steps[0].do: "../shot.png" is not a plain file name that ends in .png; give one such as "push.png""# },
    Case { name: "a script of another scene, and of a body that is gone", line: "run fine.ron --script unfit.script", code: 2, message: r#"sandbox: unfit.script:1:12: steps[0].do: this scene declares no effect `damping`; declare it in the scene, or leave this step out
unfit.script:3:12: steps[2].do: steps[1] has removed "ball" before; leave this step out, or put it first"# },
    Case { name: "an empty script", line: "run fine.ron --script empty.script", code: 2, message: "sandbox: empty.script:1:1: a list is expected here; open it with `[`" },
    Case { name: "a script that goes back in time", line: "run fine.ron --script backwards.script --state out.csv --summary out.json", code: 2, message: "sandbox: backwards.script:1:32: steps[1].at_s: 0.25 s comes after 0.5 s; give times that never go backwards" },
    Case { name: "several faults of a script at once", line: "run fine.ron --script faults.script --state out.csv --summary out.json", code: 2, message: r#"sandbox: faults.script:1:2: steps[0]: the step has no time; add at_s, at_tick or at_frame
faults.script:2:3: steps[1].at_s: -1 is not a time; give seconds from 0 up
faults.script:3:2: steps[2]: the step has several times; keep one of at_s, at_tick and at_frame
faults.script:3:24: steps[2].do: the name of the key is empty; give the name of a key
faults.script:4:2: steps[3]: the step does nothing; add an action such as `do: press("G")`
faults.script:4:12: steps[3].od: unknown key `od`; known here: at_s, at_tick, at_frame, do"# },
    Case { name: "a recording of another scene", line: "run fine.ron --script recorded.script", code: 2, message: "sandbox: recorded.script: this was recorded in tutorial, not in fine.ron; open tutorial" },
    Case { name: "a recording for the window of another scene", line: "fine.ron --script recorded.script", code: 2, message: "sandbox: recorded.script: this was recorded in tutorial, not in fine.ron; open tutorial" },
    Case { name: "a film of pictures that are shown for days", line: "run fine.ron --ticks 5 --fps 0.00001 --film film.png", code: 2, message: "sandbox: film.png: such a film shows a picture for 0.001 to 65535 s, and these frames take 100,000 s; give another --fps, or --frames for single pictures" },
    Case { name: "less than a tick", line: "run solar --seconds 60", code: 2, message: "sandbox: solar: 60 s are less than half a tick of 86400 s; give --seconds 86400 or more, or --ticks" },
    Case { name: "hardly any time", line: "run fine.ron --seconds 1e-300", code: 2, message: "sandbox: fine.ron: 1e-300 s are less than half a tick of 0.00833333 s; give --seconds 0.00833333 or more, or --ticks" },
    Case { name: "a GIF of pictures that browsers show slower", line: "run fine.ron --ticks 5 --fps 60 --film film.gif", code: 2, message: "sandbox: film.gif: such a film shows a picture for 0.02 to 655.35 s, and these frames take 0.0167 s; give another --fps, or --frames for single pictures" },
    Case { name: "a recording with frame times", line: "run tutorial --script recorded.script --fps 30", code: 2, message: "sandbox: a recording has frame times of its own; leave --fps and --frame-times out" },
    Case { name: "a recording with a bad header", line: "run tutorial --script header.script", code: 2, message: r#"sandbox: header.script:1:1: scene: the scene is missing; add the name of a scene, such as `scene: "tutorial"`
header.script:1:1: size_px: the window has no size; give one such as `size_px: (1280, 720)`
header.script:1:2: version: version 3 of recordings is not one that this program reads; record again with this program, which writes version 2
header.script:1:34: frame_ends_s[1]: a frame cannot end at 0.1 s after one that ended at 0.2 s; give finite times that never go backwards"# },
    Case { name: "frame times that are not there", line: "run fine.ron --frame-times missing.times", code: 2, message: "sandbox: missing.times: there is no such file; check the path" },
    Case { name: "frame times that are none", line: "run fine.ron --frame-times bad.times --state out.csv --summary out.json", code: 2, message: r#"sandbox: bad.times:2:1: "-1" is not a frame time; give seconds from 0 up, one number a line
bad.times:3:1: "nan" is not a frame time; give seconds from 0 up, one number a line
bad.times:4:1: "inf" is not a frame time; give seconds from 0 up, one number a line
bad.times:5:1: "soon" is not a frame time; give seconds from 0 up, one number a line"# },
    Case { name: "no frame times", line: "run fine.ron --frame-times empty.times", code: 2, message: "sandbox: empty.times: there is no frame time; give one number of seconds a line" },
    Case { name: "a folder as frame times", line: "run fine.ron --frame-times folder", code: 2, message: "sandbox: folder: this is a folder; give the path of a file in it" },
    Case { name: "a state file below a file", line: "run fine.ron --state file/out.csv --summary out.json", code: 2, message: "sandbox: cannot make the folder file: a file is in the way; give another path" },
    Case { name: "a state file far below a file", line: "run fine.ron --state file/a/b/out.csv --summary out.json", code: 2, message: "sandbox: cannot make the folder file/a/b: a file is in the way; give another path" },
    Case { name: "a folder as a state file", line: "run fine.ron --state folder --summary out.json", code: 2, message: "sandbox: cannot write folder: it is a folder; give the path of a file" },
    Case { name: "a folder as a summary", line: "run fine.ron --state out.csv --summary folder", code: 2, message: "sandbox: cannot write folder: it is a folder; give the path of a file" },
    Case { name: "a summary below a file", line: "run fine.ron --state out.csv --summary file/out.json", code: 2, message: "sandbox: cannot make the folder file: a file is in the way; give another path" },
    Case { name: "one file for state and summary", line: "run fine.ron --state out --summary out", code: 2, message: "sandbox: --state and --summary name the same file; give two" },
    Case { name: "a window without a display", line: "", code: 5, message: "sandbox: no display found; type `sandbox run tutorial` to run without a window, `sandbox --help` for everything else" },
    Case { name: "a scene in a window without a display", line: "fine.ron --size 16x16 --paused", code: 5, message: "sandbox: no display found; type `sandbox run fine.ron` to run without a window, `sandbox --help` for everything else" },
    Case { name: "a recording without a display", line: "tutorial --record out.ron", code: 5, message: "sandbox: no display found; type `sandbox run tutorial` to run without a window, `sandbox --help` for everything else" },
];

/// Command lines that the parser of arguments refuses, each with what its message names and what we say about that:
/// exit code 2, nothing on standard output, nothing left behind. The rest of the message is the parser's own.
pub const ARGUMENTS: &[(&str, &[&str])] = &[
    ("run", &["<SCENE>"]),
    ("runn tutorial", &["tutorial", "is one argument too many; the commands are {COMMANDS}"]),
    ("tutorial run tutorial", &["run"]),
    ("run fine.ron --sed 3", &["--sed"]),
    ("run fine.ron --method euler", &["--method", "the methods are {METHODS}"]),
    ("plan fine.ron --method rk4", &["--method", "the methods are {METHODS}"]),
    (
        "run damped.ron --damping wet",
        &["--damping", "the models are tutorial, clamped, implicit, exact"],
    ),
    ("run fine.ron --hz 0", &["--hz", "give a finite number above 0"]),
    ("run fine.ron --hz -60", &["--hz", "give a finite number above 0"]),
    ("run fine.ron --hz nan", &["--hz", "give a finite number above 0"]),
    ("run fine.ron --hz 1e-320", &["--hz", "give a larger number"]),
    ("run fine.ron --seconds 0", &["--seconds", "give a finite number above 0"]),
    ("run fine.ron --seconds inf", &["--seconds", "give a finite number above 0"]),
    ("run fine.ron --ticks 1 --seconds 1", &["--ticks", "--seconds"]),
    ("run fine.ron --ticks -1", &["--ticks", "give a whole number from 0 up"]),
    ("run fine.ron --ticks 1.5", &["--ticks", "give a whole number from 0 up"]),
    ("run fine.ron --fps 0", &["--fps", "give a finite number above 0"]),
    ("run fine.ron --fps 30 --frame-times bad.times", &["--fps", "--frame-times"]),
    ("run fine.ron --state out.csv --every 0", &["--every", "give a whole number from 1 up"]),
    ("run fine.ron --every 2", &["--state"]),
    ("run fine.ron --frame-every 2", &["--frames"]),
    (
        "run fine.ron --size 0x10",
        &["--size", "give width and height from 1 to 16384 pixels, as in 1280x720"],
    ),
    (
        "run fine.ron --size 10",
        &["--size", "give width and height from 1 to 16384 pixels, as in 1280x720"],
    ),
    (
        "run fine.ron --size 99999x1",
        &["--size", "give width and height from 1 to 16384 pixels, as in 1280x720"],
    ),
    ("run fine.ron --substeps 0", &["--substeps", "give a whole number from 1 to 100000"]),
    ("run fine.ron --substeps 100001", &["--substeps", "give a whole number from 1 to 100000"]),
    ("fine.ron --threads 0", &["--threads", "give a whole number from 1 to 256"]),
    ("run fine.ron --threads -2", &["--threads", "give a whole number from 1 to 256"]),
    ("sweep fine.ron --vary step_hz=30 --threads 257", &["give a whole number from 1 to 256"]),
    ("stability --method euler --out out", &["--method", "the methods are {METHODS}"]),
    ("--guest run fine.ron", &["'run' is a command: flags before a command belong to the window"]),
    (
        "cost kepler --seconds 1e300",
        &["--seconds is for scenes: a problem has a length of its own"],
    ),
    ("run fine.ron --columns force", &["--state"]),
    (
        "run fine.ron --state s.csv --columns forse",
        &["did you mean forces?", "the columns are position, velocity"],
    ),
    ("forecast fine.ron --modes 21", &["--modes", "give a whole number from 1 to 20"]),
    ("sweep fine.ron", &["--vary"]),
    (
        "sweep fine.ron --vary step_hz",
        &["--vary", "give a place and its values, as in step_hz=30,60,120"],
    ),
    (
        "sweep fine.ron --vary step_hz=3,,4",
        &["--vary", "a value is missing; give values with a comma between two"],
    ),
    (
        "sweep fine.ron --vary step_hz=9..9",
        &["--vary", "give a range as 1e2..1e6 log 20, 1..2 lin 5"],
    ),
    (
        "sweep fine.ron --vary method=all --shard 5/4 --out out",
        &[
            "--shard",
            "give which part of how many, as in 2/3, from 1/N to N/N, with N up to 1000000",
        ],
    ),
    ("sweep fine.ron --vary method=all --shard 1/4", &["--out"]),
    (
        "sweep fine.ron --vary method=all --measure eror",
        &["--measure", "the measures are error, drift, survives"],
    ),
    ("merge --out out", &["<DIR>"]),
    ("list bodies", &["bodies", "scenes", "cases", "methods", "laws", "keys"]),
    ("list keys --format xml", &["--format", "xml", "table", "json"]),
];
