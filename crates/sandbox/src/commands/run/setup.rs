//! Sets up a run: the scene, its script, its frames and its length, checked before anything is written.

use std::path::Path;

use history::Overrides;
use render::{Film, Quality};
use report::numbers::{number, rounded};
use scene::lesson::{beside, is_same_scene};
use scene::{Action, Keeps, PictureAction, Scene, Script, shown};

use super::film::{GIF_FPS, frame_seconds_range, is_gif};
use super::{RunArgs, keeps_ledger};
use crate::args::{MOST_TICKS, check_seconds, cores, follows_frames, refuse_rate_of_frames};
use crate::commands::lessons::demonstration::Demonstration;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use cockpit::actions::{self, Act};
use cockpit::app::script::player_of;
use cockpit::app::session::{DEFAULT_FPS, Session};
use cockpit::clock::{FrameClock, FrameTime};
use cockpit::input::SwitchedBy;
use cockpit::panels::Panel;
use cockpit::stage::options::{Options, Words, check};
use cockpit::stage::playback::CATCH_UP;

/// Default length of a run, s of frames.
const DEFAULT_SECONDS: f64 = 10.0;

/// A run before it begins.
pub(super) struct Setup {
    pub scene: Scene,
    pub script: Option<Script>,
    /// The lesson that the run shows.
    pub demonstration: Option<Demonstration>,
    pub options: Options,
    pub ends: FrameEnds,
    /// Ticks of the run; `None`: to the end of the frame times.
    pub ticks: Option<u64>,
    /// Whether the run may go back, so that the last minute is kept.
    pub goes_back: bool,
}

impl Setup {
    /// Reads and checks what `args` name.
    pub fn new(args: &RunArgs, files: &mut CommandFiles) -> Result<Self, Failure> {
        let mut scene = files.named_scene(&args.scene)?;
        args.selection().check(&scene)?;
        if args.damping.is_some() && scene.damping.is_none() {
            return Err(Failure::Usage(format!(
                "{} declares no damping; leave --damping out",
                args.scene
            )));
        }
        refuse_rate_of_frames(&args.scene, &scene, args.hz, "leave --hz out and give --fps")?;
        let script = args.script.as_ref().map(|path| files.script(path, &scene)).transpose()?;
        let demonstration = demonstration(args, files)?;
        let recording = script.as_ref().and_then(|script| script.recording.as_ref());
        if recording.is_some() && (args.frame_times.is_some() || args.fps.is_some()) {
            let what = "a recording has frame times of its own; leave --fps and --frame-times out";
            return Err(Failure::Usage(what.to_owned()));
        }
        let overrides = Overrides {
            method: args.step.method.or(recording.and_then(|recording| recording.method)),
            step_hz: args.hz,
            damping: args.damping,
            substeps: args.step.substeps,
        };
        check(overrides, &scene)?;
        overrides.apply(&mut scene);
        let pictures = args.frames.is_some()
            || args.film.is_some()
            || script.as_ref().is_some_and(takes_pictures);
        // Only pictures and scripts need frames between two ticks.
        let unwatched =
            script.is_none() && args.lesson.is_none() && !pictures && !follows_frames(&scene);
        let usual = if args.film.as_deref().is_some_and(is_gif) { GIF_FPS } else { DEFAULT_FPS };
        let fps = args.fps.unwrap_or(usual);
        // A script acts between ticks: more frames than ticks would change nothing but the time that it takes.
        let acts_alone = script.is_some() && recording.is_none() && !pictures && args.fps.is_none();
        let fps = if unwatched || acts_alone && !follows_frames(&scene) {
            fps.min(scene.step_hz * pace(args, &scene))
        } else {
            fps
        };
        let ends = FrameEnds::new(
            args,
            files,
            recording.map(|recording| recording.frame_ends_s.clone()),
            fps,
        )?;
        if let Some(path) = &args.film {
            check_film(path, &ends)?;
        }
        let ticks = tick_limit(args, &scene, &ends)?;
        // As the window does, in which recordings are made.
        let goes_back =
            recording.is_some() || args.lesson.is_some() || script.as_ref().is_some_and(goes_back);
        let options = Options {
            size_px: recording.map_or(args.size, |recording| recording.size_px.into()),
            pictures,
            words: match args {
                RunArgs { no_hud: true, .. } => Words::None,
                RunArgs { captions: true, .. } => Words::Captions,
                RunArgs { film: Some(_), .. } => Words::Labels,
                _ => Words::All,
            },
            interpolate: pictures || script.is_some() || args.lesson.is_some(),
            catch_up: match ends {
                FrameEnds::Constant { rate } => Some((1.0 / rate).max(CATCH_UP)),
                FrameEnds::Lengths(_) | FrameEnds::Recorded(_) => None,
            },
            pace: args.pace,
            paused: false,
            overrides,
            threads: args.step.threads.unwrap_or_else(cores),
        };
        Ok(Self { scene, script, demonstration, options, ends, ticks, goes_back })
    }

    /// Checks that what the run keeps fits into the memory.
    pub fn check_memory(&self, args: &RunArgs) -> Result<(), Failure> {
        let Options { size_px, pictures, .. } = self.options;
        let keeps = Keeps {
            ledger: keeps_ledger(args, &self.scene),
            compared: None,
            black_box: args.black_box.is_some() || self.goes_back,
            pictures: pictures.then(|| {
                let film = if args.film.is_some() { Film::bytes(size_px) } else { 0 };
                Quality::from(args.quality).device_bytes(size_px) + film
            }),
        };
        self.scene.check_memory(keeps).map_err(|what| {
            let cure = "give fewer bodies, leave outputs out, or give more with --memory";
            Failure::Usage(format!("{}: {what}; {cure}", args.scene))
        })
    }

    /// The session of the run, its frames and its length.
    pub fn begin(self, args: &RunArgs) -> Result<(Session, FrameEnds, Option<u64>), Failure> {
        let mut session = Session::new(self.scene, self.options);
        if let Some(script) = self.script {
            session.play(player_of(script));
        }
        for effect in &args.without {
            session.stage.switch_effect(*effect, false, SwitchedBy::Flag).map_err(|error| {
                Failure::Usage(format!("{}: {error}; leave --without {effect} out", args.scene))
            })?;
        }
        Ok((session, self.ends, self.ticks))
    }
}

/// The lesson that the run shows.
fn demonstration(
    args: &RunArgs,
    files: &mut CommandFiles,
) -> Result<Option<Demonstration>, Failure> {
    let Some(name) = &args.lesson else { return Ok(None) };
    let lesson = files.lesson(name)?;
    let home = beside(&lesson.name, &lesson.scene);
    if !is_same_scene(&home, &args.scene) {
        let what = format!("the lesson {name} plays in {home}, not in {}; run {home}", args.scene);
        return Err(Failure::Usage(what));
    }
    Ok(Some(Demonstration::new(lesson, args.fps.unwrap_or(DEFAULT_FPS))))
}

/// Whether a script takes a screenshot.
fn takes_pictures(script: &Script) -> bool {
    script
        .steps
        .iter()
        .any(|step| matches!(step.action, Action::Picture(PictureAction::Screenshot(_))))
        || presses(script, &[Act::Screenshot])
}

/// Whether a script presses a key that needs the last minute.
fn goes_back(script: &Script) -> bool {
    presses(script, &[Act::StepBack, Act::Panel(Panel::Timeline), Act::SaveBundle])
}

/// Whether a script presses the key of one of `acts`.
fn presses(script: &Script, acts: &[Act]) -> bool {
    let mut keys = script.steps.iter().filter_map(|step| step.action.key());
    keys.any(|word| actions::presses_one_of(word, acts))
}

/// The times at which frames end.
pub(super) enum FrameEnds {
    /// Frame i at exactly `i / rate` seconds.
    Constant { rate: f64 },
    /// The lengths of frames, one after the other, s.
    Lengths(std::vec::IntoIter<f64>),
    /// The ends of the frames of a recording, s.
    Recorded(std::vec::IntoIter<f64>),
}

impl FrameEnds {
    /// Takes the frame times of `args` or of a recording, else `fps` frames per second.
    fn new(
        args: &RunArgs,
        files: &mut CommandFiles,
        recorded: Option<Vec<f64>>,
        fps: f64,
    ) -> Result<Self, Failure> {
        if let Some(path) = &args.frame_times {
            let text = files.text("--frame-times", path)?;
            let times = scene::parse_frame_times(&path.display().to_string(), &text)?;
            return Ok(Self::Lengths(times.into_iter()));
        }
        let constant = Self::Constant { rate: fps };
        Ok(recorded.map_or(constant, |ends| Self::Recorded(ends.into_iter())))
    }

    #[expect(clippy::cast_precision_loss, reason = "a count of frames")]
    pub fn next(&mut self, clock: &mut FrameClock, frame: u64) -> Option<FrameTime> {
        let time = match self {
            Self::Constant { rate } => clock.advance_to(frame as f64 / *rate),
            Self::Lengths(lengths) => clock.advance_by(lengths.next()?),
            Self::Recorded(ends) => clock.advance_to(ends.next()?),
        };
        Some(time.expect("checked when the times were read"))
    }

    /// The longest frame, s.
    pub fn longest(&self) -> f64 {
        match self {
            Self::Constant { rate } => 1.0 / rate,
            Self::Lengths(lengths) => lengths.as_slice().iter().copied().fold(0.0, f64::max),
            Self::Recorded(ends) => {
                let starts = [0.0].iter().chain(ends.as_slice());
                ends.as_slice()
                    .iter()
                    .zip(starts)
                    .map(|(end, start)| end - start)
                    .fold(0.0, f64::max)
            }
        }
    }
}

/// Checks that the format of a film can express how long its pictures are shown.
fn check_film(path: &Path, ends: &FrameEnds) -> Result<(), Failure> {
    let (shortest, longest) = frame_seconds_range(path).into_inner();
    let shown = ends.longest();
    let is_too_short =
        matches!(ends, FrameEnds::Constant { .. }) && shown < shortest * (1.0 - 1e-9);
    if !is_too_short && shown <= longest {
        return Ok(());
    }
    let shown = number(shown, 3);
    let what = format!(
        "{}: such a film shows a picture for {shortest} to {longest} s, and these frames take {shown} s",
        path.display()
    );
    Err(Failure::Usage(format!("{what}; give another --fps, or --frames for single pictures")))
}

/// Simulated seconds per second of frames.
fn pace(args: &RunArgs, scene: &Scene) -> f64 {
    args.pace.unwrap_or(scene.pace)
}

/// Ticks per second of a run with these frames.
fn tick_rate(scene: &Scene, ends: &FrameEnds) -> f64 {
    match ends {
        FrameEnds::Constant { rate } if follows_frames(scene) => *rate,
        FrameEnds::Constant { .. } | FrameEnds::Lengths(_) | FrameEnds::Recorded(_) => {
            scene.step_hz
        }
    }
}

/// Ticks of the run; `None`: to the end of the frame times.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and rounded")]
fn tick_limit(args: &RunArgs, scene: &Scene, ends: &FrameEnds) -> Result<Option<u64>, Failure> {
    let rate = tick_rate(scene, ends);
    let ticks = match (args.ticks, args.seconds, ends) {
        (Some(ticks), ..) => ticks,
        (None, None, FrameEnds::Lengths(_) | FrameEnds::Recorded(_)) => return Ok(None),
        (None, seconds, _) => {
            let seconds = seconds.unwrap_or_else(|| DEFAULT_SECONDS * pace(args, scene));
            check_seconds(seconds, rate)?;
            let ticks = (seconds * rate).round() as u64;
            if ticks == 0 {
                let [seconds, tick] = [seconds, rounded(1.0 / rate, 6)].map(shown);
                let what =
                    format!("{}: {seconds} s are less than half a tick of {tick} s", args.scene);
                return Err(Failure::Usage(format!(
                    "{what}; give --seconds {tick} or more, or --ticks"
                )));
            }
            ticks
        }
    };
    #[expect(clippy::cast_precision_loss, reason = "a bound")]
    if let FrameEnds::Constant { rate: fps } = ends
        && ticks as f64 / (rate * pace(args, scene)) * fps > MOST_TICKS
    {
        let [rate, fps] = [rate, *fps].map(|value| number(value, 6));
        let what = format!(
            "{ticks} ticks at {rate} Hz are more frames than a run can have, at {fps} per second"
        );
        return Err(Failure::Usage(format!("{what}; give a lower --fps, or fewer ticks")));
    }
    Ok(Some(ticks))
}
