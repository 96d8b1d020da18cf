//! Whole messages for broken scenes, and texts broken at random.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::{BodySpec, Scene, answers, parse, shipped};

#[test]
fn a_method_that_cannot_solve_mutual_gravity_is_accepted_while_that_is_off() {
    let text = |off| {
        format!(
            "(version: 1, method: implicit_euler, mutual_gravity: (), {off} bodies: [(mass_kg: 1), (mass_kg: 1)])"
        )
    };
    assert!(Scene::parse("t", &text("")).is_err());
    assert!(Scene::parse("t", &text("off_at_start: [mutual_gravity],")).is_ok());
}

#[test]
fn every_broken_scene_gets_the_whole_message_that_is_expected() {
    answers("resolve/broken.txt", |text| Scene::parse("t", text).expect_err(text).to_string());
}

#[test]
fn laws_springs_and_masses_are_as_declared_or_have_their_defaults() {
    answers("resolve/values.txt", |keys| {
        let scene = parse(keys);
        let name = |id: u32| scene.names.get(id).unwrap().into_owned();
        let mut lines = vec![format!("{:?}", scene.laws), format!("{:?}", scene.mutual_gravity)];
        lines.extend(scene.springs.iter().map(|spring| {
            format!("{:?} {:?} {:?}", spring.ends.map(name), spring.elastic, spring.color)
        }));
        lines.extend(
            scene.emitters.iter().map(|emitter| format!("{} {:?}", emitter.name, emitter.pool)),
        );
        lines.extend(
            scene.soft_bodies.iter().map(|soft| format!("{} {:?}", soft.name, soft.points)),
        );
        lines.extend(scene.own_laws.iter().map(|(id, laws)| format!("{} {laws:?}", name(*id))));
        lines.extend((0..).zip(&scene.bodies).map(|(id, body)| {
            let BodySpec { inverse_mass, source_mass, method, substeps, .. } = body;
            format!(
                "{}: inverse mass {inverse_mass:?}, source mass {source_mass:?}, method {method:?}, substeps {substeps:?}",
                name(id)
            )
        }));
        lines.join("\n")
    });
}

#[test]
fn a_fault_carries_its_place_in_parts_too() {
    let error = Scene::parse("my.ron", "(\n  version: 1,\n  bodies: [\n    (mass_kg: -1)\n  ]\n)")
        .unwrap_err();
    let [fault] = &error.faults[..] else { panic!("{error}") };
    assert_eq!((fault.line, fault.column), (Some(4), Some(6)));
    assert_eq!(fault.path.as_deref(), Some("bodies[0].mass_kg"));
    assert_eq!(error.name, "my.ron");
}

#[test]
fn windows_line_ends_and_wide_letters_leave_lines_and_columns_right() {
    let error = Scene::parse("t", "(\r\nversion: 1,\r\n/* größe */ sed: 1)").unwrap_err();
    assert_eq!(error.to_string(), "t:3:13: sed: unknown key `sed`; did you mean `seed`?");
}

#[test]
fn scenes_of_other_texts_are_others_until_the_text_is_put_aside() {
    let [a, b] = ["(version: 1)", "(version: 1,)"].map(|text| Scene::parse("t", text).unwrap());
    assert_ne!(a, b);
    assert_eq!(Scene { text: b.text.clone(), ..a }, b);
}

#[test]
fn an_absent_effect_is_absent() {
    let scene = Scene::parse("t", "(version: 1)").unwrap();
    assert_eq!((scene.gravity, scene.damping, scene.push), (None, None, None));
    assert!(scene.light.is_none() && scene.expect.is_none() && scene.bodies.is_empty());
    assert_eq!((scene.step_hz, scene.substeps, scene.name.as_str()), (120.0, 1.into(), "t"));
}

/// A text that is broken anywhere is refused or read, and every fault of it lies inside.
fn survives(text: &str) {
    if let Err(error) = Scene::parse("t", text) {
        let lines = text.matches('\n').count() + 1;
        assert!(!error.faults.is_empty());
        for fault in &error.faults {
            assert!(fault.line.is_some_and(|line| (1..=lines).contains(&line)), "{error}\n{text}");
            assert!(!fault.what.is_empty() && !fault.cure.is_empty(), "{error}");
        }
    }
}

#[test]
fn no_truncation_and_no_flipped_byte_makes_the_loader_panic() {
    // The second one has what the first one has not: curves, names of bodies, labels.
    ["tutorial", "ship_between"].map(text_of).into_iter().for_each(no_damage_panics);
    assert!(Scene::parse("t", COUPLED).is_ok());
    no_damage_panics(COUPLED);
}

/// Whatever acts between bodies, in few words.
const COUPLED: &str = r#"(version: 1, drag: (linear_per_s: 1), wind: (velocity_m_s: (1, 0, 0), gust_m_s: 1, gust_hz: 2),
    mutual_gravity: (softening_m: 0.5), bodies: [(name: "a"), (name: "b", immovable: true, mass_kg: 5)],
    emitters: [(rate_per_s: 9, life_s: 2, speed_m_s: 1, direction: (1, 2, 0), spread_deg: 20, capacity: 8)],
    springs: [(between: ("a", "b"), stiffness_n_m: 2), (between: ("a", "lattice.x0.y1.z1"), stiffness_n_m: 3)],
    soft_bodies: [chain(points: 4, to_m: (1, 0, 0), stiffness_n_m: 9, pinned: [first]),
        cloth(rows: 3, columns: 2, along_m: (1, 0, 0), down_m: (0, -1, 0), stiffness_n_m: 5, shear: true, bend: true),
        lattice(cells: (2, 1, 3), size_m: (1, 1, 1), stiffness_n_m: 1, pinned: [top])])"#;

fn text_of(name: &str) -> &'static str {
    shipped().iter().find(|scene| scene.name == name).unwrap().text
}

fn no_damage_panics(text: &str) {
    for end in (0..text.len()).step_by(3).filter(|end| text.is_char_boundary(*end)) {
        survives(&text[..end]);
    }
    let seed = 20;
    let mut random = Pcg64::seed_from_u64(seed);
    for _ in 0..1500 {
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..bytes.len());
            bytes[at] =
                if random.random() { random.random_range(b' '..=b'~') } else { random.random() };
        }
        survives(&String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn deep_nesting_is_refused_without_a_stack_overflow() {
    let deep = format!("(version: 1, wobble: {}", "[".repeat(100_000));
    let error = Scene::parse("t", &deep).unwrap_err();
    assert!(
        error.to_string().contains("brackets are nested too deeply"),
        "{:.200}",
        error.to_string()
    );
}
