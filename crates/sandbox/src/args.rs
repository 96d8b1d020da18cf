//! Values of the command line, read and checked.

use std::ffi::OsString;
use std::fmt;
use std::ops::Deref;
use std::path::Path;

use clap::Args;
use motion::effects::Effect;
use motion::margin::NaturalModes;
use motion::{DampingModel, Method};
use report::numbers::number;
use scene::{Keeps, Scene, StepKind, Substepping};

use crate::failure::Failure;

/// A scene on the command line: its name, or the path of its file, which need not be UTF-8.
#[derive(Clone, Debug)]
pub(crate) struct SceneName {
    written: OsString,
    /// The name as messages show it.
    words: String,
}

impl SceneName {
    /// The path, if it is not UTF-8.
    pub fn path(&self) -> Option<&Path> {
        self.written.to_str().is_none().then_some(Path::new(&self.written))
    }
}

impl From<OsString> for SceneName {
    fn from(written: OsString) -> Self {
        let words = written.to_string_lossy().into_owned();
        Self { written, words }
    }
}

impl Deref for SceneName {
    type Target = str;

    fn deref(&self) -> &str {
        &self.words
    }
}

impl fmt::Display for SceneName {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.words)
    }
}

/// How a tick is integrated.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct StepArgs {
    /// Method of integration; overrides the scene. Bodies with their own method keep it
    #[arg(long, value_name = "M", value_parser = method)]
    pub method: Option<Method>,
    /// Substeps per tick; overrides the scene. Bodies with their own substeps keep them
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub substeps: Option<Substepping>,
    /// Threads that integrate; the results are the same for any number
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<usize>,
}

pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let parse = |text: &str| text.parse().ok().filter(|side| (1..=16_384).contains(side));
    match text.split_once('x').map(|(width, height)| (parse(width), parse(height))) {
        Some((Some(width), Some(height))) => Ok([width, height]),
        _ => Err("give width and height from 1 to 16384 pixels, as in 1280x720".to_owned()),
    }
}

/// Returns the given items without duplicates, in their order.
pub(crate) fn once<T: PartialEq + Clone>(given: &[T]) -> Vec<T> {
    let mut once = Vec::new();
    for item in given {
        if !once.contains(item) {
            once.push(item.clone());
        }
    }
    once
}

/// Parses the number of natural modes to print.
pub(crate) fn modes_count(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=NaturalModes::MOST).contains(count));
    count.ok_or_else(|| format!("give a whole number from 1 to {}", NaturalModes::MOST))
}

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a finite number above 0".to_owned()),
    }
}

/// Greatest number of ticks of a run: at a microsecond each they take a century.
pub(crate) const MOST_TICKS: f64 = 3e15;

/// Refuses `seconds` at `rate` ticks per second if they are more than [`MOST_TICKS`].
pub(crate) fn check_seconds(seconds: f64, rate: f64) -> Result<(), Failure> {
    if seconds * rate <= MOST_TICKS {
        return Ok(());
    }
    let [seconds, rate] = [seconds, rate].map(|value| number(value, 6));
    let what = format!("{seconds} s at {rate} Hz are too many ticks for one run");
    Err(Failure::Usage(format!("{what}; give fewer")))
}

/// Refuses a command whose runs of `scene` keep `keeps`, if that takes more memory than allowed.
pub(crate) fn check_memory(scene: &Scene, keeps: Keeps) -> Result<(), Failure> {
    scene.check_memory(keeps).map_err(|what| {
        let cure = "give fewer bodies, or more with --memory";
        Failure::Usage(format!("{}: {what}; {cure}", scene.name))
    })
}

/// Refuses a study of `seconds` of `scene` that takes more memory than allowed or too many ticks; a study without a length, which
/// no person gave, has few.
pub(crate) fn check_study(scene: &Scene, seconds: Option<f64>) -> Result<(), Failure> {
    // A run and its ledger beside the reference and the run that tells how uncertain that is.
    check_memory(scene, Keeps { ledger: true, compared: Some(2), ..Keeps::default() })?;
    seconds.map_or(Ok(()), |seconds| check_seconds(seconds, scene.step_hz))
}

pub(crate) fn rate(text: &str) -> Result<f64, String> {
    // The step, the reciprocal, has to be finite, too.
    match positive(text) {
        Ok(value) if (1.0 / value).is_infinite() => Err("give a larger number".to_owned()),
        other => other,
    }
}

pub(crate) fn whole(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| "give a whole number from 0 up".to_owned())
}

pub(crate) fn above_0(text: &str) -> Result<u64, String> {
    match whole(text) {
        Ok(value) if value > 0 => Ok(value),
        _ => Err("give a whole number from 1 up".to_owned()),
    }
}

/// Greatest number of copies of a problem that are timed.
const MOST_BODIES: u32 = 100_000;

pub(crate) fn bodies(text: &str) -> Result<u32, String> {
    let found = text.parse().ok().filter(|bodies| (1..=MOST_BODIES).contains(bodies));
    found.ok_or_else(|| format!("give a whole number from 1 to {MOST_BODIES}"))
}

/// Number of processors that this process may use.
pub(crate) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Greatest number of threads: more only wait for each other.
const MOST_THREADS: usize = 256;

pub(crate) fn threads(text: &str) -> Result<usize, String> {
    let found = text.parse().ok().filter(|threads| (1..=MOST_THREADS).contains(threads));
    found.ok_or_else(|| format!("give a whole number from 1 to {MOST_THREADS}"))
}

pub(crate) fn method(text: &str) -> Result<Method, String> {
    Method::from_name(text)
        .ok_or_else(|| format!("the methods are {}", names(Method::ALL.map(Method::name))))
}

pub(crate) fn effect(text: &str) -> Result<Effect, String> {
    Effect::from_name(text)
        .ok_or_else(|| format!("the effects are {}", names(Effect::ALL.map(Effect::name))))
}

pub(crate) fn damping(text: &str) -> Result<DampingModel, String> {
    DampingModel::from_name(text).ok_or_else(|| {
        format!("the models are {}", names(DampingModel::ALL.map(DampingModel::name)))
    })
}

fn names<const N: usize>(names: [&str; N]) -> String {
    names.join(", ")
}

/// Refuses a rate of ticks for a scene whose ticks follow the frames.
pub(crate) fn refuse_rate_of_frames(
    name: &str,
    scene: &Scene,
    hz: Option<f64>,
    cure: &str,
) -> Result<(), Failure> {
    if hz.is_some() && follows_frames(scene) {
        return Err(Failure::Usage(format!("{name} has one tick per frame; {cure}")));
    }
    Ok(())
}

/// Whether ticks follow the frames.
pub(crate) const fn follows_frames(scene: &Scene) -> bool {
    matches!(scene.step, StepKind::Frame)
}
