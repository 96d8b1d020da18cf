//! Scenes that a person made, as files.

use std::path::Path;

use crate::failure::Failure;
use crate::output::files::{OutputPath, make_folder, write};
use cockpit::app::session::Session;
use cockpit::stage::SceneFile;

/// Writes a scene of `session` into its file. Leaves a file alone that has the text already. Replaces another file only if it
/// still has the text that was opened or saved last.
pub(crate) fn save_scene(session: &mut Session, file: &SceneFile) -> Result<(), Failure> {
    let SceneFile { path, text, replaces, .. } = file;
    let there = path.exists().then(|| scene::read_text(path)).transpose()?;
    match there.as_deref() {
        Some(present) if *present == **text => {}
        Some(present) if Some(present) != replaces.as_deref() => {
            let what = "a file of this name exists, or it was changed since it was opened; save under another name";
            return Err(Failure::Usage(format!("{}: {what}", path.display())));
        }
        _ => {
            make_folder(path.parent().unwrap_or(Path::new("")))?;
            write(&OutputPath::of_program(path), text.as_bytes())?;
        }
    }
    session.tools.saved_scene(&mut session.stage, file);
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use scene::TextEdit;

    use super::*;
    use cockpit::actions::Act;
    use cockpit::intent::Intent;
    use cockpit::stage::Order;
    use cockpit::stage::options::Options;

    /// A session of a file.
    fn opened(path: &Path) -> Session {
        fs::write(path, "(version: 1, bodies: [(name: \"ball\")])").expect("a folder");
        let scene = scene::load(&path.to_string_lossy()).expect("a scene");
        Session::new(scene, Options { pictures: false, ..Options::default() })
    }

    fn change(session: &mut Session, mass_kg: &str) {
        session
            .carry_out(Intent::Rewrite(vec![TextEdit::set("bodies[0]", "mass_kg", mass_kg)], None));
        assert!(session.has_unsaved_changes());
    }

    /// Saves as a person does.
    fn save(session: &mut Session) -> Result<(), Failure> {
        session.carry_out(Intent::Act(Act::SaveScene));
        let orders = session.stage.take_orders();
        let [Order::Scene(file)] = &orders[..] else { panic!("{orders:?}") };
        save_scene(session, file)
    }

    fn scene_file(folder: &tempfile::TempDir) -> PathBuf {
        folder.path().join("mine.ron")
    }

    #[test]
    fn a_file_that_another_program_changed_is_not_overwritten() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = scene_file(&folder);
        let mut session = opened(&path);
        change(&mut session, "2.0");
        for other in ["", "(version: 1, bodies: [(name: \"ball\"), (name: \"other\")])"] {
            fs::write(&path, other).expect("a folder");
            let refused = save(&mut session).expect_err("it was changed").to_string();
            assert!(
                refused.contains("it was changed since it was opened; save under another name"),
                "{refused}"
            );
            assert_eq!(fs::read_to_string(&path).expect("a file"), other);
            assert!(session.has_unsaved_changes());
        }
        // A file that is gone is made again.
        fs::remove_file(&path).expect("a file");
        save(&mut session).expect("nothing is overwritten");
        assert!(fs::read_to_string(&path).expect("a file").contains("mass_kg: 2.0"));
    }

    #[test]
    fn what_was_saved_is_changed_and_saved_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = scene_file(&folder);
        let mut session = opened(&path);
        for mass in ["2.0", "3.0", "4.0"] {
            change(&mut session, mass);
            save(&mut session).expect("it is its own file");
            assert!(
                fs::read_to_string(&path).expect("a file").contains(&format!("mass_kg: {mass}"))
            );
            assert!(!session.has_unsaved_changes());
        }
        // Also by undoing, and without a change.
        session.carry_out(Intent::Act(Act::Undo));
        save(&mut session).expect("it is its own file");
        save(&mut session).expect("it is its own file");
        assert!(fs::read_to_string(&path).expect("a file").contains("mass_kg: 3.0"));
    }

    #[test]
    fn changes_that_were_left_behind_are_saved_into_their_file_unless_it_was_changed_since() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = scene_file(&folder);
        let mut session = opened(&path);
        let had = fs::read_to_string(&path).expect("a file");
        change(&mut session, "2.0");
        let (scene, file) =
            (scene::Scene::clone(&session.stage.sim().scene), session.tools.own_file());
        session.open(scene::load("tutorial").expect("a scene"));
        session.open_unsaved(scene, file);
        assert!(session.stage.playback().paused() && session.has_unsaved_changes());
        fs::write(&path, "(version: 1)").expect("a folder");
        save(&mut session).expect_err("it was changed since");
        fs::write(&path, had).expect("a folder");
        save(&mut session).expect("it is its own file");
        assert!(fs::read_to_string(&path).expect("a file").contains("mass_kg: 2.0"));
    }

    #[test]
    fn a_file_of_another_scenes_name_is_saved_under_its_own() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = scene_file(&folder);
        fs::write(&path, "(version: 1, name: \"tutorial\")").expect("a folder");
        let scene = scene::load(&path.to_string_lossy()).expect("a scene");
        let mut session = Session::new(scene, Options { pictures: false, ..Options::default() });
        session.carry_out(Intent::Act(Act::SaveScene));
        let orders = session.stage.take_orders();
        assert!(matches!(&orders[..], [Order::Scene(file)] if file.path == path), "{orders:?}");
    }
}
