//! The files of a command: what it has read, and what it will write. No file is both.

use std::path::{Path, PathBuf};

use history::Bundle;
use scene::lesson::{Lesson, beside};
use scene::{Scene, SceneError, Script, Source};

use crate::args::SceneName;
use crate::failure::Failure;
use crate::output::bundle;
use crate::output::files::{OutputPath, place};
use cockpit::app::script::read_script;

/// The files that a command has read, and those that it will write under a name that a person gave.
///
/// Commands read files only through this type, and get the [`OutputPath`] that an output needs from it, so no output replaces a
/// file that was read.
#[derive(Debug, Default)]
pub(crate) struct CommandFiles {
    read: Vec<NamedFile>,
    claimed: Vec<NamedFile>,
}

/// The failure to load the file at `path` as a scene; names the cure if the file is a lesson.
fn not_a_scene(path: &Path, error: SceneError) -> Failure {
    if !scene::lesson::is_file(path) {
        return error.into();
    }
    let path = path.display();
    let cure =
        format!("`sandbox --lesson {path}` plays it, `sandbox lessons check {path}` checks it");
    Failure::Usage(format!("{path}: this is a lesson, not a scene; {cure}"))
}

/// A file, and what the command line calls it.
#[derive(Debug)]
struct NamedFile {
    what: String,
    place: PathBuf,
}

impl CommandFiles {
    /// Loads a shipped scene, a hard case or a file: [`scene::load`].
    pub fn scene(&mut self, name: &str) -> Result<Scene, Failure> {
        let scene = scene::load(name).map_err(|error| not_a_scene(Path::new(name), error))?;
        self.read_scene(&scene)?;
        Ok(scene)
    }

    /// Loads the scene that the command line names.
    pub fn named_scene(&mut self, name: &SceneName) -> Result<Scene, Failure> {
        let Some(path) = name.path() else { return self.scene(name) };
        let scene = scene::load_path(path).map_err(|error| not_a_scene(path, error))?;
        self.read_scene(&scene)?;
        Ok(scene)
    }

    /// Loads a hard case: [`scene::load_case`].
    pub fn case(&mut self, name: &str) -> Result<Scene, Failure> {
        let scene = scene::load_case(name)?;
        self.read_scene(&scene)?;
        Ok(scene)
    }

    fn read_scene(&mut self, scene: &Scene) -> Result<(), Failure> {
        match &scene.source {
            Source::File(path) => self.read("the scene", path),
            Source::Shipped(_) | Source::Text => Ok(()),
        }
    }

    /// Loads a lesson of the program or a file: [`scene::lesson::load`]. The scenes of its runs are read, too.
    pub fn lesson(&mut self, name: &str) -> Result<Lesson, Failure> {
        let lesson = scene::lesson::load(name)?;
        if !scene::lesson::is_shipped(name) {
            self.read("the lesson", Path::new(name))?;
        }
        let of_runs = lesson.runs.iter().filter_map(|run| run.scene.as_ref());
        for scene in of_runs.chain([&lesson.scene]).map(|scene| beside(&lesson.name, scene)) {
            if scene::embedded(&scene).is_none() {
                self.read("a scene of the lesson", Path::new(&scene))?;
            }
        }
        Ok(lesson)
    }

    /// Reads the script or recording of `--script`: [`read_script`].
    pub fn script(&mut self, path: &Path, scene: &Scene) -> Result<Script, Failure> {
        let text = self.text("--script", path)?;
        Ok(read_script(&path.display().to_string(), &text, scene)?)
    }

    /// Reads the text of a file: [`scene::read_text`].
    pub fn text(&mut self, what: &str, path: &Path) -> Result<String, Failure> {
        let text = scene::read_text(path)?;
        self.read(what, path)?;
        Ok(text)
    }

    /// Reads a bundle.
    pub fn bundle(&mut self, path: &Path) -> Result<Bundle, Failure> {
        let bundle = bundle::read(path)?;
        self.read("the bundle", path)?;
        Ok(bundle)
    }

    /// Reads the bundle at the path `name`, if there is one: [`bundle::named`].
    pub fn named_bundle(&mut self, name: &SceneName) -> Result<Option<Bundle>, Failure> {
        if scene::embedded(name).is_some() {
            return Ok(None);
        }
        let path = name.path().unwrap_or(Path::new(&**name));
        let bundle = bundle::named(path)?;
        if bundle.is_some() {
            self.read("the bundle", path)?;
        }
        Ok(bundle)
    }

    /// Notes a file that the command has read, or will read.
    ///
    /// # Errors
    /// If the command will write the file.
    pub fn read(&mut self, what: &str, path: &Path) -> Result<(), Failure> {
        let file = NamedFile { what: what.to_owned(), place: place(path) };
        if let Some(output) = self.claimed.iter().find(|output| output.place == file.place) {
            let what = format!("{} writes this file; give another", output.what);
            return Err(Failure::Usage(format!("{}: {what}", path.display())));
        }
        self.read.push(file);
        Ok(())
    }

    /// The path of the output that `flag` names.
    ///
    /// # Errors
    /// If the file was read, or if another flag names it.
    pub fn claim(&mut self, flag: &str, path: &Path) -> Result<OutputPath, Failure> {
        let place = place(path);
        if let Some(other) = self.all().find(|file| file.place == place) {
            return Err(Failure::Usage(format!(
                "{} and {flag} name the same file; give two",
                other.what
            )));
        }
        self.claimed.push(NamedFile { what: flag.to_owned(), place });
        Ok(OutputPath::unread(path))
    }

    /// The path of an output that no flag names.
    ///
    /// # Errors
    /// If the file was read, or if a flag names it.
    pub fn unread(&self, path: &Path) -> Result<OutputPath, Failure> {
        let place = place(path);
        match self.all().find(|file| file.place == place) {
            Some(other) => {
                let what =
                    format!("this is {}, and not written over; give another folder", other.what);
                Err(Failure::Usage(format!("{}: {what}", path.display())))
            }
            None => Ok(OutputPath::unread(path)),
        }
    }

    /// Refuses `folder` if a file in it that was read, or that a flag names, has the name of a file that will be written there.
    pub fn refuse_names(
        &self,
        folder: &Path,
        is_written: impl Fn(&str) -> bool,
        cure: &str,
    ) -> Result<(), Failure> {
        let folder = place(folder);
        let clash = self.all().find(|file| {
            let name = file.place.file_name().unwrap_or_default().to_string_lossy();
            file.place.parent() == Some(&folder) && is_written(&name)
        });
        match clash {
            Some(NamedFile { what, place }) => {
                Err(Failure::Usage(format!("{what}: {} is a name of {cure}", place.display())))
            }
            None => Ok(()),
        }
    }

    fn all(&self) -> impl Iterator<Item = &NamedFile> {
        self.read.iter().chain(&self.claimed)
    }
}
