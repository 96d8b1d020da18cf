//! Runs without a window: the same session and renderer, a constant or given frame time, files as output.

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use history::Overrides;
use lab::AttractionTick;
use motion::DampingModel;
use motion::effects::Effect;
use render::{Film, Quality};
use scene::{Action, Keeps, Scene, Script, StepKind};

use crate::actions::{self, Act};
use crate::app::player::Player;
use crate::app::script::{load_script, player_of};
use crate::app::session::{DEFAULT_FPS, Session};
use crate::args::{
    MOST_TICKS, StepArgs, above_0, check_seconds, damping, effect, positive, rate, size, whole,
};
use crate::clock::{FrameClock, FrameTime};
use crate::failure::Failure;
use crate::input::{InputFrame, SwitchedBy};
use crate::output::bundle::write_bundle;
use crate::output::files::{output_file, write};
use crate::output::pictures::Camera;
use crate::output::progress::{Loading, progress_bar};
use crate::output::report::Summary;
use crate::output::tell;
use crate::panels::Panel;
use crate::stage::options::{Options, check};
use crate::stage::{CATCH_UP, Order, Simulated, Stage};
use crate::tools::forecast::ForecastRow;

mod outputs;

use outputs::{
    BUNDLE, GRAPH, Outputs, PICTURE, SCREENSHOT, Watch, numbered, pictures_folder, refuse_same_files,
    state_file,
};
use report::numbers::long_duration;

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox run tutorial --seconds 5 --state states.csv
  sandbox run oscillator --method yoshida_4 --ledger --summary run.json
  sandbox run tutorial --script assets/scripts/tour.ron --seconds 6 --frames pictures";

/// Runs a scene without a window.
#[derive(Args, Debug)]
pub(crate) struct RunArgs {
    /// A shipped scene or a file
    pub scene: String,
    /// Simulated seconds [default: 10, or to the end of the frame times]
    #[arg(long, value_name = "S", conflicts_with = "ticks", allow_negative_numbers = true, value_parser = positive)]
    pub seconds: Option<f64>,
    /// Ticks
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole)]
    pub ticks: Option<u64>,
    /// Ticks per second; overrides the scene
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = rate)]
    pub hz: Option<f64>,
    #[command(flatten)]
    pub step: StepArgs,
    /// Damping model: tutorial, clamped or exact; overrides the scene
    #[arg(long, value_name = "MODEL", value_parser = damping)]
    pub damping: Option<DampingModel>,
    /// Start with this effect switched off; may be given several times
    #[arg(long, value_name = "EFFECT", value_parser = effect)]
    pub without: Vec<Effect>,
    /// Frames per second for scripts and pictures [default: 60]
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = rate)]
    pub fps: Option<f64>,
    /// A file with one frame time in seconds per line, instead of --fps
    #[arg(long, value_name = "FILE", conflicts_with = "fps")]
    pub frame_times: Option<PathBuf>,
    /// Play a script or a recording
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Check what the scene expects
    #[arg(long)]
    pub assert: bool,
    /// Keep a ledger of energy and momentum for the summary
    #[arg(long)]
    pub ledger: bool,
    /// Exit with code 1 before the first tick if the forecast finds something unstable
    #[arg(long)]
    pub refuse_unstable: bool,
    /// Write the state of every body as CSV
    #[arg(long, value_name = "FILE.csv")]
    pub state: Option<PathBuf>,
    /// Ticks between two states
    #[arg(long, value_name = "K", default_value_t = 1, requires = "state", allow_negative_numbers = true, value_parser = above_0)]
    pub every: u64,
    /// Stop at the first fault, a quarantined body or energy from nowhere, and write a bundle for `sandbox replay`
    #[arg(long, value_name = "FILE")]
    pub black_box: Option<PathBuf>,
    /// Write the summary as JSON
    #[arg(long, value_name = "FILE.json")]
    pub summary: Option<PathBuf>,
    /// Write pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub frames: Option<PathBuf>,
    /// Frames between two pictures
    #[arg(long, value_name = "K", default_value_t = 1, requires = "frames", allow_negative_numbers = true, value_parser = above_0)]
    pub frame_every: u64,
    /// Write all frames as one animated PNG; --fps says how many per second
    #[arg(long, value_name = "FILE.png")]
    pub film: Option<PathBuf>,
    /// Size of the pictures, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// How pictures are drawn: fixed is the same on every machine, high has smooth edges, round balls and fine shadows
    #[arg(long, value_enum, default_value_t)]
    pub quality: PictureQuality,
    /// Leave the words out of the pictures
    #[arg(long)]
    pub no_hud: bool,
}

/// How pictures are drawn.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum PictureQuality {
    #[default]
    Fixed,
    High,
}

impl From<PictureQuality> for Quality {
    fn from(quality: PictureQuality) -> Self {
        match quality {
            PictureQuality::Fixed => Self::FIXED,
            PictureQuality::High => Self::HIGH,
        }
    }
}

/// Seconds of a run that does not say how long.
const DEFAULT_SECONDS: f64 = 10.0;

/// When frames end.
enum FrameEnds {
    /// Frame i at exactly `i / rate` seconds.
    Constant { rate: f64 },
    /// One length after the other.
    Lengths(std::vec::IntoIter<f64>),
    /// The ends of a recording.
    Recorded(std::vec::IntoIter<f64>),
}

impl FrameEnds {
    #[expect(clippy::cast_precision_loss, reason = "a count of frames")]
    fn next(&mut self, clock: &mut FrameClock, frame: u64) -> Option<FrameTime> {
        let time = match self {
            Self::Constant { rate } => clock.advance_to(frame as f64 / *rate),
            Self::Lengths(lengths) => clock.advance_by(lengths.next()?),
            Self::Recorded(ends) => clock.advance_to(ends.next()?),
        };
        Some(time.expect("checked when the times were read"))
    }

    /// The longest frame, s.
    fn longest(&self) -> f64 {
        match self {
            Self::Constant { rate } => 1.0 / rate,
            Self::Lengths(lengths) => lengths.as_slice().iter().copied().fold(0.0, f64::max),
            Self::Recorded(ends) => {
                let starts = [0.0].iter().chain(ends.as_slice());
                ends.as_slice().iter().zip(starts).map(|(end, start)| end - start).fold(0.0, f64::max)
            }
        }
    }
}

/// Whether a script presses a key that needs the last minute.
fn goes_back(script: &Script) -> bool {
    let mut keys = script.steps.iter().filter_map(|step| step.action.key());
    keys.any(|word| actions::is_one_of(word, &[Act::StepBack, Act::Panel(Panel::Timeline), Act::SaveBundle]))
}

/// Does what `sandbox run` says.
pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
    let loading = Loading::begin();
    let mut scene = scene::load(&args.scene)?;
    if args.damping.is_some() && scene.damping.is_none() {
        return Err(Failure::Usage(format!("{} declares no damping; leave --damping out", args.scene)));
    }
    if args.hz.is_some() && follows_frames(&scene) {
        let what = format!("{} takes a step a frame; leave --hz out and give --fps", args.scene);
        return Err(Failure::Usage(what));
    }
    let script = args.script.as_ref().map(|path| load_script(path, &scene)).transpose()?;
    let recording = script.as_ref().and_then(|script| script.recording.clone());
    if recording.is_some() && (args.frame_times.is_some() || args.fps.is_some()) {
        let what = "a recording has frame times of its own; leave --fps and --frame-times out";
        return Err(Failure::Usage(what.to_owned()));
    }
    let recorded_method = recording.as_ref().and_then(|recording| recording.method);
    let overrides = Overrides {
        method: args.step.method.or(recorded_method),
        step_hz: args.hz,
        damping: args.damping,
        substeps: args.step.substeps,
    };
    check(overrides, &scene)?;
    overrides.apply(&mut scene);
    let takes_pictures =
        |script: &Script| script.steps.iter().any(|step| matches!(step.action, Action::Screenshot(_)));
    let wants_pictures =
        args.frames.is_some() || args.film.is_some() || script.as_ref().is_some_and(takes_pictures);
    // Frames between two ticks are for pictures and scripts.
    let unwatched = script.is_none() && !wants_pictures && !follows_frames(&scene);
    let fps = args.fps.unwrap_or(DEFAULT_FPS);
    let fps = if unwatched { fps.min(scene.step_hz) } else { fps };
    let recorded_ends = recording.as_ref().map(|recording| recording.frame_ends_s.clone());
    let mut ends = frame_ends(args, recorded_ends, fps)?;
    let ticks = tick_limit(args, &scene, &ends)?;
    // As the window does, whose recording it is.
    let goes_back = recording.is_some() || script.as_ref().is_some_and(goes_back);
    let size_px = recording.map_or(args.size, |recording| recording.size_px.into());
    let options = Options {
        size_px,
        pictures: wants_pictures,
        hud: !args.no_hud,
        interpolate: wants_pictures || script.is_some(),
        catch_up: match ends {
            FrameEnds::Constant { rate } => Some((1.0 / rate).max(CATCH_UP)),
            _ => None,
        },
        paused: false,
        overrides,
        threads: args.step.threads,
    };
    refuse_same_files(args, script.as_ref())?;
    let keeps = Keeps {
        ledger: keeps_ledger(args, &scene),
        black_box: args.black_box.is_some() || goes_back,
        pictures: wants_pictures.then(|| Quality::from(args.quality).device_bytes(size_px)),
    };
    scene.check_memory(keeps).map_err(|what| {
        let cure = "give fewer bodies, leave outputs out, or give more with --memory";
        Failure::Usage(format!("{}: {what}; {cure}", args.scene))
    })?;
    loading.next();
    let mut session = Session::new(scene, options);
    if let Some(script) = script {
        session.play(player_of(script));
    }
    for effect in &args.without {
        session.stage.switch_effect(*effect, false, SwitchedBy::Flag).map_err(|error| {
            Failure::Usage(format!("{}: {error}; leave --without {effect} out", args.scene))
        })?;
    }
    // Before anything is written.
    let longest_frame = ends.longest();
    loading.next();
    let told = forecast_start(args, &mut session, longest_frame)?;
    let long = ticks.and_then(|ticks| long_ticks(&session, ticks));
    told.iter().chain(&long).for_each(|line| loading.tell(line));
    let folder = pictures_folder(args);
    let mut camera = if wants_pictures {
        Some(Camera::new(size_px, args.quality.into(), folder.to_owned())?)
    } else {
        None
    };
    // Opened before the run: a place that cannot be written is found out now, and not after an hour.
    let state = args.state.as_deref().map(state_file).transpose()?;
    let summary_file = args.summary.as_deref().map(output_file).transpose()?;
    let box_file = args.black_box.as_deref().map(output_file).transpose()?;
    let film_file = args.film.as_deref().map(output_file).transpose()?;
    let mut film = film_file.map(|file| (Film::default(), file));
    if let Some(camera) = &camera {
        eprintln!("drawing with {}", camera.gpu.info);
    }

    loading.next();
    let start = Summary::start(&mut session.stage);
    drop(loading);
    keep_ledger(args, &mut session);
    if args.black_box.is_some() {
        session.stage.keep_black_box();
        if !session.stage.records() {
            let what = "too many bodies for a black box; leave --black-box out";
            return Err(Failure::Usage(format!("{}: {what}", args.scene)));
        }
    } else if goes_back {
        session.stage.keep_timeline();
    }
    let mut watch = Watch::new(state, args.every);
    watch.look(&session.stage);
    let progress = progress_bar(ticks);
    if let Some(ticks) = ticks {
        session.stage.limit_ticks(ticks);
    }
    let mut clock = FrameClock::default();
    let mut refused = Ok(());
    while refused.is_ok()
        && (ticks.is_none_or(|ticks| session.stage.ticks() < ticks) || session.stage.frames() == 0)
    {
        let frame_number = session.stage.frames();
        let Some(time) = ends.next(&mut clock, frame_number) else { break };
        session.advance_watched(&InputFrame::NOTHING, time, &mut |stage: &Stage, simulated| {
            if simulated == Simulated::New {
                watch.after_tick(stage);
            }
            ControlFlow::Continue(())
        });
        let orders = session.stage.take_orders();
        if let Some(camera) = &mut camera {
            let every = args.frames.is_some() && frame_number.is_multiple_of(args.frame_every);
            let shots = orders.iter().any(|order| matches!(order, Order::Screenshot(_)));
            if every || shots || film.is_some() {
                let frame = session.picture();
                camera.draw(&frame)?;
            }
            if let Some((film, _)) = &mut film {
                let added = film.add(camera.read()?, time.total());
                added.map_err(|error| Failure::Usage(format!("--film: {error}")))?;
            }
            if every {
                camera.write(&numbered(PICTURE, frame_number), &session.stage)?;
            }
            for order in &orders {
                if let Order::Screenshot(name) = order {
                    let name = name.clone().unwrap_or_else(|| numbered(SCREENSHOT, frame_number));
                    camera.write(&name, &session.stage)?;
                }
            }
        }
        for order in &orders {
            match order {
                Order::Table(text) => {
                    write(&folder.join(numbered(GRAPH, frame_number)), text.as_bytes())?;
                }
                Order::Scene(file) => {
                    // A recording that is repeated must not replace what came after it.
                    eprintln!("{}: only the window writes scenes; nothing was written", file.path.display());
                    session.tools.saved_scene(&mut session.stage, file);
                }
                _ => {}
            }
        }
        if orders.contains(&Order::Bundle) {
            let image = match &mut camera {
                Some(camera) => Some(camera.picture(&mut session)?),
                None => None,
            };
            let path = folder.join(numbered(BUNDLE, frame_number));
            write_bundle(&path, &session.stage, image.as_ref())?;
        }
        for refusal in session.stage.take_refusals() {
            tell(&format!("{}: {refusal}", session.stage.scene().name));
        }
        if watch.error.is_some() {
            break;
        }
        if orders.contains(&Order::Quit) || args.black_box.is_some() && session.stage.fault().is_some() {
            break;
        }
        for order in orders {
            if let Order::Open(name) = order {
                session.open(scene::load(&name)?);
                let told = forecast_start(args, &mut session, longest_frame);
                refused = told.map(|told| told.iter().for_each(|line| tell(line)));
                keep_ledger(args, &mut session);
            }
        }
        progress.set_position(session.stage.ticks());
        if let FrameEnds::Constant { rate } = ends
            && session.stage.paused()
            && session.stage.arrived()
        {
            if session.player().is_none_or(Player::finished) {
                // No script is left that could go on.
                break;
            }
            let now = session.stage.ticks();
            let waits = |player: &Player| player.waits_forever(session.stage.frames(), now, rate);
            if let Some(when) = session.player().and_then(waits) {
                refused = Err(Failure::Usage(format!(
                    "{}: the run is paused at tick {now}, and the next step of the script waits for {when}; let one before \
                     it press P",
                    args.scene
                )));
            }
        }
    }
    progress.finish_and_clear();
    let outputs = Outputs { args, watch, camera, film, summary: summary_file, black_box: box_file };
    outputs.finish(session, start, refused)
}

/// Lines about what would grow: more of them say the same.
const MOST_WARNINGS: usize = 3;

/// Warnings of what would grow without bound; an error if that was asked for.
fn forecast_start(args: &RunArgs, session: &mut Session, frame: f64) -> Result<Vec<String>, Failure> {
    let scene = session.stage.scene().name.clone();
    let rows = session.tools.forecast_start(&mut session.stage, frame);
    let line = |row: &ForecastRow| format!("{scene} is {}: {}", row.verdict(), row.line());
    let mut lines: Vec<_> = rows.iter().take(MOST_WARNINGS).map(line).collect();
    if args.refuse_unstable && !lines.is_empty() {
        return Err(Failure::Expectation(lines.swap_remove(0)));
    }
    let more = rows.len() - lines.len();
    if more > 0 {
        lines.push(format!("{scene}: {more} more are unstable; key V in the window lists them"));
    }
    Ok(lines)
}

/// Keeps the ledger that was asked for, or that a bound of the energy is checked by.
fn keep_ledger(args: &RunArgs, session: &mut Session) {
    if keeps_ledger(args, session.stage.scene()) {
        session.tools.keep_ledger(&mut session.stage);
    }
}

fn keeps_ledger(args: &RunArgs, scene: &Scene) -> bool {
    let bounds_energy = scene.expect.is_some_and(|expect| expect.energy_drift_below.is_some());
    args.ledger || args.assert && bounds_energy
}

/// Shorter runs are not announced, s.
const LONG: f64 = 10.0;

/// Announces a long run of bodies that all attract each other.
fn long_ticks(session: &Session, ticks: u64) -> Option<String> {
    let scene = session.stage.scene();
    let AttractionTick { bodies, seconds } = lab::attraction_tick(scene)?;
    #[expect(clippy::cast_precision_loss, reason = "a count of ticks")]
    let all = seconds * ticks as f64;
    let (name, tick, run) = (&scene.name, long_duration(seconds), long_duration(all));
    (all >= LONG).then(|| {
        format!("{name}: {bodies} bodies attract each other: a tick takes some {tick}, the run some {run}")
    })
}

/// The ends of the frames, `fps` a second where no list says otherwise.
fn frame_ends(args: &RunArgs, recorded: Option<Vec<f64>>, fps: f64) -> Result<FrameEnds, Failure> {
    if let Some(path) = &args.frame_times {
        let text = scene::read_text(path)?;
        let times = scene::parse_frame_times(&path.display().to_string(), &text)?;
        return Ok(FrameEnds::Lengths(times.into_iter()));
    }
    let constant = FrameEnds::Constant { rate: fps };
    Ok(recorded.map_or(constant, |ends| FrameEnds::Recorded(ends.into_iter())))
}

/// Ticks of the run; `None`: to the end of the frame times.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive and rounded")]
fn tick_limit(args: &RunArgs, scene: &Scene, ends: &FrameEnds) -> Result<Option<u64>, Failure> {
    let rate = match ends {
        FrameEnds::Constant { rate } if follows_frames(scene) => *rate,
        _ => scene.step_hz,
    };
    let ticks = match (args.ticks, args.seconds, ends) {
        (Some(ticks), ..) => ticks,
        (None, None, FrameEnds::Lengths(_) | FrameEnds::Recorded(_)) => return Ok(None),
        (None, seconds, _) => {
            let seconds = seconds.unwrap_or(DEFAULT_SECONDS);
            check_seconds(seconds, rate)?;
            (seconds * rate).round() as u64
        }
    };
    #[expect(clippy::cast_precision_loss, reason = "a bound")]
    if let FrameEnds::Constant { rate: fps } = ends
        && ticks as f64 / rate * fps > MOST_TICKS
    {
        let what =
            format!("{ticks} ticks at {rate:e} Hz are more frames, at {fps:e} a second, than a run can have");
        return Err(Failure::Usage(format!("{what}; give a lower --fps, or fewer ticks")));
    }
    Ok(Some(ticks))
}

/// Whether ticks follow the frames.
const fn follows_frames(scene: &Scene) -> bool {
    matches!(scene.step, StepKind::Frame)
}
