//! Sessions, as the words and panels in the picture show them.

use bevy_ecs::prelude::*;
use egui::accesskit::{ActionRequest, Node, NodeId, TreeId};
use expect_test::expect_file;
use glam::{DQuat, DVec2, DVec3};
use history::Change;
use motion::clock::StepClock;
use motion::{Gravity, Method, Orientation, PhysicsBody, Request, SoftBody};
use scene::{Action, ChangeAction, InputAction, Scene};

use crate::actions::Act;
use crate::app::frame_loop::FrameLoop;
use crate::app::session::Session;
use crate::clock::FrameClock;
use crate::input::{Input, InputFrame, SwitchedBy};
use crate::intent::Intent;
use crate::stage::options::Options;
use crate::stage::quarantines::quarantined_because;
use crate::view::card::{Selected, rows};
use crate::view::hud::dropped;
use crate::view::labels::{Label, around};

#[test]
fn the_clock_shown_is_the_scenes() {
    let scene = Scene::parse("empty", "(version: 1)").expect("a good scene");
    let mut session = Session::new(scene.clone(), Options::default());
    let mut clock = FrameClock::default();
    let mut shown = |session: &mut Session| {
        session.advance(&InputFrame::NOTHING, clock.advance_by(0.1).expect("a time"));
        session.stage.sim().world.resource::<StepClock>().scene_seconds()
    };
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} s is not {b} s");
    close(shown(&mut session), 0.1);
    close(shown(&mut session), 0.2);
    session.carry_out(Intent::Act(Act::ResetWorld));
    close(shown(&mut session), 0.1);
    session.open(scene);
    close(shown(&mut session), 0.1);
    close(session.stage.sim().seconds(), 0.4);
}

#[test]
fn the_camera_of_an_opened_scene_comes_to_its_place_and_is_there_at_the_first_key() {
    let place = |presses_at: f64| {
        let scene = scene::load("orbit").expect("it is shipped");
        let mut session =
            Session::new(scene, Options { size_px: [1280, 720], ..Options::default() });
        let mut frames = FrameLoop::default();
        frames.events.push(Input::Arrange(String::new()));
        session.opened = true;
        let mut places = Vec::new();
        for frame in 0..100 {
            let now = f64::from(frame) * 0.02;
            if (now - presses_at).abs() < 0.01 {
                frames.press(Act::Trails);
            }
            frames.frame(&mut session, &|| now, None);
            places.push(session.view.camera.position);
        }
        places
    };
    let (whole, cut) = (place(f64::INFINITY), place(0.5));
    let end = whole[99];
    assert_eq!(end, scene::load("orbit").expect("it is shipped").camera.position);
    assert!(whole[5].distance(end) > 1.0);
    // It slows down, and goes no farther.
    let off: Vec<_> = whole[5..].iter().map(|place| place.distance(end)).collect();
    assert!(off.is_sorted_by(|before, after| before >= after), "{off:?}");
    assert!(cut[24].distance(end) > 0.1 && cut[25..].iter().all(|place| *place == end));
}

#[test]
fn a_change_of_the_method_while_time_stands_still_changes_no_velocity_on_the_card() {
    for name in ["orbit", "oscillator", "cape", "jelly", "everything"] {
        let mut scene = scene::load(name).expect("it is shipped");
        // Mutual gravity is not for every method.
        scene.method = Method::PositionVerlet;
        let options = Options { pictures: false, ..Options::default() };
        // A few ticks: the cape does not live long under position Verlet.
        let seconds = 2.0 / scene.step_hz;
        let (mut session, mut clock) = (Session::new(scene, options), FrameClock::default());
        session.advance(&InputFrame::NOTHING, clock.advance_by(seconds).expect("a time"));
        let velocities = |session: &mut Session| {
            let of = |session: &mut Session, thing| Selected::of(&session.stage, thing)?.body;
            let mut softs =
                session.stage.sim_mut().world.query_filtered::<Entity, With<SoftBody>>();
            let softs: Vec<_> = softs.iter(&session.stage.sim().world).collect();
            let bodies = session.stage.sim().bodies.clone();
            bodies
                .into_iter()
                .chain(softs)
                .map(|body| of(session, body).map(|body| body.velocity))
                .collect::<Vec<_>>()
        };
        let stored = |session: &Session, body| {
            session.stage.sim().world.get::<PhysicsBody>(body).map(|body| body.velocity)
        };
        let lagged: Vec<_> =
            session.stage.sim().bodies.iter().map(|body| stored(&session, *body)).collect();
        let before = velocities(&mut session);
        session.stage.change(Change::Method(Method::VelocityVerlet), SwitchedBy::Settings);
        let after = velocities(&mut session);
        let most = |a: &[Option<DVec3>], b: &[Option<DVec3>]| {
            let apart =
                a.iter().zip(b).filter_map(|(a, b)| Some(a.as_ref()?.distance(*b.as_ref()?)));
            apart.fold(0.0, f64::max)
        };
        let (changed, lag) = (most(&before, &after), most(&lagged, &after));
        assert!(changed < 1e-9 * lag && lag > 1e-3, "{name}: {changed} m/s of {lag} m/s");
    }
}

#[test]
fn a_card_that_gets_wider_stays_in_the_picture_in_the_same_frame() {
    let text = "(version: 1, bodies: [(name: \"ball\", shape: sphere(radius_m: 1), position_m: (0, 0, -9))])";
    let mut session =
        Session::new(Scene::parse("card", text).expect("a good scene"), Options::default());
    session.stage.select(session.stage.sim().named("ball"));
    let mut clock = FrameClock::default();
    let mut right = |session: &mut Session, x: f64| {
        let put = ChangeAction::SetPosition("ball".to_owned(), DVec3::splat(x));
        let input = [Input::Change(put)].into_iter().collect();
        let frame = session.frame(&input, clock.advance_by(0.1).expect("a time"));
        let of_mesh = |primitive: &egui::ClippedPrimitive| match &primitive.primitive {
            egui::epaint::Primitive::Mesh(mesh) => {
                mesh.vertices.iter().map(|vertex| vertex.pos.x).fold(0.0, f32::max)
            }
            egui::epaint::Primitive::Callback(_) => 0.0,
        };
        frame.panels.expect("pictures").primitives.iter().map(of_mesh).fold(0.0, f32::max)
    };
    for x in [1.0, 1.0, 1e5, -1.234_567e-7, -1e5] {
        let edge = right(&mut session, x);
        // With the card's shadow.
        assert!((1272.0..=1290.0).contains(&edge), "at {x} m the card ends at {edge}");
    }
}

/// The rows of the card of `body` after `ticks` ticks.
fn card(scene: Scene, body: &str, ticks: u32) -> Vec<(String, String)> {
    let tick = 1.0 / scene.step_hz;
    let (mut session, mut clock) = (Session::new(scene, Options::default()), FrameClock::default());
    for _ in 0..ticks {
        session
            .advance(&InputFrame::NOTHING, clock.advance_by(tick).expect("time does not go back"));
    }
    let body = session.stage.sim().named(body).expect("a body of the scene");
    let selected = Selected::of(&session.stage, body).expect("a thing");
    rows(&selected, Method::default())
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}

/// A spring pulls with k (L - L0) = pi² 3 N at 1 kg.
#[test]
fn cards_have_the_forces_and_the_acceleration_that_act() {
    let shipped = |name| scene::load(name).expect("it is shipped");
    let text = "(version: 1, step_hz: 10, gravity: (), damping: (model: tutorial, rate_per_s: 1),
        bodies: [(name: \"ball\", mass_kg: 2, velocity_m_s: (3, 0, 0))])";
    let fall = Scene::parse("fall", text).expect("a good scene");
    let cards = [
        (shipped("oscillator"), "ball", 0),
        (shipped("third_law"), "heavy", 0),
        (fall, "ball", 0),
        (shipped("flag"), "flag.r8.c12", 30),
    ];
    let cards = cards.map(|(scene, body, ticks)| {
        let head = format!("{body} of {}\n", scene.name);
        let rows = card(scene, body, ticks).into_iter();
        rows.fold(head, |card, (name, value)| card + &format!("  {name}: {value}\n"))
    });
    expect_file!["cards.txt"].assert_eq(&cards.concat());
}

/// The labels in the picture.
fn labels(session: &Session) -> Vec<Label> {
    session.view.visible_labels(&session.stage)
}

/// Seen from the origin along -z, 90 degrees high.
fn labelled() -> Session {
    let text = "(version: 1,
        camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0, fov_y_deg: 90, near_m: 0.1, far_m: 100),
        bodies: [
            (name: \"ahead\", shape: sphere(radius_m: 2), position_m: (0, 0, -10)),
            (name: \"particle\", position_m: (5, 5, -20)),
            (name: \"behind\", shape: sphere(radius_m: 2), position_m: (0, 0, 10)),
            (name: \"beside\", position_m: (40, 0, -10)),
            (name: \"distant\", position_m: (0, 0, -200)),
        ])";
    let mut session =
        Session::new(Scene::parse("labels", text).expect("a good scene"), Options::default());
    let names: Vec<_> =
        session.stage.sim().scene.names.iter().map(std::borrow::Cow::into_owned).collect();
    session.view.labels = (0..).zip(names).collect();
    // A body that does not exist.
    session.view.labels.push((99, "no body".to_owned()));
    session
}

#[test]
fn labels_stand_where_their_bodies_are_seen_and_only_in_the_picture() {
    let seen = labels(&labelled());
    let words: Vec<_> = seen.iter().map(|label| label.text.as_str()).collect();
    assert_eq!(words, ["particle", "ahead"]);
    let close = |a: DVec2, b: DVec2| assert!((a - b).length() < 1e-9, "{a} is not {b}");
    // 360 pixels are 45 degrees.
    close(seen[0].at, DVec2::new(640.0 + 90.0, 360.0 - 90.0));
    close(seen[1].at, DVec2::new(640.0, 360.0));
    assert!(seen[0].reach == 0.0 && (seen[1].reach - 72.0).abs() < 1e-9);
}

#[test]
fn words_stand_beside_thin_bodies_and_a_ring_goes_around_all_of_one() {
    let text = "(version: 1,
        camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0, fov_y_deg: 90, near_m: 0.1, far_m: 100),
        bodies: [(name: \"mast\", label: \"mast\", shape: cuboid(half_extents_m: (0.5, 5, 3)), position_m: (0, 0, -10))])";
    let mut session =
        Session::new(Scene::parse("thin", text).expect("a good scene"), Options::default());
    let reach = |session: &Session| labels(session)[0].reach;
    assert!((reach(&session) - 18.0).abs() < 1e-9, "{}", reach(&session));
    let mast = session.stage.sim().bodies[0];
    session
        .stage
        .sim_mut()
        .world
        .entity_mut(mast)
        .insert(Orientation(DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2)));
    assert!((reach(&session) - 180.0).abs() < 1e-9, "{}", reach(&session));
    let (_, ring) =
        session.view.label(&session.stage, mast, "", around).expect("it is in the picture");
    assert!((ring.reach - 180.0).abs() < 1e-9);
}

#[test]
fn the_label_of_a_removed_body_is_gone_and_others_stay_after_a_reset() {
    let mut session = labelled();
    let ahead = session.stage.sim().bodies[0];
    let ahead = session.stage.sim().id(ahead).expect("a body");
    session.stage.give(Change::request(Request::Remove(ahead)));
    assert_eq!(labels(&session).len(), 1);
    session.carry_out(Intent::Act(Act::ResetWorld));
    assert_eq!(labels(&session).len(), 2);
}

#[test]
fn a_label_is_drawn_with_the_panels_of_the_frame() {
    let mut session = labelled();
    let words = |session: &mut Session, total: f64| {
        let time = FrameClock::default().advance_to(total).expect("a time");
        let frame = session.frame(&InputFrame::NOTHING, time);
        let triangles = |primitive: &egui::ClippedPrimitive| match &primitive.primitive {
            egui::epaint::Primitive::Mesh(mesh) => mesh.indices.len(),
            egui::epaint::Primitive::Callback(_) => 0,
        };
        frame
            .panels
            .expect("a session with pictures")
            .primitives
            .iter()
            .map(triangles)
            .sum::<usize>()
    };
    let labelled = words(&mut session, 0.0);
    session.view.labels.clear();
    assert!(words(&mut session, 0.0) < labelled);
}

#[test]
fn bodies_that_show_methods_have_their_colors() {
    for name in ["orbits_race", "terminal_speed"] {
        let scene = scene::load(name).expect("it is shipped");
        for method in Method::ALL {
            let Some(id) = scene.names.find(method.name()) else { continue };
            let painted =
                scene.bodies[id as usize].color.map(|channel| f64::from(channel * 255.0).round());
            assert_eq!(
                painted,
                report::ink(method).srgb.map(f64::from),
                "{name}: {}",
                method.name()
            );
        }
    }
}

#[test]
fn a_trail_has_a_paler_color_of_its_body() {
    let scene = scene::load("coast").expect("it is shipped");
    let painted: Vec<_> = scene
        .bodies
        .iter()
        .filter(|body| body.inverse_mass.is_some())
        .map(|body| body.color)
        .collect();
    let (mut session, mut clock) = (Session::new(scene, Options::default()), FrameClock::default());
    let mut frame = || session.frame(&InputFrame::NOTHING, clock.advance_by(0.1).expect("a time"));
    frame();
    let mut drawn: Vec<_> = frame().lines.iter().map(|line| line.start_color).collect();
    drawn.dedup_by(|a, b| a[..3] == b[..3]);
    assert_eq!(drawn.len(), painted.len());
    for body in painted {
        let paler = |trail: &[f32; 4]| {
            trail.iter().zip(body).all(|(trail, body)| (body..1.0).contains(trail))
        };
        assert!(drawn.iter().any(paler), "{body:?} has none of {drawn:?}");
    }
}

#[test]
fn a_reset_and_another_scene_have_no_quarantined_bodies_and_a_run_keeps_all() {
    let mut session = labelled();
    let mut clock = FrameClock::default();
    let mut nan = |session: &mut Session| {
        let push = ChangeAction::Push("ahead".to_owned(), DVec3::new(f64::NAN, 0.0, 0.0));
        let input = [Input::Change(push)].into_iter().collect();
        session.advance(&input, clock.advance_by(1.0 / 60.0).expect("a time"));
        let names: Vec<_> =
            session.stage.quarantines().here().iter().map(|body| body.body.as_str()).collect();
        assert_eq!(names, ["ahead"]);
        let body = session.stage.sim().named("ahead").expect("it is there");
        let (sim, recorder) = (session.stage.sim(), session.stage.recorder());
        let why = quarantined_because(sim, recorder, body).expect("it is quarantined");
        assert!(why.ends_with(" by integrate_acceleration"), "{why}");
    };
    nan(&mut session);
    session.carry_out(Intent::Act(Act::ResetWorld));
    assert!(session.stage.quarantines().here().is_empty());
    assert_eq!(session.stage.quarantines().so_far().len(), 1);
    nan(&mut session);
    let scene = Scene::clone(&session.stage.sim().scene);
    session.open(scene);
    assert!(session.stage.quarantines().here().is_empty());
    nan(&mut session);
    assert_eq!(session.stage.quarantines().all().len(), 3);
}

#[test]
fn the_body_that_goes_wrong_is_marked_while_the_run_stands_beside_that() {
    let mut session = labelled();
    session.stage.keep_timeline();
    let mut clock = FrameClock::default();
    let mut frame = |session: &mut Session, input: InputFrame| {
        session.advance(&input, clock.advance_by(1.0 / 60.0).expect("a time"));
    };
    let push = ChangeAction::Push("ahead".to_owned(), DVec3::new(f64::NAN, 0.0, 0.0));
    assert!(session.view.fault_mark(&session.stage).is_none());
    frame(&mut session, [Input::Change(push)].into_iter().collect());
    let mark = session.view.fault_mark(&session.stage).expect("a mark");
    assert_eq!(mark.text, "ahead goes wrong in the next tick");
    assert!(
        (mark.at - DVec2::new(640.0, 360.0)).length() < 1e-9 && (mark.reach - 72.0).abs() < 1e-9
    );
    session.seek(1);
    assert_eq!(
        session.view.fault_mark(&session.stage).expect("a mark").text,
        "ahead went wrong in this tick"
    );
    session.stage.playback_mut().set_paused(false);
    assert!(session.view.fault_mark(&session.stage).is_none());
}

#[test]
fn the_settings_declare_an_effect_and_say_so_and_a_script_is_refused() {
    let scene = Scene::parse("bare", "(version: 1)").expect("it is a scene");
    let mut session = Session::new(scene, Options::default());
    let mut declared_by = |by| {
        session.stage.change(Change::request(Request::SetGravity(DVec3::Y)), by);
        let said = session.stage.notices.texts().last().expect("either is told").to_owned();
        (session.stage.sim().world.contains_resource::<Gravity>(), said)
    };
    assert_eq!(
        declared_by(SwitchedBy::Script),
        (false, "this scene never declared gravity".to_owned())
    );
    let said =
        "gravity is set by the settings now; saving the scene writes it into the file".to_owned();
    assert_eq!(declared_by(SwitchedBy::Settings), (true, said));
}

#[test]
fn every_icon_has_a_glyph() {
    let sources = [include_str!("cockpit/toolbar.rs"), include_str!("../panels.rs")].concat();
    let icons: Vec<_> = sources.chars().filter(|icon| *icon >= '\u{2190}').collect();
    assert!(icons.len() > 15, "{icons:?}");
    let context = egui::Context::default();
    context.run_ui(egui::RawInput::default(), |_| {}).textures_delta.clear();
    let font = egui::FontId::proportional(14.0);
    context.fonts_mut(|fonts| {
        let missing: Vec<_> = icons.iter().filter(|icon| !fonts.has_glyph(&font, **icon)).collect();
        assert!(missing.is_empty(), "{missing:?}");
    });
}

/// A session with the finder open, and a function that gives it input in a frame.
fn with_finder() -> (Session, impl FnMut(&mut Session, &[Input])) {
    let scene = Scene::parse("empty", "(version: 1)").expect("a good scene");
    let mut clock = FrameClock::default();
    let mut give = move |session: &mut Session, input: &[Input]| {
        let input = input.iter().cloned().collect();
        session.advance(&input, clock.advance_by(0.01).expect("a time"));
    };
    let mut session = Session::new(scene, Options::default());
    session.ui.context().enable_accesskit();
    let open = "Ctrl+O".parse().expect("a key");
    give(&mut session, &[Input::KeyDown(open)]);
    give(&mut session, &[]);
    (session, give)
}

/// What is asked of the system: copied texts, and the tree of assistive technology.
fn asked(session: &mut Session) -> (Vec<String>, Vec<(NodeId, Node)>) {
    let requests = session.ui.take_requests().expect("a layout");
    let copied = requests.commands.into_iter().filter_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text),
        _ => None,
    });
    (copied.collect(), requests.accesskit_update.expect("a tree").nodes)
}

#[test]
fn a_field_copies_and_cuts() {
    let (mut session, mut give) = with_finder();
    let key = |name: &str| Input::KeyDown(name.parse().expect("a key"));
    give(&mut session, &[Input::Text("jelly".to_owned()), key("Ctrl+A"), key("Ctrl+C")]);
    assert_eq!(asked(&mut session).0, ["jelly"]);
    give(&mut session, &[key("Ctrl+A"), key("Ctrl+X")]);
    assert_eq!(asked(&mut session).0, ["jelly"]);
    give(&mut session, &[Input::Text("ra".to_owned())]);
    give(&mut session, &[key("Ctrl+A"), key("Ctrl+C")]);
    assert_eq!(asked(&mut session).0, ["ra"], "what was cut is gone");
}

#[test]
fn assistive_technology_sees_the_controls_and_presses_them() {
    let (mut session, mut give) = with_finder();
    let key = |name: &str| Input::KeyDown(name.parse().expect("a key"));
    give(&mut session, &[key("Escape"), key("F10")]);
    give(&mut session, &[]);
    let (_, nodes) = asked(&mut session);
    let pause = nodes.iter().find(|(_, node)| node.label() == Some("Pause")).expect("a button");
    let request = ActionRequest {
        action: accesskit::Action::Click,
        target_tree: TreeId::ROOT,
        target_node: pause.0,
        data: None,
    };
    let assist = Input::Assist(serde_json::to_string(&request).expect("JSON"));
    let recorded = crate::app::player::recorded(&assist).expect("a recording holds it");
    assert!(matches!(recorded, Action::Input(InputAction::Assist(_))));
    give(&mut session, &[assist]);
    assert!(session.stage.playback().paused());
}

#[test]
fn the_push_that_a_slow_frame_drops_is_said() {
    let scene = scene::load("tutorial").expect("it is shipped");
    let (mut session, mut clock) = (Session::new(scene, Options::default()), FrameClock::default());
    let mut frame = |session: &mut Session, length: f64, keys: &[&str]| {
        let key = |name: &&str| Input::KeyDown(name.parse().expect("a key"));
        let input = keys.iter().map(key).collect();
        session.advance(&input, clock.advance_by(length).expect("a time"));
        dropped(&session.stage)
    };
    assert_eq!(frame(&mut session, 0.01, &["Q", "K", "Right"]), None);
    let said = frame(&mut session, 0.5, &[]).expect("half of it is dropped");
    assert_eq!(
        said,
        "slower than real time: 0.25 s of this frame are dropped, with the push of 10 N in it"
    );
}
