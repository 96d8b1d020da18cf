//! The shipped scenes, and loading by name and path.

use glam::DVec3;
use motion::effects::Effect;
use motion::{BodyState, Damping, EvaluationTime, Gravity, Law, Method, Well};
use pick::Shape;

use super::*;
use crate::scene::{BodySpec, CameraSpec, LightSpec, PushSpec, StepKind};

#[test]
fn every_shipped_scene_loads_under_its_own_name_with_a_description() {
    for shipped in shipped() {
        let scene = shipped.load().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.name, shipped.name);
        assert!(
            !scene.description.is_empty() && !scene.description.contains('\n'),
            "{}",
            scene.name
        );
        assert_eq!(scene.source, Source::Shipped(shipped.name));
    }
}

#[test]
fn every_case_loads_by_its_name_and_says_what_survival_is() {
    for case in cases() {
        let scene = load(case.name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((scene.name.as_str(), &scene.source), (case.name, &Source::Shipped(case.name)));
        assert!(
            !scene.description.is_empty() && !scene.description.contains('\n'),
            "{}",
            scene.name
        );
        assert_eq!(load_case(case.name).unwrap(), scene);
        assert!(shipped().iter().all(|scene| scene.name != case.name));
    }
}

#[test]
fn every_file_of_the_folders_is_shipped() {
    for (folder, embedded) in [("scenes", shipped()), ("cases", cases())] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(folder);
        let mut files: Vec<_> =
            std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name()).collect();
        let mut names: Vec<std::ffi::OsString> =
            embedded.iter().map(|scene| format!("{}.ron", scene.name).into()).collect();
        files.sort();
        names.sort();
        assert_eq!(files, names);
    }
}

#[test]
fn the_tutorial_scene_has_the_tutorials_numbers() {
    let scene = load("tutorial").unwrap();
    assert_eq!(scene.bodies.len(), 29);
    let expected = [
        (
            "floor",
            [0.0, -2.0, 0.0],
            Shape::Cuboid { half_extents: DVec3::new(100.0, 2.0, 100.0) },
            0.0,
        ),
        (
            "player",
            [0.0, 5.0, 0.0],
            Shape::Cuboid { half_extents: DVec3::new(0.9, 2.55, 0.9) },
            0.5,
        ),
        ("enemy", [5.0, 5.0, 0.0], Shape::Cuboid { half_extents: DVec3::new(0.9, 2.7, 0.9) }, 0.5),
        ("bonus", [10.0, 5.0, 0.0], Shape::Sphere { radius: 0.25 }, 1.0),
    ];
    for ((id, body), (name, position, shape, inverse_mass)) in
        (0..).zip(&scene.bodies).zip(expected)
    {
        assert_eq!(scene.names.get(id).as_deref(), Some(name));
        assert_eq!(body.position.to_array(), position, "{name}");
        assert_eq!((body.shape, body.inverse_mass), (Some(shape), Some(inverse_mass)), "{name}");
        assert_eq!(body.checker, name == "floor");
    }
    let mut cubes = 0;
    for x in 0..5_u32 {
        for z in 0..5_u32 {
            let id = 4 + x * 5 + z;
            let body = scene.bodies[id as usize];
            assert_eq!(scene.names.get(id).unwrap(), format!("grid.x{x}.z{z}"));
            assert_eq!(body.position, DVec3::new(f64::from(x) * 3.5, 10.0, f64::from(z) * 3.5));
            assert_eq!(
                (body.inverse_mass, body.velocity, body.checker),
                (Some(10.0), DVec3::ZERO, true)
            );
            cubes += usize::from(body.shape == Some(Shape::Cuboid { half_extents: DVec3::ONE }));
        }
    }
    assert!((5..=20).contains(&cubes), "{cubes} of 25 are cubes");
    assert_eq!(scene.gravity, Some(Gravity { on: false, ..Gravity::EARTH }));
    assert_eq!(scene.damping, Some(Damping::TUTORIAL));
    assert_eq!(scene.push, Some(PushSpec::TUTORIAL));
    assert_eq!((scene.camera, scene.light), (CameraSpec::TUTORIAL, Some(LightSpec::TUTORIAL)));
    assert_eq!((scene.step, scene.step_hz), (StepKind::Fixed, 120.0));
}

#[test]
fn the_other_scenes_are_what_they_say() {
    let scene = |name| load(name).unwrap();
    let large = scene("tutorial_large");
    assert_eq!((large.bodies.len(), large.bodies[0].position.y), (4 + 225, -20.0));
    assert_eq!(scene("empty").bodies.len(), 0);
    assert_eq!(scene("thousand").bodies.len(), 1 + 1000);
    assert!(scene("thousand").gravity.unwrap().on);
    assert!(scene("projectile").damping.is_none() && scene("projectile").gravity.unwrap().on);
    let ship = scene("ship");
    assert!(ship.gravity.is_none() && ship.damping.is_none() && ship.trails);
    assert_eq!(ship.own_laws[&0].thrusts.len(), 2);
    let (start, fall) = (scene("verlet_start"), scene("terminal_speed"));
    let wrong = start.bodies[start.names.find("wrong").unwrap() as usize];
    assert_eq!((start.method, wrong.verlet_previous), (Method::PositionVerlet, Some(DVec3::ZERO)));
    let drag = fall.laws.drag.unwrap();
    let terminal = (-fall.gravity.unwrap().acceleration.y / drag.quadratic).sqrt();
    assert!((terminal - 7.0).abs() < 1e-14 && drag.linear == 0.0);
    assert!(scene("coast").gravity.is_none() && scene("coast").damping.is_some());
    let (frame, tutorial) = (scene("frame_step"), scene("tutorial"));
    assert_eq!((frame.step, frame.bodies == tutorial.bodies), (StepKind::Frame, true));
}

#[test]
fn the_three_engines_agree_at_both_ends_and_not_between() {
    let scene = load("ship_between").unwrap();
    let newtons = |name: &str, time: f64| {
        let id = scene.names.find(name).unwrap();
        let [thrust] = &scene.own_laws[&id].thrusts[..] else { panic!("{name} has one engine") };
        let at = EvaluationTime { time, within_step: time.clamp(1.0, 1.999) };
        let state = BodyState { position: DVec3::ZERO, velocity: DVec3::ZERO, inverse_mass: 1.0 };
        thrust.acceleration(at, state).x
    };
    let curves: [(&str, fn(f64) -> f64); 3] = [
        ("linear", |t| 10.0 + 15.0 * (t - 1.0)),
        ("quadratic", |t| t * (7.5 + 2.5 * t)),
        ("exponential", |t| 10.0 * libm::pow(2.5, t - 1.0)),
    ];
    for (name, curve) in curves {
        assert!(
            (newtons(name, 1.0) - 10.0).abs() < 1e-12 && (newtons(name, 2.0) - 25.0).abs() < 1e-11
        );
        // Points of the table, where it is exact to its twelve digits.
        for i in 0..20 {
            let time = 1.0 + f64::from(i) / 20.0;
            assert!((newtons(name, time) - curve(time)).abs() < 1e-11, "{name} at {time} s");
        }
    }
    assert!(newtons("linear", 1.5) > newtons("quadratic", 1.5));
    assert!(newtons("quadratic", 1.5) > newtons("exponential", 1.5));
}

#[test]
fn the_orbits_are_keplers() {
    let (orbit, race) = (load("orbit").unwrap(), load("orbits_race").unwrap());
    let check = |well: &Well, body: &BodySpec| {
        let (r, v) = (body.position - well.position, body.velocity);
        let axis = 1.0 / (2.0 / r.length() - v.length_squared() / well.strength);
        let eccentricity = (v.cross(r.cross(v)) / well.strength - r / r.length()).length();
        let year = std::f64::consts::TAU * (axis * axis * axis / well.strength).sqrt();
        for (actual, expected) in [(axis, 10.0), (eccentricity, 0.6), (year, 6.0)] {
            assert!((actual - expected).abs() < 1e-13 * expected, "{actual} is not {expected}");
        }
    };
    let planet = orbit.names.find("planet").unwrap();
    check(&orbit.laws.wells.as_ref().unwrap().0[0], &orbit.bodies[planet as usize]);
    let wells = |scene: &Scene| scene.laws.wells.as_ref().map_or(0, |wells| wells.0.len());
    assert_eq!((wells(&orbit), wells(&race), race.own_laws.len()), (1, 0, Method::ALL.len()));
    for method in Method::ALL {
        let id = race.names.find(method.name()).unwrap();
        let body = &race.bodies[id as usize];
        assert_eq!(body.method, Some(method));
        check(&race.own_laws[&id].wells[0], body);
        let sun = race.names.find(&format!("{}_sun", method.name())).unwrap();
        let middle = race.bodies[sun as usize].position;
        assert_eq!(middle, race.own_laws[&id].wells[0].position);
        // Its name is below its orbit, whose axes are 10 m and 8 m.
        let (label, _) =
            race.labels.iter().find(|(_, words)| words == method.claims().title).unwrap();
        let below = race.bodies[*label as usize].position - middle;
        assert!((-13.0..-9.0).contains(&below.y) && below.x.abs() < 10.0, "{below}");
    }
}

/// The square of a frequency, 1/s², above those of all springs of a scene: the largest sum over the two ends of a spring
/// of the stiffness at an end times its inverse mass (Anderson and Morley 1971, for the Laplacian of a graph).
fn fastest_squared(scene: &Scene) -> f64 {
    let mut links: Vec<([u32; 2], f64)> =
        scene.springs.iter().map(|spring| (spring.ends, spring.elastic.stiffness)).collect();
    for soft in &scene.soft_bodies {
        let first = soft.points.start;
        links.extend(
            soft.links
                .iter()
                .map(|link| (link.ends.map(|end| first + end), link.elastic.stiffness)),
        );
    }
    let mut rates = vec![0.0; scene.bodies.len()];
    for (ends, stiffness) in &links {
        for end in ends.map(|end| end as usize) {
            rates[end] += stiffness * scene.bodies[end].inverse_mass.unwrap();
        }
    }
    links
        .iter()
        .map(|(ends, _)| rates[ends[0] as usize] + rates[ends[1] as usize])
        .fold(0.0, f64::max)
}

#[test]
fn springs_of_shipped_scenes_are_far_from_too_stiff_for_their_steps() {
    let mut sprung = 0;
    for shipped in shipped() {
        let scene = shipped.load().unwrap();
        let frequency = fastest_squared(&scene).sqrt();
        sprung += usize::from(frequency > 0.0);
        let limit = scene.method.claims().stability_limit;
        let step = 1.0 / (scene.step_hz * f64::from(scene.substeps.least()));
        assert!(frequency * step <= 0.5 * limit, "{}: w h = {}", scene.name, frequency * step);
        // Its numbers hold for every body, so no body has its own substeps.
        assert!(
            frequency == 0.0 || scene.bodies.iter().all(|body| body.substeps.is_none()),
            "{}",
            scene.name
        );
    }
    assert!(sprung >= 8, "only {sprung} scenes have springs");
    let rate = |name| fastest_squared(&load(name).unwrap()).sqrt();
    // The numbers in the comments of the files.
    let said =
        [("flag", 922.0), ("cape", 8764.0), ("jelly", 90.1), ("rope", 447.0), ("bridge", 89.4)];
    for (name, said) in said {
        assert!((rate(name) / said - 1.0).abs() < 2e-3, "{name}: {}", rate(name));
    }
}

#[test]
fn the_figure_eight_starts_with_its_momentum_and_angular_momentum_zero() {
    let scene = load("figure_eight").unwrap();
    let (mut momentum, mut angular) = (DVec3::ZERO, DVec3::ZERO);
    for body in &scene.bodies {
        momentum += body.velocity;
        angular += body.position.cross(body.velocity);
    }
    assert!(momentum.length() < 1e-15 && angular.length() < 1e-15, "{momentum} {angular}");
    assert_eq!((scene.bodies.len(), scene.mutual_gravity.unwrap().constant), (3, 1.0));
}

#[test]
fn everything_declares_each_effect_once() {
    let scene = load("everything").unwrap();
    let declared: Vec<_> = scene.declared.iter().map(|found| found.effect).collect();
    assert_eq!(declared, Effect::ALL);
    assert!(scene.declared.iter().all(|found| found.line.is_some()));
    assert_eq!(
        (scene.laws.wells.as_ref().unwrap().0.len(), scene.own_laws.len(), scene.springs.len()),
        (1, 1, 1)
    );
    assert_eq!((scene.emitters.len(), scene.soft_bodies.len()), (1, 0));
    assert_eq!(scene.bodies.iter().filter(|body| body.max_speed.is_some()).count(), 1);
}

#[test]
fn the_pools_of_fountain_and_sparks_have_as_many_as_live_at_once() {
    for (name, bodies) in [("fountain", 1200.0), ("sparks", 100_000.0)] {
        let emitters = load(name).unwrap().emitters;
        let (living, pools) = emitters.iter().fold((0.0, 0), |(living, pools), emitter| {
            (living + emitter.rate * emitter.life, pools + emitter.pool.len())
        });
        assert!(living == bodies && pools as f64 == bodies, "{name}: {living} of {pools}");
    }
}

#[test]
fn search_finds_letters_in_order_and_the_best_first() {
    let names = |query| find(query).iter().map(|scene| scene.name).collect::<Vec<_>>();
    assert_eq!(names("tut"), ["tutorial", "tutorial_large"]);
    assert_eq!(names("LARGE"), ["tutorial_large"]);
    assert_eq!(names("fmst"), ["frame_step"]);
    assert_eq!(names("zzz"), [""; 0]);
    assert_eq!(names("").len(), shipped().len());
}

#[test]
fn an_unknown_name_lists_the_shipped_ones_and_the_nearest() {
    let all = shipped().iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ");
    assert_eq!(
        load("tutorail").unwrap_err().to_string(),
        format!(
            "tutorail: there is no such scene; did you mean tutorial? shipped scenes are {all}; a file needs its path"
        )
    );
    assert_eq!(
        load("warp").unwrap_err().to_string(),
        format!("warp: there is no such scene; shipped scenes are {all}; a file needs its path")
    );
}

#[test]
fn a_file_that_cannot_be_read_says_why() {
    let folder = std::env::temp_dir().join(format!("inertia-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_string_lossy().into_owned()
    };
    let error = |path: &str| load(path).unwrap_err().to_string().replace(path, "PATH");

    assert_eq!(error("no/such.ron"), "PATH: there is no such file; check the path");
    assert_eq!(
        error(&folder.to_string_lossy()),
        "PATH: this is a folder; give the path of a file in it"
    );
    let latin = write("latin.ron", b"(version: 1,\n name: \"caf\xe9\")");
    assert_eq!(error(&latin), "PATH: line 2 is not UTF-8 text; save the file as UTF-8");
    let large = folder.join("large.ron");
    File::create(&large).unwrap().set_len(FILE_LIMIT + 1).unwrap();
    let cure = "give one of at most 64 MiB; clouds and grids are short to write";
    assert_eq!(error(&large.to_string_lossy()), format!("PATH: the file is too large; {cure}"));

    let marked = write("marked.ron", "\u{feff}(version: 1)".as_bytes());
    let scene = load(&marked).unwrap();
    assert_eq!((scene.name.as_str(), scene.source), ("marked", Source::File(marked.into())));
    std::fs::remove_dir_all(folder).unwrap();
}
