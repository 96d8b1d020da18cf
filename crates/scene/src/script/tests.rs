//! Scripts: every action, every fault, and recordings there and back.

use glam::DVec3;
use motion::Method;
use motion::effects::Effect;

use super::*;
use crate::action::{MouseButton, PictureAction};

/// Every action once, as the contract spells it.
const EVERY_ACTION: &str = r#"// comments are fine
[
    (at_s: 0, do: press("G")), (at_s: 0.5, do: hold("W", 0.5)),
    (at_tick: 3, do: key_down("Shift")), (at_tick: 3, do: key_up("Shift")), (at_frame: 2, do: text("ß \"x\"\n")),
    (at_frame: 2, do: move_mouse(640, 360.5)), (at_frame: 3, do: mouse_down(left)), (at_frame: 3, do: mouse_up(right)),
    (at_frame: 4, do: click(middle)), (at_frame: 4, do: wheel(2)), (at_frame: 4, do: wheel(-0.5)),
    (at_frame: 5, do: focus_lost), (at_frame: 5, do: resize(1280, 720)),
    (at_s: 1, do: push("player", (10, 0, -1e3))), (at_s: 1, do: impulse("player", (0, inf, 0))),
    (at_s: 1, do: set_gravity((0, -1.62, 0))), (at_s: 1, do: set_damping(nan)),
    (at_s: 1, do: set_velocity("grid.x0.z1", (nan, NaN, -inf))), (at_s: 2, do: set_position("bonus", (1, 2, 3))),
    (at_s: 2, do: reverse_velocities), (at_s: 2, do: remove("enemy")), (at_s: 2, do: screenshot("after push.png")),
    (at_s: 2, do: set_method(explicit_euler)), (at_s: 2, do: set_substeps(4)), (at_s: 3, do: set_body_method("player", yoshida_4)),
    (at_s: 3, do: switch_effect("mutual_gravity", false)), (at_s: 3, do: caption("Off.")),
    (at_s: 4, do: at(4.01)), (at_s: 4, do: scale(1.5)), (at_s: 4, do: dock_width(300)), (at_s: 4, do: arrange("welcome on")),
    (at_frame: 9, do: compose("ni")), (at_frame: 9, do: assist("{}")), (at_frame: 9, do: touch(7, down, 640, 360.5)),
]"#;

#[test]
fn every_action_of_the_contract_is_read() {
    let script = Script::parse("t", EVERY_ACTION).unwrap_or_else(|error| panic!("{error}"));
    let Err(error) = ron::from_str::<Action>("no_action") else { panic!("no such action") };
    let ron::Error::NoSuchEnumVariant { expected, .. } = error.code else { panic!("{error}") };
    for name in expected.iter().filter(|name| **name != "wait") {
        let is_it =
            |step: &&Step| ron::to_string(&step.action).unwrap().split('(').next() == Some(name);
        assert!(script.steps.iter().any(|step| is_it(&step)), "{name} is not among them");
    }
    assert_eq!(script.recording, None);
    let step = |i: usize| (script.steps[i].when, script.steps[i].action.clone());
    assert_eq!(step(1), (When::Seconds(0.5), InputAction::Hold("W".to_owned(), 0.5).into()));
    assert_eq!(step(4), (When::Frame(2), InputAction::Text("ß \"x\"\n".to_owned()).into()));
    assert_eq!(step(5), (When::Frame(2), InputAction::MoveMouse(640.0, 360.5).into()));
    assert_eq!(step(8), (When::Frame(4), InputAction::Click(MouseButton::Middle).into()));
    assert_eq!(step(12), (When::Frame(5), InputAction::Resize(1280, 720).into()));
    let push = DVec3::new(10.0, 0.0, -1000.0);
    assert_eq!(
        step(13),
        (When::Seconds(1.0), ChangeAction::Push("player".to_owned(), push).into())
    );
    assert!(matches!(step(16).1, Action::Change(ChangeAction::SetDamping(rate)) if rate.is_nan()));
    assert!(
        matches!(step(17).1, Action::Change(ChangeAction::SetVelocity(_, v)) if v.x.is_nan() && v.y.is_nan() && v.z == f64::NEG_INFINITY)
    );
    assert_eq!(step(22).1, ChangeAction::SetMethod(Method::ExplicitEuler).into());
    assert_eq!(step(23).1, ChangeAction::SetSubsteps(4).into());
    assert_eq!(
        step(24).1,
        ChangeAction::SetBodyMethod("player".to_owned(), Method::Yoshida4).into()
    );
    assert_eq!(step(24).1.body(), Some("player"));
    assert_eq!(step(25).1, ChangeAction::SwitchEffect(Effect::MutualGravity, false).into());
    assert_eq!(step(26).1, PictureAction::Caption("Off.".to_owned()).into());
}

#[test]
fn every_method_can_be_set_and_is_written_by_its_name() {
    for method in Method::ALL {
        let action = ChangeAction::SetBodyMethod("a".to_owned(), method);
        let steps = [ChangeAction::SetMethod(method), action]
            .map(|action| Step { when: When::Tick(1), action: action.into() });
        let script = Script { steps: steps.to_vec(), recording: None };
        let ron = script.to_ron();
        assert!(ron.contains(&format!("set_body_method(\"a\",{})", method.name())), "{ron}");
        assert_eq!(Script::parse("t", &ron), Ok(script));
    }
}

#[test]
fn what_is_written_reads_back_to_the_last_bit() {
    let mut script = Script::parse("t", EVERY_ACTION).unwrap();
    let again = Script::parse("t", &script.to_ron())
        .unwrap_or_else(|error| panic!("{error}\n{}", script.to_ron()));
    // NaN is not equal to itself, so the written texts are compared.
    assert_eq!(again.to_ron(), script.to_ron());

    script.steps.retain(|step| {
        !matches!(
            step.action,
            Action::Change(ChangeAction::SetDamping(_) | ChangeAction::SetVelocity(..))
        )
    });
    let frame_ends_s = vec![0.0, 1.0 / 60.0, 0.1 + 0.2, 1e-7 + 0.5, 123_456.789_012_345_67, 1e20];
    script.recording = Some(Recording {
        scene: r"C:\my \{s}.ron".to_owned(),
        method: Some(motion::Method::ExplicitEuler),
        size_px: (1280, 720),
        names_settings: true,
        frame_ends_s,
    });
    let ron = script.to_ron();
    assert_eq!(Script::parse("t", &ron).unwrap_or_else(|error| panic!("{error}\n{ron}")), script);

    let empty = Script::default();
    assert_eq!(Script::parse("t", &empty.to_ron()), Ok(empty));
}

#[track_caller]
fn check(text: &str, expected: &[&str]) {
    let error = Script::parse("t", text).expect_err(text);
    assert_eq!(error.to_string(), expected.join("\n"), "{text}");
}

#[test]
fn every_fault_of_a_script_is_reported_at_once() {
    check(
        "[\n (at_s: 1, do: pres(\"G\")),\n (at_s: 0.5, do: hold(\"W\", \"long\")),\n (at: 1, do: click(lft)),\n (at_s: 1, at_tick: 2),\n]",
        &[
            "t:2:16: steps[0].do: unknown word `pres`; did you mean `press`?",
            "t:3:3: steps[1].at_s: 0.5 s comes after 1 s; give times that never go backwards",
            "t:3:28: steps[1].do[1]: a number is expected here; write one such as 1.5",
            "t:4:2: steps[2]: the step has no time; add at_s, at_tick or at_frame",
            "t:4:3: steps[2].at: unknown key `at`; did you mean `at_s`?",
            "t:4:20: steps[2].do[0]: unknown word `lft`; did you mean `left`?",
            "t:5:2: steps[3]: the step has several times; keep one of at_s, at_tick and at_frame",
            "t:5:2: steps[3]: the step does nothing; add an action such as `do: press(\"G\")`",
        ],
    );
}

#[test]
fn a_method_that_there_is_not_gets_a_suggestion_or_the_list() {
    check(
        "[(at_s: 0, do: set_method(runge_kutta_2)), (at_s: 0, do: set_body_method(\"a\", rk4))]",
        &[
            "t:1:27: steps[0].do[0]: unknown word `runge_kutta_2`; did you mean `runge_kutta_2_heun`?",
            "t:1:79: steps[1].do[1]: unknown word `rk4`; known here: explicit_euler, semi_implicit_euler, implicit_euler, position_verlet, velocity_verlet, runge_kutta_2_midpoint, runge_kutta_2_heun, runge_kutta_4, yoshida_4",
        ],
    );
}

#[test]
fn an_effect_that_there_is_not_gets_a_suggestion_or_the_list() {
    check(
        "[(at_s: 0, do: switch_effect(\"mutual_gravty\", false)),\n (at_s: 0, do: switch_effect(\"warp\", true)), (at_s: 0, do: switch_effect(\"drag\", off)), (at_s: 0, do: switch_effect(drag, true))]",
        &[
            "t:1:31: steps[0].do[0]: unknown word `mutual_gravty`; did you mean `mutual_gravity`?",
            "t:2:31: steps[1].do[0]: unknown word `warp`; known here: gravity, damping, drag, wind, wells, mutual_gravity, thrusts, springs, speed_limits, axis_locks, emitters",
            "t:2:82: steps[2].do[1]: a truth value is expected here; write true or false",
            "t:2:117: steps[3].do[0]: a text is expected here; put it in double quotes",
        ],
    );
}

#[test]
fn every_effect_can_be_switched_and_is_written_by_its_name() {
    for effect in Effect::ALL {
        let action = ChangeAction::SwitchEffect(effect, true);
        let script = Script {
            steps: vec![Step { when: When::Tick(1), action: action.into() }],
            recording: None,
        };
        let ron = script.to_ron();
        assert!(ron.contains(&format!("switch_effect({:?},true)", effect.name())), "{ron}");
        assert_eq!(Script::parse("t", &ron), Ok(script));
    }
}

#[test]
fn a_value_that_no_action_can_use_is_refused() {
    let cases = [
        ("hold(\"W\", 0)", "0 is not a time to hold a key; give a positive number of seconds"),
        ("press(\"\")", "the name of the key is empty; give the name of a key"),
        ("move_mouse(nan, 1)", "(NaN, 1) is not a pixel; give two finite numbers"),
        ("wheel(inf)", "inf is not a number of notches; give a finite number"),
        (
            "resize(0, 720)",
            "0 x 720 is not a window size; give two numbers of pixels from 1 to 16384",
        ),
    ];
    for (action, expected) in cases {
        check(
            &format!("[(at_s: 0, do: {action})]"),
            &[&format!("t:1:12: steps[0].do: {expected}")],
        );
    }
    for name in [
        "a.jpg",
        ".png",
        "../a.png",
        "a/b.png",
        r"a\\b.png",
        "c:a.png",
        "a..png",
        ".a.png",
        "a\\n.png",
    ] {
        let error = Script::parse("t", &format!("[(at_s: 0, do: screenshot(\"{name}\"))]"))
            .expect_err(name);
        assert!(error.to_string().ends_with(
            "is not a plain file name that ends in .png; give one such as \"push.png\""
        ));
    }
}

#[test]
fn moments_of_each_kind_go_forwards_on_their_own() {
    let fine = "[(at_s: 5, do: focus_lost), (at_tick: 1, do: focus_lost), (at_frame: 0, do: focus_lost), (at_s: 5, do: focus_lost)]";
    assert_eq!(Script::parse("t", fine).map(|script| script.steps.len()), Ok(4));
    check(
        "[(at_tick: 2, do: focus_lost), (at_tick: 1, do: focus_lost), (at_frame: 1, do: focus_lost), (at_frame: 0, do: focus_lost), (at_s: -1, do: focus_lost), (at_s: nan, do: focus_lost)]",
        &[
            "t:1:33: steps[1].at_tick: tick 1 comes after tick 2; give times that never go backwards",
            "t:1:94: steps[3].at_frame: frame 0 comes after frame 1; give times that never go backwards",
            "t:1:125: steps[4].at_s: -1 is not a time; give seconds from 0 up",
            "t:1:153: steps[5].at_s: NaN is not a time; give seconds from 0 up",
        ],
    );
}

#[test]
fn a_recording_without_its_header_is_refused() {
    check(
        "(version: 3, size_px: (0, 1), frame_ends_s: [0.5, 0.25, nan], setps: [])",
        &[
            "t:1:1: scene: the scene is missing; add the name of a scene, such as `scene: \"tutorial\"`",
            "t:1:2: version: version 3 of recordings is not one that this program reads; record again with this program, which writes version 2",
            "t:1:14: size_px: the window has no size; give one such as `size_px: (1280, 720)`",
            "t:1:51: frame_ends_s[1]: a frame cannot end at 0.25 s after one that ended at 0.5 s; give finite times that never go backwards",
            "t:1:57: frame_ends_s[2]: a frame cannot end at NaN s after one that ended at 0.5 s; give finite times that never go backwards",
            "t:1:63: setps: unknown key `setps`; did you mean `steps`?",
        ],
    );
}

#[test]
fn a_recording_may_have_the_name_of_its_type() {
    let text = "(version: 1, scene: \"tutorial\", size_px: (9, 9), frame_ends_s: [0.5], steps: [])";
    let named = Script::parse("t", &format!("Recording{text}")).unwrap();
    assert_eq!(named, Script::parse("t", text).unwrap());
}

#[test]
fn a_text_that_is_no_script_is_refused() {
    check("", &["t:1:1: a list is expected here; open it with `[`"]);
    check("// nothing yet\n", &["t:2:1: a list is expected here; open it with `[`"]);
    check("press(\"G\")", &["t:1:1: steps: a list is expected here; open it with `[`"]);
    check(
        "[(at_s: 1, do: press(\"G\")",
        &[
            "t:1:26: steps[0].do[0]: the text ends too early; close every `(`, `[` and `\"` that was opened",
        ],
    );
    check(
        "[(at_tick: -1)]",
        &[
            "t:1:12: steps[0].at_tick: this whole number is out of range; write one from 0 up that fits",
        ],
    );
    check(
        "[(at_s: 1, do: press(G))]",
        &["t:1:22: steps[0].do[0]: a text is expected here; put it in double quotes"],
    );
    check(
        "[(at_s: 1, do: click(left) extra)]",
        &["t:1:28: steps[0]: a comma is expected here; put one between two entries"],
    );
}

#[test]
fn bodies_and_keys_that_there_are_not_are_named() {
    let scene = crate::load("tutorial").unwrap();
    let text = r#"[(at_s: 0, do: remove("plyer")), (at_s: 0, do: remove("grid.x4.z4")), (at_s: 0, do: remove("grid.x5.z0")), (at_s: 0, do: press("Foo"))]"#;
    let script = Script::parse("t", text).unwrap();
    assert_eq!(
        script
            .check("t", text, &scene, |key| key != "Foo", |_| true, |_| false)
            .unwrap_err()
            .to_string(),
        "t:1:12: steps[0].do: there is no body \"plyer\"; did you mean \"player\"?\n\
         t:1:81: steps[2].do: there is no body \"grid.x5.z0\"; the bodies of \"grid\" are \"grid.x0.z0\" to \"grid.x4.z4\"\n\
         t:1:118: steps[3].do: there is no key or action `Foo`; `sandbox list keys` names them all"
    );
}

#[test]
fn effects_that_the_scene_does_not_declare_and_bodies_that_are_gone_are_named() {
    let scene = Scene::parse(
        "t",
        "(version: 1, drag: (linear_per_s: 1), bodies: [(name: \"a\"), (name: \"b\")])",
    )
    .unwrap();
    let check = |text: &str| {
        let checked = Script::parse("t", text).unwrap().check(
            "t",
            text,
            &scene,
            |_| true,
            |_| true,
            |key| key == "F1",
        );
        checked.map_or_else(|error| error.to_string(), |()| String::new())
    };
    let undeclared = "declare it in the scene, or leave this step out";
    assert_eq!(
        check(
            "[(at_s: 0, do: set_gravity((0, 1, 0))),\n (at_s: 0, do: set_damping(1)),\n (at_s: 0, do: switch_effect(\"wind\", true)), (at_s: 0, do: switch_effect(\"drag\", true))]"
        ),
        format!(
            "t:1:12: steps[0].do: this scene declares no effect `gravity`; {undeclared}\n\
             t:2:12: steps[1].do: this scene declares no effect `damping`; {undeclared}\n\
             t:3:12: steps[2].do: this scene declares no effect `wind`; {undeclared}"
        )
    );
    let gone = "steps[0] has removed \"a\" before; leave this step out, or put it first";
    let push = "do: push(\"a\", (1, 0, 0))";
    for (steps, expected) in [
        (
            format!("(at_s: 1, do: remove(\"a\")),\n (at_s: 2, {push})"),
            format!("t:2:12: steps[1].do: {gone}"),
        ),
        (
            format!("(at_s: 1, do: remove(\"a\")),\n (at_tick: 2, {push})"),
            format!("t:2:15: steps[1].do: {gone}"),
        ),
        // A reset brings it back, and between frames and ticks the list has no order.
        (
            format!(
                "(at_s: 1, do: remove(\"a\")), (at_s: 1.5, do: press(\"F1\")), (at_s: 2, {push})"
            ),
            String::new(),
        ),
        (format!("(at_s: 1, do: remove(\"a\")), (at_frame: 2, {push})"), String::new()),
        (format!("(at_s: 1, do: remove(\"b\")), (at_s: 2, {push})"), String::new()),
    ] {
        assert_eq!(check(&format!("[{steps}]")), expected);
    }
}
