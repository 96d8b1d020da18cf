//! The window: winit events in, the wall clock, a swap chain out. The session does everything in between.

mod display;
mod drafts;
mod pinch;
mod pointer;
mod program;
mod recorder;
mod remembered;
mod screen;
mod shell;
mod system;
mod wheel;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;
use history::Overrides;
use lab::lesson::{RunLimit, run_lesson};
use scene::Source;
use scene::lesson::beside;
use winit::event_loop::DeviceEvents;

use self::drafts::Drafts;
use self::recorder::Recorder;
use self::shell::Shell;
use crate::args::{SceneName, StepArgs, cores, rate, size};
use crate::failure::Failure;
use crate::output::bundle;
use crate::output::command_files::CommandFiles;
use crate::output::progress::{Loading, Waiting};
use crate::output::tell;
use cockpit::app::arrangement::FIRST_START;
use cockpit::app::script::player_of;
use cockpit::app::session::{DEFAULT_FPS, Session};
use cockpit::stage::options::{Options, check};

/// Opens the window.
#[derive(Args, Debug)]
pub(crate) struct WindowArgs {
    /// A shipped scene, a file or a bundle [default: tutorial]
    pub scene: Option<SceneName>,
    /// Start paused
    #[arg(long)]
    pub paused: bool,
    /// Play a script
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Show the tutorial's picture alone, in camera mode; F10 shows the bars and the dock around it
    #[arg(long)]
    pub bare: bool,
    /// Simulated seconds per second, if not those of the scene
    #[arg(long, value_name = "P", allow_negative_numbers = true, value_parser = rate, conflicts_with = "record")]
    pub pace: Option<f64>,
    /// Size of the window, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    #[command(flatten)]
    pub step: StepArgs,
    /// Begin this lesson: a lesson of the program, or a file
    #[arg(long, value_name = "LESSON", conflicts_with_all = ["scene", "script", "bare", "record"])]
    pub lesson: Option<String>,
    /// Start as for the first time, and remember nothing: for computers that many people use
    #[arg(long)]
    pub guest: bool,
    /// Record inputs and frame times, for `run --script`
    #[arg(long, value_name = "FILE", conflicts_with_all = ["script", "paused", "substeps"])]
    pub record: Option<PathBuf>,
}

/// Opens the window and runs until it is closed.
pub(crate) fn open(args: &WindowArgs) -> Result<(), Failure> {
    system::leave_own_console();
    system::leave_root_folder();
    let mut files = CommandFiles::default();
    let lesson = args.lesson.as_deref().map(|name| files.lesson(name)).transpose()?;
    let home = lesson.as_ref().map(|lesson| beside(&lesson.name, &lesson.scene));
    let tutorial = || SceneName::from(OsString::from("tutorial"));
    let name = args
        .scene
        .clone()
        .or(home.map(|home| OsString::from(home).into()))
        .unwrap_or_else(tutorial);
    let mut session = session(args, &name, &mut files)?;
    let name = &*name;
    if let Some(lesson) = lesson {
        let _waiting = Waiting::begin("measuring the runs of the lesson");
        let of_runs = run_lesson(&lesson, 1.0, RunLimit::USUAL)?;
        session.begin_lesson(lesson, of_runs);
    }
    if let Some(path) = &args.script {
        let script = files.script(path, &session.stage.sim().scene)?;
        session.play(player_of(script));
    }
    for path in remembered::paths() {
        files.read("the window's settings", &path)?;
    }
    let record =
        |path| Recorder::new(files.claim("--record", path)?, name, args.step.method, args.size);
    let recorder = args.record.as_deref().map(record).transpose()?;
    let event_loop = display::event_loop(name)?;
    display::end_with(&event_loop);
    let drafts = if args.guest { Drafts::none() } else { Drafts::begin() };
    let mut shell = Shell::new(session, recorder, drafts, files, event_loop.create_proxy());
    forecast_start(&mut shell.session);
    let has_bars = !args.bare && args.script.is_none();
    let remembers = has_bars && !args.guest;
    if has_bars {
        let is_first = args.guest || remembered::is_first();
        let shows_card = is_first && args.lesson.is_none() && args.scene.is_none();
        if remembers && is_first {
            remembered::note_first(shows_card);
        }
        let left =
            if args.guest { String::new() } else { remembered::read(remembered::ARRANGEMENT) };
        let left = left.replace(FIRST_START, "");
        shell.arrangement =
            Some(if shows_card { FIRST_START.to_owned() + &left } else { left.clone() });
        shell.arranged = remembers.then_some(left);
        shell.session.opened = true;
    }
    if remembers {
        let left = shell.drafts.left_behind().into_iter().next();
        // A recording keeps its scene, and shows no list that another machine does not have.
        if shell.recorder.is_none() {
            shell.session.stage.files.remember(remembered::files());
            shell.session.tools.lessons().own = remembered::lessons();
            shell.remembered = Some(shell.session.stage.files.all().to_owned());
            if let Source::File(path) = shell.session.stage.sim().scene.source.clone() {
                shell.session.stage.files.note(&path);
            }
            if let Some(draft) = left {
                shell.session.offer(draft);
            }
        }
    }
    // Always, because the wheel works here even while another window has the keyboard.
    event_loop.listen_device_events(DeviceEvents::Always);
    let ended = event_loop.run_app(&mut shell).map_err(|error| {
        Failure::NoDisplay(format!(
            "the window system failed: {}",
            display::without_place(&error.to_string())
        ))
    });
    let ended = ended.and(shell.failure.map_or(Ok(()), Err));
    shell.drafts.end();
    let recorded = shell.recorder.map_or(Ok(()), |recorder| {
        recorder.finish(shell.session.stage.playback().frames(), &shell.session.chosen)
    });
    if let (Err(_), Err(failure)) = (&ended, &recorded) {
        tell(&failure.to_string());
    }
    ended.and(recorded)
}

/// The session that the window begins with: a scene, or a bundle just before its fault.
fn session(
    args: &WindowArgs,
    name: &SceneName,
    files: &mut CommandFiles,
) -> Result<Session, Failure> {
    let StepArgs { method, substeps, threads } = args.step;
    let options = Options {
        size_px: args.size,
        paused: args.paused,
        pace: args.pace,
        threads: threads.unwrap_or_else(cores),
        ..Options::default()
    };
    if let Some(bundle) = files.named_bundle(name)? {
        if method.is_some() || substeps.is_some() || args.record.is_some() {
            let what = "a bundle repeats its own run; leave --method, --substeps and --record out";
            return Err(Failure::Usage(format!("{name}: {what}")));
        }
        return bundle::opened(&bundle, name, options);
    }
    let loading = Loading::begin();
    let scene = files.named_scene(name)?;
    let overrides = Overrides { method, substeps, ..Overrides::default() };
    check(overrides, &scene)?;
    loading.next();
    let mut session = Session::new(scene, Options { overrides, ..options });
    session.stage.keep_timeline();
    Ok(session)
}

/// Begins to tell the person which parts of the scene are unstable at its start.
fn forecast_start(session: &mut Session) {
    session.tools.forecast_begin(&mut session.stage, 1.0 / DEFAULT_FPS);
}
