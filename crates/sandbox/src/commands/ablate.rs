//! `sandbox ablate`: a scene run again without each of its effects, with the pictures at the end compared.

use clap::Args;
use motion::effects::Effect;
use render::Quality;
use scene::{Keeps, Scene};

use crate::args::{SceneName, above_0, check_memory, check_seconds, cores, positive};
use crate::commands::effects;
use crate::commands::list::Format;
use crate::output::command_files::CommandFiles;
use crate::output::pictures::Camera;
use crate::output::progress::Waiting;
use crate::output::show;
use cockpit::app::session::Session;
use cockpit::clock::FrameClock;
use cockpit::input::SwitchedBy;
use cockpit::stage::options::Options;

use crate::failure::Failure;
use cockpit::input::InputFrame;

pub(super) const EXAMPLES: &str = "\
Example:
  sandbox ablate everything --seconds 2 --no-pictures";

/// Runs a scene again without each of its effects.
#[derive(Args, Debug)]
pub(crate) struct AblateArgs {
    /// A shipped scene or a file
    pub scene: SceneName,
    /// Simulated seconds, in place of --ticks
    #[arg(long, value_name = "S", conflicts_with = "ticks", allow_negative_numbers = true, value_parser = positive)]
    pub seconds: Option<f64>,
    /// Ticks of each run
    #[arg(long, value_name = "N", default_value_t = effects::DEFAULT_TICKS, allow_negative_numbers = true, value_parser = above_0)]
    pub ticks: u64,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Do not compare the pictures at the end
    #[arg(long)]
    pub no_pictures: bool,
}

/// Does what `sandbox ablate` says.
pub(crate) fn run(args: &AblateArgs) -> Result<(), Failure> {
    let scene = CommandFiles::default().named_scene(&args.scene)?;
    args.seconds.map_or(Ok(()), |seconds| check_seconds(seconds, scene.step_hz))?;
    let ticks = args.seconds.map_or(args.ticks, |seconds| scene.ticks_in(seconds).max(1));
    let device = || Quality::FIXED.device_bytes(Options::default().size_px);
    let pictures = (!args.no_pictures).then(device);
    check_memory(&scene, Keeps { compared: Some(1), pictures, ..Keeps::default() })?;
    let _waiting = Waiting::begin("running the scene without each effect");
    let mut camera = if args.no_pictures { None } else { open_camera() };
    let full =
        camera.as_mut().map(|camera| last_picture(camera, &scene, ticks, None)).transpose()?;
    let mut failed = None;
    let text = effects::ablation(&scene, ticks, args.format, |effect| {
        let picture = last_picture(camera.as_mut()?, &scene, ticks, Some(effect));
        picture.map_err(|failure| failed = Some(failure)).ok().map(|picture| Some(picture) != full)
    });
    if let Some(failure) = failed {
        return Err(failure);
    }
    show(&text)
}

/// A camera; prints a line and returns `None` if there is no adapter.
fn open_camera() -> Option<Camera> {
    let camera = Camera::new(Options::default().size_px, Quality::FIXED);
    camera.map_err(|error| eprintln!("no pictures are compared: {error}")).ok()
}

/// The bytes of the picture after `ticks` ticks of `scene`, without one effect and without words.
fn last_picture(
    camera: &mut Camera,
    scene: &Scene,
    ticks: u64,
    without: Option<Effect>,
) -> Result<Vec<u8>, Failure> {
    let options = Options { interpolate: false, threads: cores(), ..Options::default() };
    let mut session = Session::new(scene.clone(), options);
    if let Some(effect) = without {
        // Cannot fail: `effect` is one that the scene declares.
        let _ = session.stage.switch_effect(effect, false, SwitchedBy::Flag);
    }
    session.stage.playback_mut().limit_ticks(ticks);
    let (mut clock, mut frame) = (FrameClock::default(), 0_u64);
    while session.stage.sim().ticks() < ticks {
        frame += 1;
        #[expect(clippy::cast_precision_loss, reason = "a count of frames")]
        let time =
            clock.advance_to(frame as f64 / scene.step_hz).expect("frames follow one another");
        session.advance(&InputFrame::NOTHING, time);
    }
    let mut frame = session.picture();
    // The words of the HUD say which effect is off, so they would always differ.
    frame.panels = None;
    camera.draw(&frame)?;
    Ok(camera.read()?.rgba)
}
