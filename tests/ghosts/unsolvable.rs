//! Effects that a method cannot solve, switched off while it is in use.

use glam::DVec3;
use motion::effects::Effect;
use motion::{Method, MutualGravity};
use sandbox::input::Input;
use scene::ChangeAction;

use crate::rigs::Drive;

fn give(drive: &mut Drive, action: ChangeAction) {
    drive.frame(1.0 / 120.0, [Input::Change(action)]);
}

fn method(drive: &mut Drive) -> Method {
    drive.session.stage.sim().bodies_per_method()[0].0
}

#[test]
fn mutual_gravity_stays_off_while_any_method_cannot_solve_it_also_one_that_moves_nothing() {
    let attracts =
        |drive: &Drive| drive.session.stage.sim().world.contains_resource::<MutualGravity>();
    let names = |drive: &Drive| -> Vec<String> {
        drive.session.stage.sim().scene.names.iter().map(|name| name.into_owned()).collect()
    };
    // The scene's method is in no body's use.
    let mut drive = Drive::shipped("figure_eight");
    give(&mut drive, ChangeAction::SwitchEffect(Effect::MutualGravity, false));
    for name in names(&drive) {
        give(&mut drive, ChangeAction::SetBodyMethod(name, Method::RungeKutta4));
    }
    give(&mut drive, ChangeAction::SetMethod(Method::ImplicitEuler));
    give(&mut drive, ChangeAction::SwitchEffect(Effect::MutualGravity, true));
    assert!(!attracts(&drive));
    drive.press("T").ticks(2);
    // A body of that method is quarantined.
    let mut drive = Drive::shipped("figure_eight");
    give(&mut drive, ChangeAction::SwitchEffect(Effect::MutualGravity, false));
    let first = names(&drive).remove(0);
    give(&mut drive, ChangeAction::SetBodyMethod(first.clone(), Method::ImplicitEuler));
    give(&mut drive, ChangeAction::SetVelocity(first, DVec3::NAN));
    give(&mut drive, ChangeAction::SwitchEffect(Effect::MutualGravity, true));
    assert!(!attracts(&drive));
    drive.press("T").ticks(2);
}

#[test]
fn ghosts_a_step_back_and_a_bundle_work_after_mutual_gravity_is_off_and_the_method_implicit() {
    let mut drive = Drive::shipped("figure_eight").recording();
    drive.ticks(10);
    give(&mut drive, ChangeAction::SwitchEffect(Effect::MutualGravity, false));
    give(&mut drive, ChangeAction::SetMethod(Method::ImplicitEuler));
    // Far enough for a snapshot of the timeline by that method.
    drive.ticks(60);
    assert_eq!(method(&mut drive), Method::ImplicitEuler);
    drive.press("T").ticks(8);
    assert!(!drive.session.tools.ghosts(&drive.session.stage).is_empty());
    let (ticks, hash) = (drive.session.stage.sim().ticks(), drive.hash());
    let bundle = drive.session.stage.bundle(None).expect("it comes out the same");
    assert_eq!(bundle.manifest.end_state_hash, format!("{hash:016x}"));
    drive.ticks(1).press(",");
    assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (ticks, hash));
    drive.session.seek(2);
    assert_eq!(
        (drive.session.stage.sim().ticks(), method(&mut drive)),
        (2, drive.session.stage.sim().scene.method)
    );
}
