//! Whatever a person does: keys, clicks, scripts and frame times of any length leave a session that can be drawn, hashed
//! and summed up.

use std::fmt::Write as _;
use std::ops::ControlFlow;

use arbitrary::{Result, Unstructured};
use history::{Bundle, Rerun, TIMELINE_BYTES};
use motion::effects::Effect;
use motion::{Method, PhysicsBody, Transform};
use sandbox::actions::BINDINGS;
use sandbox::clock::FrameClock;
use sandbox::input::InputFrame;
use sandbox::player::Player;
use sandbox::report::{Summary, state_hash};
use sandbox::{Options, Session};
use scene::{Scene, Script};

use super::numbers::{any_vector, at_least_0, finite, written};
use super::scenes;

/// Frames of a run.
const FRAMES: u64 = 12;

/// Ticks of a run, at most: what is tested is what happens in one, not how many there are.
const TICKS: u64 = 32;

/// Frame times that clocks have given before, s.
const FRAME_TIMES: &[f64] = &[
    1.0 / 60.0,
    1.0 / 60.0,
    1.0 / 60.0,
    1.0 / 144.0,
    0.0,
    -0.0,
    1e-9,
    5e-324,
    0.1,
    1.0,
    1e5,
    1e300,
    -1.0,
    f64::NAN,
];

/// Ticks after which a frame looks away.
const PATIENCES: &[u32] = &[u32::MAX, u32::MAX, 1, 3];

/// A random scene with a random script at random frame times.
pub fn session(bytes: &[u8]) {
    let mut u = Unstructured::new(bytes);
    let Ok(text) = scenes::text(&mut u) else { return };
    let Ok(scene) = Scene::parse("any", &text) else { return };
    let Ok(script) = script(&mut u) else { return };
    let interpolate = u.ratio(1, 2).unwrap_or(false);
    let script =
        Script::parse("any script", &script).unwrap_or_else(|error| panic!("{error}\n{script}"));
    let player = Player::new(script).expect("its keys are those of the table");
    let options = Options { pictures: false, interpolate, ..Options::default() };
    let mut session = Session::new(scene, options);
    session.play(player);
    session.stage.playback_mut().limit_ticks(TICKS);
    if u.ratio(1, 2).unwrap_or(false) {
        session.stage.keep_timeline();
    }
    let start = Summary::totals_at_start(&session.stage);
    let mut clock = FrameClock::default();
    for _ in 0..FRAMES {
        let Ok(length) = u.choose(FRAME_TIMES) else { return };
        let before = clock.now();
        let Ok(time) = clock.advance_by(*length) else {
            assert!(*length < 0.0 || !(before + *length).is_finite(), "{length} s was refused");
            assert_eq!(clock.now().to_bits(), before.to_bits(), "a refused time left a mark");
            continue;
        };
        let mut patience = u.choose(PATIENCES).copied().unwrap_or(u32::MAX);
        session.advance_watched(&InputFrame::NOTHING, time, &mut |_, _| {
            patience = patience.saturating_sub(1);
            if patience == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        session.stage.take_orders();
        for thing in session.stage.sim().remaining_bodies() {
            let position = session
                .stage
                .sim()
                .world
                .get::<Transform>(thing)
                .map(|transform| transform.position);
            let body = session.stage.sim().world.get::<PhysicsBody>(thing);
            let finite = position.is_none_or(|x| x.is_finite())
                && body.is_none_or(|body| body.velocity.is_finite());
            assert!(finite, "{}: {position:?} {body:?}\n{text}", session.stage.name(thing));
        }
    }
    if session.stage.recorder().is_on() {
        let bundle = session.stage.bundle(None).expect("a recorded run comes out the same");
        replay(&bundle);
    }
    session.picture();
    let _ = state_hash(&session.stage);
    let summary = Summary::of(&mut session, start, 0, None);
    assert!(!summary.to_json().is_empty() && !summary.to_table().is_empty());
}

/// What was recorded is what happened, also from the file.
fn replay(bundle: &Bundle) {
    let bytes = bundle.write().expect("small");
    let read = Bundle::read(&bytes).unwrap_or_else(|error| panic!("{error}"));
    let scene = read.scene("any").expect("it was one");
    let again = Rerun::of(scene.clone(), &read, TIMELINE_BYTES, &mut |_| ())
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(again.diverged_at, None);
    assert_eq!(format!("{:016x}", again.state_hash), read.manifest.end_state_hash);
    let faults: Vec<_> = again.faults.iter().map(|fault| fault.named(&scene.names)).collect();
    if let Some(fault) = &read.manifest.fault {
        assert!(faults.contains(fault), "{fault:?} is not among {faults:?}");
    }
}

fn script(u: &mut Unstructured<'_>) -> Result<String> {
    let mut script = "[\n".to_owned();
    let mut number = 0;
    for _ in 0..u.int_in_range(0..=8)? {
        number += u.int_in_range(0..=3)?;
        let when = u.choose(&["at_frame", "at_tick"])?;
        writeln!(script, " ({when}: {number}, do: {}),", action(u)?)
            .expect("a string takes everything");
    }
    script.push(']');
    Ok(script)
}

fn action(u: &mut Unstructured<'_>) -> Result<String> {
    let body = format!("\"b{}\"", u.int_in_range(0..=scenes::BODIES - 1)?);
    Ok(match u.int_in_range(0..=21)? {
        0..=3 => format!("press(\"{}\")", u.choose(&BINDINGS)?.name),
        4 => format!("hold(\"{}\", {:?})", u.choose(&BINDINGS)?.name, 0.05),
        5 => format!("move_mouse({:?}, {:?})", finite(u)?, finite(u)?),
        6 => format!("click({})", u.choose(&["left", "right", "middle"])?),
        7 => format!("wheel({:?})", finite(u)?),
        8 => format!("push({body}, {})", written(any_vector(u)?)),
        9 => format!("set_velocity({body}, {})", written(any_vector(u)?)),
        10 => format!("set_gravity({})", written(any_vector(u)?)),
        11 => format!("set_damping({:?})", at_least_0(u)?),
        12 => format!("remove({body})"),
        13 => format!("switch_effect(\"{}\", {})", u.choose(&Effect::ALL)?.name(), u.ratio(1, 2)?),
        14 => format!("set_method({})", u.choose(&Method::ALL)?.name()),
        15 => format!("set_body_method({body}, {})", u.choose(&Method::ALL)?.name()),
        16 => "press(\"step_back\")".to_owned(),
        17 => format!("compose({:?})", u.choose(&["", "ni", "\u{4f60}"])?),
        18 => "text(\"0,75\")".to_owned(),
        19 | 20 => format!(
            "touch({}, {}, {:?}, {:?})",
            u.int_in_range(0..=2)?,
            u.choose(&["down", "move", "up", "cancel"])?,
            finite(u)?,
            finite(u)?
        ),
        21 => format!("set_substeps({})", u.int_in_range(1..=4)?),
        _ => format!("set_position({body}, {})", written(any_vector(u)?)),
    })
}
