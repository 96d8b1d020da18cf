//! Runs without a window: the same session and renderer, a constant or given frame time, files as output.

use std::fs;
use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use motion::{FrameClock, FrameTime, Ledger, Totals};
use render::{Gpu, Image, Offscreen, Quality, Renderer};
use scene::{Action, Recording, Scene, Script, Source};

use crate::actions::{self, Action as Key};
use crate::black_box;
use crate::bundle::write_bundle;
use crate::cli::{RunArgs, follows_frames, show};
use crate::failure::Failure;
use crate::files::Output;
use crate::player::Player;
use crate::report::{self, STATE_HEADER, Summary};
use crate::session::{CATCH_UP, Options, Order, Overrides, Session, Simulated, SwitchedBy};

/// Seconds of a run that does not say how long.
const DEFAULT_SECONDS: f64 = 10.0;

/// Frames a second of a run that does not say.
pub(crate) const DEFAULT_FPS: f64 = 60.0;

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

/// Ticks that no run comes to the end of: at a microsecond each, a century.
const MOST_TICKS: f64 = 3e15;

/// Draws frames into files.
struct Camera {
    gpu: Gpu,
    renderer: Renderer,
    target: Offscreen,
    folder: PathBuf,
    pictures: u64,
}

impl Camera {
    fn new(size: [u32; 2], folder: PathBuf) -> Result<Self, Failure> {
        let camera = Self::without_folder(size)?;
        // Last, so that a run that cannot draw leaves no folder.
        fs::create_dir_all(&folder).map_err(|error| Failure::file("make the folder", &folder, &error))?;
        Ok(Self { folder, ..camera })
    }

    /// One that draws, and writes nothing.
    fn without_folder(size: [u32; 2]) -> Result<Self, Failure> {
        let gpu = Gpu::headless()?;
        let renderer = Renderer::new(&gpu, render::OFFSCREEN_FORMAT, Quality::FIXED);
        let target = Offscreen::new(&gpu, size)?;
        Ok(Self { gpu, renderer, target, folder: PathBuf::new(), pictures: 0 })
    }

    fn draw(&mut self, frame: &render::Frame) -> Result<(), Failure> {
        if self.target.size_px() != frame.size_px {
            self.target = Offscreen::new(&self.gpu, frame.size_px)?;
        }
        self.renderer.draw(&self.gpu, frame, self.target.view());
        Ok(())
    }

    /// The present picture of `session`.
    fn picture(&mut self, session: &mut Session) -> Result<Image, Failure> {
        self.draw(&session.picture())?;
        Ok(self.target.read(&self.gpu)?)
    }

    fn write(&mut self, name: &str, session: &Session) -> Result<(), Failure> {
        let image: Image = self.target.read(&self.gpu)?;
        let path = self.folder.join(name);
        write_picture(&image, &path, session)?;
        self.pictures += 1;
        Ok(())
    }
}

/// Writes a picture with the settings that made it.
pub(crate) fn write_picture(image: &Image, path: &Path, session: &Session) -> Result<(), Failure> {
    let text = [
        ("Software", crate::PROGRAM.to_owned()),
        ("Scene", session.scene().name.clone()),
        ("Tick", session.ticks().to_string()),
        ("Method", session.stepper().method().name().to_owned()),
        ("StateHash", format!("{:016x}", report::state_hash(session))),
    ];
    let text: Vec<_> = text.iter().map(|(name, value)| (*name, value.as_str())).collect();
    image.write_png(path, &text).map_err(|error| Failure::file("write", path, &error))
}

/// Whether a script presses a key that needs the last minute.
fn goes_back(script: &Script) -> bool {
    let keys = script.steps.iter().filter_map(|step| step.action.key());
    let mut bound = keys.filter_map(|word| actions::binding(&actions::key_of_word(word).ok()?));
    bound.any(|row| matches!(row.action, Key::StepBack | Key::Timeline | Key::SaveBundle))
}

/// Reads a script or a recording and checks its keys, and its bodies against those of a scene.
pub(crate) fn load_script(path: &Path, scene: &Scene) -> Result<Script, Failure> {
    let name = path.display().to_string();
    let text = scene::read_text(path)?;
    let script = Script::parse(&name, &text)?;
    if let Some(recording) = &script.recording {
        check_scene(recording, &name, scene)?;
    }
    script.check(&name, &text, &scene.names, |word| actions::key_of_word(word).is_ok())?;
    Ok(script)
}

/// A recording means something in its own scene only; folders do not count, for files move.
fn check_scene(recording: &Recording, name: &str, scene: &Scene) -> Result<(), Failure> {
    let stem = |path: &Path| path.file_stem().map(std::ffi::OsStr::to_owned);
    let opened = match &scene.source {
        Source::Shipped(name) => Path::new(name),
        Source::File(path) => path,
        Source::Text => return Ok(()),
    };
    let recorded = &recording.scene;
    if stem(Path::new(recorded)) == stem(opened) {
        return Ok(());
    }
    let opened = opened.display();
    Err(Failure::Usage(format!("{name}: this was recorded in {recorded}, not in {opened}; open {recorded}")))
}

/// A player for a script that was loaded.
pub(crate) fn player_of(script: Script) -> Player {
    Player::new(script).expect("the keys of a loaded script are checked")
}

/// Does what `sandbox run` says.
pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
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
    overrides.check(&scene)?;
    overrides.apply(&mut scene);
    let takes_pictures =
        |script: &Script| script.steps.iter().any(|step| matches!(step.action, Action::Screenshot(_)));
    let wants_pictures = args.frames.is_some() || script.as_ref().is_some_and(takes_pictures);
    // Frames between two ticks are for who looks at them, or acts in them.
    let unwatched = script.is_none() && !wants_pictures && !follows_frames(&scene);
    let usual = if unwatched { scene.step_hz.min(DEFAULT_FPS) } else { DEFAULT_FPS };
    let recorded_ends = recording.as_ref().map(|recording| recording.frame_ends_s.clone());
    let mut ends = frame_ends(args, recorded_ends, usual)?;
    let ticks = tick_limit(args, &scene, &ends)?;
    // As the window does, whose recording it is.
    let goes_back = recording.is_some() || script.as_ref().is_some_and(goes_back);
    let size_px = recording.map_or(args.size, |recording| recording.size_px.into());
    let options = Options {
        size_px,
        pictures: wants_pictures,
        interpolate: wants_pictures || script.is_some(),
        catch_up: match ends {
            FrameEnds::Constant { rate } => Some((1.0 / rate).max(CATCH_UP)),
            _ => None,
        },
        paused: false,
        overrides,
        threads: args.step.threads,
    };
    let mut player = script.map(player_of);
    refuse_same_files(args)?;
    let mut session = Session::new(scene, options);
    for effect in &args.without {
        session.switch_effect(*effect, false, SwitchedBy::Flag).map_err(|error| {
            Failure::Usage(format!("{}: {error}; leave --without {effect} out", args.scene))
        })?;
    }
    // Before anything is written.
    let longest_frame = ends.longest();
    foretell(args, &mut session, longest_frame)?;
    let folder = args.frames.clone().unwrap_or_else(|| PathBuf::from("."));
    let mut camera = if wants_pictures { Some(Camera::new(size_px, folder)?) } else { None };
    // Opened before the run: a place that cannot be written is found out now, and not after an hour.
    let state = args.state.as_deref().map(state_file).transpose()?;
    let summary_file = args.summary.as_deref().map(output_file).transpose()?;
    let box_file = args.black_box.as_deref().map(output_file).transpose()?;
    if let Some(camera) = &camera {
        eprintln!("drawing with {}", camera.gpu.info);
    }

    let start = Summary::start(&mut session);
    keep_books(args, &mut session);
    if args.black_box.is_some() {
        session.keep_black_box();
        if !session.records() {
            let what = "too many bodies for a black box; leave --black-box out";
            return Err(Failure::Usage(format!("{}: {what}", args.scene)));
        }
    } else if goes_back {
        session.keep_timeline();
    }
    let mut watch = Watch { state, every: args.every, last: None, error: None };
    watch.look(&session);
    let progress = progress_bar(ticks);
    if let Some(ticks) = ticks {
        session.limit_ticks(ticks);
    }
    let mut clock = FrameClock::default();
    let mut refused = Ok(());
    while refused.is_ok() && (ticks.is_none_or(|ticks| session.ticks() < ticks) || session.frames() == 0) {
        let frame_number = session.frames();
        let Some(time) = ends.next(&mut clock, frame_number) else { break };
        let input =
            player.as_mut().map_or_else(Default::default, |player| player.input(&session, time.total()));
        session.advance_watched(&input, time, &mut |session, simulated| {
            if simulated == Simulated::Anew {
                watch.after_tick(session);
            }
            ControlFlow::Continue(())
        });
        let orders = session.take_orders();
        if let Some(camera) = &mut camera {
            let every = args.frames.is_some() && frame_number.is_multiple_of(args.frame_every);
            let shots = orders.iter().any(|order| matches!(order, Order::Screenshot(_)));
            if every || shots {
                let frame = session.picture();
                camera.draw(&frame)?;
            }
            if every {
                camera.write(&format!("frame_{frame_number:06}.png"), &session)?;
            }
            for order in &orders {
                if let Order::Screenshot(name) = order {
                    let name = name.clone().unwrap_or_else(|| format!("screenshot_{frame_number:06}.png"));
                    camera.write(&name, &session)?;
                }
            }
        }
        if orders.contains(&Order::Bundle) {
            let folder = args.frames.as_deref().unwrap_or(Path::new("."));
            let image = match &mut camera {
                Some(camera) => Some(camera.picture(&mut session)?),
                None => None,
            };
            let path = folder.join(format!("bundle_{frame_number:06}.zip"));
            write_bundle(&path, &session, image.as_ref())?;
        }
        for refusal in session.take_refusals() {
            eprintln!("{}: {refusal}", session.scene().name);
        }
        if watch.error.is_some() {
            break;
        }
        if orders.contains(&Order::Quit) || args.black_box.is_some() && session.fault().is_some() {
            break;
        }
        for order in orders {
            if let Order::Open(name) = order {
                session.open(scene::load(&name)?);
                refused = foretell(args, &mut session, longest_frame);
                keep_books(args, &mut session);
            }
        }
        progress.set_position(session.ticks());
        if let FrameEnds::Constant { rate } = ends
            && session.paused()
            && session.arrived()
        {
            if player.as_ref().is_none_or(Player::finished) {
                // Nobody is left who could go on.
                break;
            }
            if let Some(when) = player.as_ref().and_then(|player| player.waits_in_vain(&session, rate)) {
                let now = session.ticks();
                refused = Err(Failure::Usage(format!(
                    "{}: the run is paused at tick {now}, and the next step of the script waits for {when}; let one before \
                     it press P",
                    args.scene
                )));
            }
        }
    }
    progress.finish_and_clear();
    let outputs = Outputs { args, watch, camera, summary: summary_file, black_box: box_file };
    outputs.finish(session, start, refused)
}

/// What a run is written into when it is over.
struct Outputs<'a> {
    args: &'a RunArgs,
    watch: Watch,
    camera: Option<Camera>,
    summary: Option<Output>,
    black_box: Option<Output>,
}

impl Outputs<'_> {
    /// Writes all of it, and says how the run of `session` ended, which began with `start`; `refused` is why it was not
    /// gone on with.
    fn finish(
        self,
        mut session: Session,
        start: Totals,
        refused: Result<(), Failure>,
    ) -> Result<(), Failure> {
        let Self { args, mut watch, camera, summary: summary_file, black_box: box_file } = self;
        if let Err(failure) = watch.finish(&session, args.state.as_deref()) {
            if session.fault().is_none() && session.all_quarantined().is_empty() {
                return Err(failure);
            }
            // What went wrong in the run is worse, and is written where that can be done.
            eprintln!("{failure}");
        }
        let adapter = camera.as_ref().map(|camera| camera.gpu.info.to_string());
        let pictures = camera.as_ref().map_or(0, |camera| camera.pictures);
        let mut summary = Summary::of(&mut session, start, pictures, adapter);
        let picture = |session: &mut Session| still(session, camera);
        let mut black_box = None;
        if let Some((path, file)) = args.black_box.as_deref().zip(box_file) {
            black_box = black_box::write(path, file, &mut session, picture);
            summary.add_black_box(black_box.as_ref());
        }
        let shown = show(&summary.to_table());
        let unconverged = session.evaluations().unconverged_steps();
        if unconverged > 0 {
            eprintln!(
                "{unconverged} implicit steps did not converge; a higher step rate or more substeps may help"
            );
        }
        let mut written = shown;
        if let (Some(path), Some(mut file)) = (&args.summary, summary_file) {
            let summary = file.write_all(summary.to_json().as_bytes()).and_then(|()| file.finish());
            written = written.and(summary.map_err(|error| Failure::file("write", path, &error)));
        }
        let verdict = match black_box {
            Some(black_box) => Err(black_box.verdict()),
            None => verdict(args, &session).and(refused),
        };
        if let (Err(_), Err(failure)) = (&verdict, &written) {
            eprintln!("{failure}");
        }
        verdict.and(written)
    }
}

/// Files at one place would be written over each other, or over what is read.
fn refuse_same_files(args: &RunArgs) -> Result<(), Failure> {
    let scene = Path::new(&args.scene);
    let files = [
        ("the scene", Some(scene).filter(|scene| scene.is_file())),
        ("--script", args.script.as_deref()),
        ("--frame-times", args.frame_times.as_deref()),
        ("--state", args.state.as_deref()),
        ("--summary", args.summary.as_deref()),
        ("--black-box", args.black_box.as_deref()),
    ];
    let files: Vec<_> = files.into_iter().filter_map(|(name, path)| Some((name, place(path?)))).collect();
    for (number, (flag, path)) in files.iter().enumerate() {
        if let Some((other, _)) = files[..number].iter().find(|(_, other)| other == path)
            && !INPUTS.contains(flag)
        {
            return Err(Failure::Usage(format!("{other} and {flag} name the same file; give two")));
        }
    }
    Ok(())
}

/// What is read may be read twice.
const INPUTS: [&str; 2] = ["--script", "--frame-times"];

/// Where a file is, or will be.
fn place(path: &Path) -> PathBuf {
    let there = fs::canonicalize(path);
    there.unwrap_or_else(|_| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = fs::canonicalize(folder).or_else(|_| std::path::absolute(folder));
        folder.unwrap_or_default().join(path.file_name().unwrap_or_default())
    })
}

/// A picture of the present state, by `camera` if there is one already.
fn still(session: &mut Session, camera: Option<Camera>) -> Result<Image, Failure> {
    let mut camera = match camera {
        Some(camera) => camera,
        None => Camera::without_folder(session.size_px())?,
    };
    session.lay_out_still();
    camera.picture(session)
}

/// Lines about what would grow: more of them say the same.
const MOST_WARNINGS: usize = 3;

/// Says what would grow without bound, and refuses it where that was asked for.
fn foretell(args: &RunArgs, session: &mut Session, frame: f64) -> Result<(), Failure> {
    let scene = session.scene().name.clone();
    let rows = session.foretell(frame);
    let Some((worst, others)) = rows.split_first() else { return Ok(()) };
    let worst = format!("{scene} is unstable: {}", worst.line());
    if args.refuse_unstable {
        return Err(Failure::Expectation(worst));
    }
    eprintln!("{worst}");
    for row in others.iter().take(MOST_WARNINGS - 1) {
        eprintln!("{scene} is unstable: {}", row.line());
    }
    if rows.len() > MOST_WARNINGS {
        eprintln!(
            "{scene}: {} more are unstable; key V in the window lists them",
            rows.len() - MOST_WARNINGS
        );
    }
    Ok(())
}

/// Keeps the books that were asked for, or that a bound of the energy is checked by.
fn keep_books(args: &RunArgs, session: &mut Session) {
    let bounds_energy = session.scene().expect.is_some_and(|expect| expect.energy_drift_below.is_some());
    if args.ledger || args.assert && bounds_energy {
        session.keep_ledger();
    }
}

/// The ends of the frames, `usual` a second where nobody says otherwise.
fn frame_ends(args: &RunArgs, recorded: Option<Vec<f64>>, usual: f64) -> Result<FrameEnds, Failure> {
    if let Some(path) = &args.frame_times {
        let text = scene::read_text(path)?;
        let times = scene::parse_frame_times(&path.display().to_string(), &text)?;
        return Ok(FrameEnds::Lengths(times.into_iter()));
    }
    let constant = FrameEnds::Constant { rate: args.fps.unwrap_or(usual) };
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
            let ticks = (seconds * rate).round();
            if ticks > MOST_TICKS {
                let what = format!("{seconds:e} s at {rate:e} Hz are more ticks than a run can have");
                return Err(Failure::Usage(format!("{what}; give fewer")));
            }
            ticks as u64
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

/// Starts an output file, and makes its folder.
pub(crate) fn output_file(path: &Path) -> Result<Output, Failure> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|error| Failure::file("make the folder", folder, &error))?;
    }
    Output::create(path).map_err(|error| Failure::file("write", path, &error))
}

fn state_file(path: &Path) -> Result<Output, Failure> {
    let mut state = output_file(path)?;
    writeln!(state, "{STATE_HEADER}").map_err(|error| Failure::file("write", path, &error))?;
    Ok(state)
}

pub(crate) fn progress_bar(ticks: Option<u64>) -> ProgressBar {
    let bar = ticks.map_or_else(ProgressBar::new_spinner, ProgressBar::new);
    let style =
        ProgressStyle::with_template("{bar:40} {pos}/{len} ticks, {eta} left").expect("a valid template");
    bar.with_style(style)
}

/// Looks at every tick: rows of the state file.
struct Watch {
    state: Option<Output>,
    every: u64,
    last: Option<u64>,
    error: Option<std::io::Error>,
}

impl Watch {
    fn after_tick(&mut self, session: &Session) {
        if session.ticks().is_multiple_of(self.every) {
            self.look(session);
        }
    }

    fn look(&mut self, session: &Session) {
        if let (Some(state), None) = (&mut self.state, &self.error) {
            self.error = report::write_state(session, state).err();
            self.last = Some(session.ticks());
        }
    }

    fn finish(&mut self, session: &Session, path: Option<&Path>) -> Result<(), Failure> {
        if self.state.is_some() && self.last != Some(session.ticks()) {
            self.look(session);
        }
        let finished = match (self.error.take(), self.state.take()) {
            (Some(error), _) => Err(error),
            (None, Some(state)) => state.finish(),
            (None, None) => Ok(()),
        };
        finished.map_err(|error| Failure::file("write", path.unwrap_or(Path::new("")), &error))
    }
}

fn verdict(args: &RunArgs, session: &Session) -> Result<(), Failure> {
    let quarantined = session.all_quarantined();
    if let Some(first) = quarantined.first() {
        let count = quarantined.len();
        let more = if count > 1 { format!(" and {} more", count - 1) } else { String::new() };
        return Err(Failure::Quarantined(format!(
            "{}{more} quarantined in tick {}: {}",
            first.body, first.tick, first.what
        )));
    }
    // A run that went back from a fault, and was not gone on with, has not got past it.
    if let Some(fault) = session.fault().filter(|fault| fault.tick > session.ticks()) {
        return Err(Failure::Expectation(fault.named(&session.scene().names).to_string()));
    }
    let Some(expect) = session.scene().expect.filter(|_| args.assert) else { return Ok(()) };
    let Some(bound) = expect.energy_drift_below else { return Ok(()) };
    let drift = session.ledger().map_or(f64::NAN, Ledger::relative_residual);
    // Written so that a drift that is not a number fails.
    if drift < bound {
        Ok(())
    } else {
        Err(Failure::Expectation(format!("energy drifted by {drift:.3e}, not below {bound:e}")))
    }
}
