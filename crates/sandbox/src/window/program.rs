//! Carries out the orders of a session in a window: files in the working folder, words in the picture.

use std::path::{Path, PathBuf};

use render::Image;
use scene::Scene;

use super::drafts::{self, Drafts};
use super::forecast_start;
use super::screen::Screen;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::orders::{Kind, Program};
use crate::output::scenes::save_scene;
use cockpit::app::session::Session;
use cockpit::stage::SceneFile;
use cockpit::stage::notices::Topic;
use cockpit::view::on_device::words;

/// A window as the program around its session.
pub(super) struct WindowProgram<'a> {
    pub screen: Option<&'a mut Screen>,
    pub drafts: &'a mut Drafts,
    pub files: &'a mut CommandFiles,
}

impl Program for WindowProgram<'_> {
    fn picture(&mut self, session: &mut Session) -> Result<Option<Image>, Failure> {
        self.screen.as_mut().map(|screen| screen.image(session)).transpose()
    }

    fn folder(&self) -> Option<&Path> {
        Some(Path::new(""))
    }

    fn files(&mut self) -> &mut CommandFiles {
        self.files
    }

    /// The first name of its kind that no file has.
    fn name(&self, [start, end]: Kind, _: &Session) -> String {
        let name = |i: u32| format!("{start}_{i:03}.{end}");
        (1..)
            .map(name)
            .find(|name| !PathBuf::from(name).exists())
            .expect("there is always another number")
    }

    fn save_scene(&mut self, session: &mut Session, file: &SceneFile) -> Result<(), Failure> {
        save_scene(session, file)
    }

    fn report(
        &mut self,
        session: &mut Session,
        outcome: Result<&Path, Failure>,
    ) -> Result<(), Failure> {
        let (topic, words) = match outcome {
            Ok(path) => (Topic::File, format!("wrote {}", path.display())),
            Err(failure) => (Topic::FileError, failure.to_string()),
        };
        session.stage.notices.say(topic, words);
        Ok(())
    }

    fn opened(&mut self, session: &mut Session) -> Result<(), Failure> {
        forecast_start(session);
        // The scene runs even without its particles, and the person is told what is missing.
        if let Some(screen) = &self.screen {
            let said = words(&screen.surface.gpu, &session.stage.sim().scene);
            said.into_iter().for_each(|words| session.stage.notices.say(Topic::Other, words));
        }
        Ok(())
    }

    fn restore(&mut self, session: &mut Session, draft: &Path) {
        let read = scene::read_text(draft).and_then(|text| Scene::parse("restored", &text));
        match read {
            Ok(scene) => {
                session.open_unsaved(scene, drafts::file_of(draft));
                if self.drafts.keep(session) {
                    drafts::delete(draft);
                }
            }
            Err(error) => session.stage.notices.say(Topic::FileError, error.to_string()),
        }
    }

    fn forget(&mut self, draft: &Path) {
        drafts::delete(draft);
    }
}
