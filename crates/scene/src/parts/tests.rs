//! Which bodies are a part, and what goes with them.

use crate::{BodySpec, Scene, answers};

/// Each part: its name, entries and bodies, and what its scene has.
#[test]
fn springs_and_gravity_join_what_moves_and_no_entry_is_divided() {
    answers("parts/parts.txt", |text| {
        let scene = Scene::parse("t", text).unwrap_or_else(|error| panic!("{error}"));
        let parts = scene.parts().into_iter().map(|part| {
            let entries: Vec<_> = part.entries.iter().map(|entry| entry.path()).collect();
            let scene = part.scene;
            let effects: Vec<_> = scene.declared.iter().map(|found| found.effect).collect();
            let springs: Vec<_> = scene.springs.iter().map(|spring| spring.ends).collect();
            let soft: Vec<_> = scene.soft_bodies.iter().map(|soft| soft.points.clone()).collect();
            let pools: Vec<_> = scene.emitters.iter().map(|emitter| emitter.pool.clone()).collect();
            let own_laws: Vec<_> = scene.own_laws.keys().collect();
            let setting = |body: &BodySpec| (body.method, body.substeps);
            let settings: Vec<_> = scene.bodies.iter().map(setting).collect();
            format!(
                "{}: {entries:?} {:?}\n    {} {}; {effects:?}; mutual gravity {}; labels {:?}; own laws {own_laws:?}\n    \
                 springs {springs:?}; soft bodies {soft:?}; emitters {pools:?}\n    {:?}\n    {settings:?}\n",
                part.name,
                part.bodies,
                scene.method.name(),
                scene.substeps,
                scene.mutual_gravity.is_some(),
                scene.labels,
                scene.names.iter().collect::<Vec<_>>(),
            )
        });
        parts.collect()
    });
}
