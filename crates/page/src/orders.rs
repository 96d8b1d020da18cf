//! Carries out the orders of a session in a page: files as downloads, drafts in the browser's storage.

use std::path::Path;

use cockpit::app::pictures::png;
use cockpit::app::session::Session;
use cockpit::stage::notices::Topic;
use cockpit::stage::{Order, SceneFile};
use render::{Image, Screen};
use scene::Scene;

use crate::shell::Shell;
use crate::shots::Shot;

impl Shell {
    pub(crate) fn carry_out_orders(&mut self) {
        let orders = self.session.stage.take_orders();
        for order in orders {
            if let Err(why) = self.carry_out(order) {
                self.session.stage.notices.say(Topic::FileError, why);
            }
        }
    }

    fn carry_out(&mut self, order: Order) -> Result<(), String> {
        match order {
            Order::Screenshot(name) => {
                let name =
                    name.unwrap_or_else(|| next(&mut self.counts.screenshots, "screenshot", "png"));
                self.shoot(name, false)?;
            }
            Order::Bundle => {
                let name = next(&mut self.counts.bundles, "bundle", "zip");
                self.shoot(name, true)?;
            }
            Order::Table(text) => {
                let name = next(&mut self.counts.tables, "graph", "csv");
                self.save(&name, text.as_bytes());
            }
            Order::Scene(file) => self.save_scene(&file),
            Order::Open(name) => {
                let scene = self.load(&name).map_err(|error| error.to_string())?;
                self.session.open(scene);
                self.opened();
            }
            Order::Lesson(name) => self.begin_lesson(&name)?,
            Order::Restore(draft) => self.restore(&draft)?,
            Order::Forget(draft) => self.host.set(&draft.to_string_lossy(), None),
            Order::Quit => return Err("Close the tab to quit.".to_owned()),
        }
        Ok(())
    }

    /// Begins to draw a picture for a file.
    fn shoot(&mut self, name: String, is_bundle: bool) -> Result<(), String> {
        let Some(screen) = &mut self.screen else {
            return Err("There is no picture now.".to_owned());
        };
        let begin = |screen: &mut Screen, session: &mut Session| {
            let copy = screen.copy(&session.picture())?;
            Ok::<_, render::RenderError>((copy.begin_reading(&screen.gpu)?, copy))
        };
        let (reading, copy) =
            begin(screen, &mut self.session).map_err(|error| error.to_string())?;
        self.shots.push(Shot { copy, reading, name, is_bundle });
        Ok(())
    }

    /// Saves the pictures that are drawn.
    pub(crate) fn finish_shots(&mut self) {
        for shot in std::mem::take(&mut self.shots) {
            match shot.copy.finish_reading(&shot.reading) {
                None => self.shots.push(shot),
                Some(image) => {
                    if let Err(why) = self.finish(&shot, image.ok().as_ref()) {
                        self.session.stage.notices.say(Topic::FileError, why);
                    }
                }
            }
        }
    }

    fn finish(&mut self, shot: &Shot, image: Option<&Image>) -> Result<(), String> {
        let stage = &self.session.stage;
        let png = image.map(|image| png(image, stage));
        let bytes = if shot.is_bundle {
            let bundle = stage.bundle(png).ok_or("The recorded run cannot be reproduced.")?;
            bundle.write().map_err(|error| error.to_string())?
        } else {
            png.ok_or("The picture could not be read.")?
        };
        self.save(&shot.name, &bytes);
        Ok(())
    }

    fn save(&mut self, name: &str, bytes: &[u8]) {
        self.host.save(name, bytes);
        self.session.stage.notices.say(Topic::File, format!("wrote {name}"));
    }

    fn save_scene(&mut self, file: &SceneFile) {
        let name = file.path.file_name().unwrap_or(file.path.as_os_str());
        self.save(&name.to_string_lossy(), file.text.as_bytes());
        self.session.tools.saved_scene(&mut self.session.stage, file);
    }

    /// Restores the unsaved changes that are kept under a name.
    fn restore(&mut self, draft: &Path) -> Result<(), String> {
        let name = draft.to_string_lossy();
        let text = self.host.get(&name).ok_or("The unsaved changes are gone.")?;
        let scene = Scene::parse("restored", &text).map_err(|error| error.to_string())?;
        self.session.open_unsaved(scene, None);
        self.keep_draft();
        self.host.set(&name, None);
        Ok(())
    }
}

/// The next name of a file of the program.
fn next(count: &mut u32, start: &str, end: &str) -> String {
    *count += 1;
    format!("{start}_{count:03}.{end}")
}
