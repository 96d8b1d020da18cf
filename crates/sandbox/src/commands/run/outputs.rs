//! The outputs of a run without a window: pictures, the states of its ticks, a summary, a bundle, and how it ended.

use std::path::{Path, PathBuf};

use motion::Totals;
use motion::ledger::Ledger;
use render::{Image, Quality};
use report::numbers::four_digits;
use scene::{Action, Scene, Script, Substepping};
use serde_json::Value;

use crate::commands::run::film::FilmFile;
use crate::commands::run::{RunArgs, forecast_start, keep_ledger};
use crate::failure::Failure;
use crate::output::black_box::{self, BlackBox};
use crate::output::command_files::CommandFiles;
use crate::output::files::{Output, OutputPath, is_standard_output, make_folder, output_file};
use crate::output::on_device::{self, Device, check, has_particles, refuse_rows};
use crate::output::orders::{BUNDLE, GRAPH, Kind, Program, SCREENSHOT};
use crate::output::pictures::{Camera, write_picture};
use crate::output::report::Summary;
use crate::output::states::States;
use crate::output::{show, tell, tell_all};
use cockpit::app::session::Session;
use cockpit::stage::options::Options;
use cockpit::stage::{SceneFile, Stage};
use cockpit::view::on_device::slow_words;

/// The outputs of a run.
pub(super) struct Outputs<'a> {
    args: &'a RunArgs,
    files: CommandFiles,
    pub watch: Watch,
    camera: Option<Camera>,
    /// The device of the particles of a run without a camera.
    device: Option<Device>,
    /// Pictures that were written.
    pictures: u64,
    film: Option<FilmFile>,
    summary: Option<Output>,
    black_box: Option<Output>,
    longest_frame: f64,
    /// Why the run was not continued.
    pub refused: Result<(), Failure>,
}

impl<'a> Outputs<'a> {
    /// Opens all files before the run, so that a file that cannot be written is an error now, and not after an hour.
    pub fn open(
        args: &'a RunArgs,
        paths: &OutputPaths,
        files: CommandFiles,
        session: &Session,
        longest_frame: f64,
    ) -> Result<Self, Failure> {
        let Options { size_px, pictures, .. } = *session.stage.options();
        let camera = pictures.then(|| Camera::new(size_px, args.quality.into())).transpose()?;
        let mut device = None;
        take_particles(args, &session.stage.sim().scene, camera.as_ref(), &mut device)?;
        if camera.is_some() {
            make_folder(folder(args).unwrap_or(Path::new("")))?;
        }
        let open = |path: &Option<OutputPath>| path.as_ref().map(output_file).transpose();
        let begin = |path: &OutputPath| States::begin(path, &session.stage, &args.selection());
        let state = paths.state.as_ref().map(begin).transpose()?;
        let outputs = Self {
            args,
            files,
            watch: Watch::new(state, args.every),
            summary: open(&paths.summary)?,
            black_box: open(&paths.black_box)?,
            film: paths.film.as_ref().map(|path| FilmFile::begin(path, size_px)).transpose()?,
            camera,
            device,
            pictures: 0,
            longest_frame,
            refused: Ok(()),
        };
        match (&outputs.camera, &outputs.device) {
            (Some(camera), _) => {
                eprintln!("drawing with {}", camera.gpu.info);
                slow_words(&camera.gpu, &session.stage.sim().scene)
                    .iter()
                    .for_each(|line| tell(line));
            }
            (None, Some(device)) => eprintln!("particles on {}", device.gpu.info),
            (None, None) => {}
        }
        Ok(outputs)
    }

    #[cfg(test)]
    pub fn lose_device(&self) {
        if let Some(camera) = &self.camera {
            camera.gpu.device.destroy();
        }
    }

    /// Adds a frame that ended at `now`, s, to the film and to the pictures.
    pub fn after_frame(&mut self, session: &mut Session, now: f64) -> Result<(), Failure> {
        let Some(camera) = &mut self.camera else { return Ok(()) };
        let frame = session.stage.playback().frames() - 1;
        let is_written = self.args.frames.is_some() && frame.is_multiple_of(self.args.frame_every);
        if !is_written && self.film.is_none() {
            return Ok(());
        }
        let image = camera.picture(session)?;
        if let Some(folder) = self.args.frames.as_ref().filter(|_| is_written) {
            let path = self.files.unread(&folder.join(numbered(PICTURE, frame)))?;
            write_picture(&image, &path, &session.stage)?;
            self.pictures += 1;
        }
        if let Some(film) = &mut self.film {
            let path = self.args.film.as_deref().unwrap_or(Path::new(""));
            film.add(image, now).map_err(|error| Failure::file("write", path, &error))?;
        }
        Ok(())
    }

    /// Writes the rest, and says how the run of `session` ended, which began with `start`.
    pub fn finish(self, mut session: Session, start: Totals) -> Result<(), Failure> {
        let Self {
            args,
            mut watch,
            mut camera,
            mut device,
            pictures,
            film,
            summary: summary_file,
            black_box: box_file,
            refused,
            ..
        } = self;
        session.stage.end_run();
        if let Err(failure) = watch.finish(&session.stage, args.state.as_deref()) {
            if session.stage.recorder().fault().is_none()
                && session.stage.quarantines().all().is_empty()
            {
                return Err(failure);
            }
            // A fault of the run is worse: continue, to report it and to write what can be written.
            tell(&failure.to_string());
        }
        let adapter = camera.as_ref().map(|camera| camera.gpu.info.to_string());
        let mut summary = Summary::of(&mut session, start, pictures, adapter);
        let failed =
            on_device::add_to(&mut summary, &session.stage, camera.as_mut(), device.as_mut());
        let picture = |session: &mut Session| still(session, camera);
        let mut black_box = None;
        if let Some((path, file)) = args.black_box.as_deref().zip(box_file) {
            black_box = black_box::write(path, file, &mut session, picture);
            summary.add("black_box", black_box.as_ref().map_or(Value::Null, BlackBox::json));
        }
        // If a file goes to standard output, the words go to standard error, so that they do not mix.
        let files = [&args.state, &args.summary, &args.black_box, &args.film];
        let shown = if files.into_iter().flatten().any(|path| is_standard_output(path)) {
            tell_all(&summary.to_table());
            Ok(())
        } else {
            show(&summary.to_table())
        };
        let unconverged = session.stage.sim().evaluations().unconverged_steps();
        if unconverged > 0 {
            eprintln!(
                "{unconverged} implicit steps did not converge; a higher step rate or more substeps may help"
            );
        }
        if let Some(what) = Substepping::excess(&session.stage.sim().world) {
            eprintln!("{what}");
        }
        let mut written = shown;
        if let (Some(path), Some(film)) = (&args.film, film) {
            written = written.and(
                film.finish(&session.stage).map_err(|error| Failure::file("write", path, &error)),
            );
        }
        if let (Some(path), Some(file)) = (&args.summary, summary_file) {
            let summary = file.finish_with(summary.to_json().as_bytes());
            written = written.and(summary.map_err(|error| Failure::file("write", path, &error)));
        }
        // The message about a run that waits forever already names the step.
        let left = if refused.is_ok() { steps_left(args, &session) } else { None };
        let verdict = match black_box {
            Some(black_box) => Err(black_box.verdict()),
            None => verdict(args, &session, failed).and(refused),
        };
        let verdict = match left {
            Some(left) if args.assert && verdict.is_ok() => Err(Failure::Expectation(left)),
            left => {
                left.iter().for_each(|left| tell(left));
                verdict
            }
        };
        if let (Err(_), Err(failure)) = (&verdict, &written) {
            tell(&failure.to_string());
        }
        verdict.and(written)
    }
}

impl Program for Outputs<'_> {
    fn picture(&mut self, session: &mut Session) -> Result<Option<Image>, Failure> {
        self.camera.as_mut().map(|camera| camera.picture(session)).transpose()
    }

    fn folder(&self) -> Option<&Path> {
        folder(self.args)
    }

    fn files(&mut self) -> &mut CommandFiles {
        &mut self.files
    }

    fn left_out(&self, [what, _]: Kind) {
        tell(&format!(
            "the {what} of the lesson is not written; name a folder for it with --frames"
        ));
    }

    fn name(&self, kind: Kind, session: &Session) -> String {
        numbered(kind, session.stage.playback().frames() - 1)
    }

    /// Writes nothing: a replayed recording must not replace a file that was changed after it.
    fn save_scene(&mut self, session: &mut Session, file: &SceneFile) -> Result<(), Failure> {
        eprintln!("{}: only the window writes scenes; nothing was written", file.path.display());
        session.tools.saved_scene(&mut session.stage, file);
        Ok(())
    }

    fn report(&mut self, _: &mut Session, outcome: Result<&Path, Failure>) -> Result<(), Failure> {
        let path = outcome?;
        self.pictures += u64::from(path.extension().is_some_and(|end| end == SCREENSHOT[1]));
        Ok(())
    }

    fn opened(&mut self, session: &mut Session) -> Result<(), Failure> {
        let told = forecast_start(self.args, session, self.longest_frame);
        self.refused = told.map(|told| told.iter().for_each(|line| tell(line)));
        if self.refused.is_ok() {
            let (scene, camera) = (&session.stage.sim().scene, self.camera.as_ref());
            self.refused = take_particles(self.args, scene, camera, &mut self.device);
        }
        keep_ledger(self.args, session);
        Ok(())
    }
}

/// Prepares for the particles of `scene` on the graphics device, which is that of the camera or `own`. That is opened for the first
/// scene with such particles.
fn take_particles(
    args: &RunArgs,
    scene: &Scene,
    camera: Option<&Camera>,
    own: &mut Option<Device>,
) -> Result<(), Failure> {
    if !has_particles(scene) {
        return Ok(());
    }
    match (camera, &own) {
        (Some(camera), _) => check(&camera.gpu, scene)?,
        (None, Some(device)) => check(&device.gpu, scene)?,
        (None, None) => *own = Some(Device::open(scene)?),
    }
    if args.state.is_some() { refuse_rows(scene) } else { Ok(()) }
}

/// A sentence about the steps of the script that the run did not reach.
fn steps_left(args: &RunArgs, session: &Session) -> Option<String> {
    let player = session.player()?;
    let (first, step) = player.left().min_by_key(|(place, _)| *place)?;
    let others = match player.left().count() - 1 {
        0 => " was".to_owned(),
        others => format!(", and {others} more were"),
    };
    // Only for a script: a lesson reports its own steps.
    let script = args.script.as_deref()?.display();
    let (when, tick, seconds) =
        (step.when, session.stage.sim().ticks(), session.stage.sim().seconds());
    Some(format!(
        "{script}: steps[{first}], at {when}{others} not reached: the run ended at tick {tick}, {seconds} s; let it last longer"
    ))
}

/// How the run ended; `failed` is the number of particles on the graphics device that failed.
fn verdict(args: &RunArgs, session: &Session, failed: u64) -> Result<(), Failure> {
    let quarantined = session.stage.quarantines().all();
    if let Some(first) = quarantined.first() {
        let count = quarantined.len();
        let more = if count > 1 { format!(" and {} more", count - 1) } else { String::new() };
        return Err(Failure::Quarantined(format!(
            "{}{more} quarantined in tick {}: {}",
            first.body, first.tick, first.what
        )));
    }
    // A run that went back from a fault, and was not continued, has not passed it.
    if let Some(fault) =
        session.stage.recorder().fault().filter(|fault| fault.tick > session.stage.sim().ticks())
    {
        return Err(Failure::Expectation(
            fault.named(&session.stage.sim().scene.names).to_string(),
        ));
    }
    let Some(expect) = session.stage.sim().scene.expect.filter(|_| args.assert) else {
        return Ok(());
    };
    if expect.finite == Some(true) && failed > 0 {
        let what = "particles on the graphics device are not finite any more";
        return Err(Failure::Expectation(format!("{failed} {what}")));
    }
    let Some(bound) = expect.energy_drift_below else { return Ok(()) };
    let drift = session.tools.ledger().map_or(f64::NAN, Ledger::relative_residual);
    // Written so that a NaN drift fails.
    if drift < bound {
        Ok(())
    } else {
        Err(Failure::Expectation(format!(
            "energy drifted by {}, not below {bound:e}",
            four_digits(drift)
        )))
    }
}

/// The paths of the outputs that flags name.
pub(super) struct OutputPaths {
    state: Option<OutputPath>,
    summary: Option<OutputPath>,
    black_box: Option<OutputPath>,
    film: Option<OutputPath>,
}

impl OutputPaths {
    /// Claims the paths, after everything has been read.
    ///
    /// # Errors
    /// If two outputs are the same file, or if one has a name that the run may give to a picture or to a file that a key writes.
    pub fn claim(
        args: &RunArgs,
        script: Option<&Script>,
        files: &mut CommandFiles,
    ) -> Result<Self, Failure> {
        let mut claim = |flag: &str, path: &Option<PathBuf>| {
            path.as_deref().map(|path| files.claim(flag, path)).transpose()
        };
        let paths = Self {
            state: claim("--state", &args.state)?,
            summary: claim("--summary", &args.summary)?,
            black_box: claim("--black-box", &args.black_box)?,
            film: claim("--film", &args.film)?,
        };
        let writes_names = args.frames.is_some() || script.is_some();
        if let Some(folder) = folder(args).filter(|_| writes_names) {
            let shots = script.iter().flat_map(|script| &script.steps).filter_map(|step| {
                if let Action::Picture(picture) = &step.action { picture.file() } else { None }
            });
            let shots: Vec<_> = shots.collect();
            let is_written = |name: &str| shots.contains(&name) || is_numbered(name);
            let what = "the pictures and files that the run makes there; give another";
            files.refuse_names(folder, is_written, what)?;
        }
        Ok(paths)
    }
}

/// The folder for pictures and for files that keys write. A lesson may be someone else's: what it saves is written only into a
/// folder that was named.
fn folder(args: &RunArgs) -> Option<&Path> {
    args.frames.as_deref().or_else(|| args.lesson.is_none().then_some(Path::new(".")))
}

/// The picture of a frame.
const PICTURE: Kind = ["frame", "png"];

/// The name of a file of that kind and frame.
fn numbered([what, extension]: Kind, frame: u64) -> String {
    format!("{what}_{frame:06}.{extension}")
}

/// Whether a frame may write a file of that name.
fn is_numbered(name: &str) -> bool {
    let digits = name.trim_matches(|c: char| !c.is_ascii_digit());
    let is_of = |frame| {
        [PICTURE, SCREENSHOT, GRAPH, BUNDLE].iter().any(|what| numbered(*what, frame) == name)
    };
    digits.parse().is_ok_and(is_of)
}

/// A picture of the present state, by `camera` if there is one already.
fn still(session: &mut Session, camera: Option<Camera>) -> Result<Image, Failure> {
    let mut camera = match camera {
        Some(camera) => camera,
        None => Camera::new(session.view.size_px(), Quality::FIXED)?,
    };
    session.lay_out_still();
    camera.picture(session)
}

/// Writes the rows of the state file, tick by tick.
pub(super) struct Watch {
    state: Option<States<Output>>,
    every: u64,
    last: Option<u64>,
    pub error: Option<std::io::Error>,
}

impl Watch {
    const fn new(state: Option<States<Output>>, every: u64) -> Self {
        Self { state, every, last: None, error: None }
    }

    pub fn after_tick(&mut self, stage: &Stage) {
        if stage.sim().ticks().is_multiple_of(self.every) {
            self.look(stage);
        }
    }

    pub fn look(&mut self, stage: &Stage) {
        if let (Some(state), None) = (&mut self.state, &self.error) {
            self.error = state.add(stage).err();
            self.last = Some(stage.sim().ticks());
        }
    }

    fn finish(&mut self, stage: &Stage, path: Option<&Path>) -> Result<(), Failure> {
        if self.state.is_some() && self.last != Some(stage.sim().ticks()) {
            self.look(stage);
        }
        let finished = match (self.error.take(), self.state.take()) {
            (Some(error), _) => Err(error),
            (None, Some(state)) => state.finish(),
            (None, None) => Ok(()),
        };
        finished.map_err(|error| Failure::file("write", path.unwrap_or(Path::new("")), &error))
    }
}
