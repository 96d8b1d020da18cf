//! Scripts: every action, every fault, and recordings there and back.

use expect_test::expect_file;
use motion::Method;
use motion::effects::Effect;

use super::*;
use crate::answers;

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
    let steps = script.steps.iter().map(|step| format!("{:?} {:?}\n", step.when, step.action));
    expect_file!["actions.txt"].assert_eq(&steps.collect::<String>());
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

#[test]
fn every_fault_of_a_script_is_reported_with_its_place_and_cure() {
    answers("script/broken.txt", |text| Script::parse("t", text).expect_err(text).to_string());
}

#[test]
fn moments_of_each_kind_go_forwards_on_their_own() {
    let fine = "[(at_s: 5, do: focus_lost), (at_tick: 1, do: focus_lost), (at_frame: 0, do: focus_lost), (at_s: 5, do: focus_lost)]";
    assert_eq!(Script::parse("t", fine).map(|script| script.steps.len()), Ok(4));
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
fn a_recording_may_have_the_name_of_its_type() {
    let text = "(version: 1, scene: \"tutorial\", size_px: (9, 9), frame_ends_s: [0.5], steps: [])";
    let named = Script::parse("t", &format!("Recording{text}")).unwrap();
    assert_eq!(named, Script::parse("t", text).unwrap());
}

/// Effects, bodies and keys that there are not, and bodies that are gone.
#[test]
fn what_a_scene_lacks_is_named() {
    let scene = crate::parse(
        r#"drag: (linear_per_s: 1), bodies: [(name: "a"), (name: "player")], grids: [(rows: 5, columns: 5)]"#,
    );
    answers("script/lacking.txt", |text| {
        let script = Script::parse("t", text).unwrap();
        let checked =
            script.check("t", text, &scene, |key| key != "Foo", |_| true, |key| key == "F1");
        checked.map_or_else(|error| error.to_string(), |()| "fine".to_owned())
    });
}
