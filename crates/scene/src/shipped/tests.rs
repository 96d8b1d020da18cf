//! The shipped scenes, and loading by name and path.

use glam::DVec3;
use motion::{Damping, Gravity};
use pick::Shape;

use super::*;
use crate::scene::{CameraSpec, LightSpec, PushSpec, StepKind};

#[test]
fn every_shipped_scene_loads_under_its_own_name_with_a_description() {
    for shipped in shipped() {
        let scene = shipped.load().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.name, shipped.name);
        assert!(!scene.description.is_empty() && !scene.description.contains('\n'), "{}", scene.name);
        assert_eq!(scene.source, Source::Shipped(shipped.name));
    }
}

#[test]
fn every_file_of_the_folder_is_shipped() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes");
    let mut files: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name()).collect();
    let mut names: Vec<std::ffi::OsString> =
        shipped().iter().map(|scene| format!("{}.ron", scene.name).into()).collect();
    files.sort();
    names.sort();
    assert_eq!(files, names);
}

#[test]
fn the_tutorial_scene_has_the_tutorials_numbers() {
    let scene = load("tutorial").unwrap();
    assert_eq!(scene.bodies.len(), 29);
    let expected = [
        ("floor", [0.0, -2.0, 0.0], Shape::Cuboid { half_extents: DVec3::new(100.0, 2.0, 100.0) }, 0.0),
        ("player", [0.0, 5.0, 0.0], Shape::Cuboid { half_extents: DVec3::new(0.9, 2.55, 0.9) }, 0.5),
        ("enemy", [5.0, 5.0, 0.0], Shape::Cuboid { half_extents: DVec3::new(0.9, 2.7, 0.9) }, 0.5),
        ("bonus", [10.0, 5.0, 0.0], Shape::Sphere { radius: 0.25 }, 1.0),
    ];
    for ((id, body), (name, position, shape, inverse_mass)) in (0..).zip(&scene.bodies).zip(expected) {
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
            assert_eq!((body.inverse_mass, body.velocity, body.checker), (Some(10.0), DVec3::ZERO, true));
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
    assert!(scene("coast").gravity.is_none() && scene("coast").damping.is_some());
    let (frame, tutorial) = (scene("frame_step"), scene("tutorial"));
    assert_eq!((frame.step, frame.bodies == tutorial.bodies), (StepKind::Frame, true));
}

#[test]
fn search_finds_letters_in_order_and_the_best_first() {
    let names = |query| find(query).iter().map(|scene| scene.name).collect::<Vec<_>>();
    assert_eq!(names("tut"), ["tutorial", "tutorial_large"]);
    assert_eq!(names("LARGE"), ["tutorial_large"]);
    assert_eq!(names("fs"), ["frame_step"]);
    assert_eq!(names("zzz"), [""; 0]);
    assert_eq!(names("").len(), shipped().len());
}

#[test]
fn an_unknown_name_lists_the_shipped_ones_and_the_nearest() {
    let all = "tutorial, tutorial_large, empty, thousand, projectile, coast, frame_step";
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
    assert_eq!(error(&folder.to_string_lossy()), "PATH: this is a folder; give the path of a file in it");
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
