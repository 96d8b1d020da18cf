//! The progress of studies and of loading, on a terminal.

use std::io::IsTerminal as _;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use lab::cost::Bench;

use super::tell;

/// Steps of the bar per study.
const STEPS: f64 = 1000.0;

/// Thread CPU time between two looks at a study, s.
pub(crate) const PIECE: f64 = 0.1;

/// A bar with the time left; hidden if standard error is not a terminal.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// A bar for that many studies.
    pub fn new(studies: usize) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self(ProgressBar::hidden());
        }
        let style = ProgressStyle::with_template("{bar:40} {percent} % {msg}, {eta} left")
            .expect("a valid template");
        let bar = ProgressBar::new(steps(studies, 0.0)).with_style(style);
        bar.enable_steady_tick(Duration::from_millis(500));
        Self(bar)
    }

    /// Names the present work.
    pub fn say(&self, what: impl Into<String>) {
        self.0.set_message(report::terminal(&what.into()).into_owned());
    }

    /// Shows the part of the work that is done, in [0, 1].
    pub fn show(&self, part: f64) {
        self.0.set_position(steps(0, part));
    }

    /// Finishes study `number`; calls `look` now and then.
    ///
    /// # Errors
    /// The errors of `look`.
    pub fn follow<E>(
        &self,
        number: usize,
        bench: &mut Bench,
        mut look: impl FnMut(&Bench) -> Result<(), E>,
    ) -> Result<(), E> {
        self.0.set_position(steps(number, 0.0));
        while !bench.work(PIECE) {
            self.0.set_position(steps(number, bench.progress()));
            look(bench)?;
        }
        Ok(())
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A bar for the work before the first tick, shown once that takes a second.
pub(crate) struct Loading {
    bar: ProgressBar,
    /// Dropping it ends the bar.
    _over: Sender<()>,
}

impl Loading {
    /// The stages before the first tick, in order.
    const STAGES: [&str; 4] =
        ["reading the scene", "building the world", "forecasting", "adding up energies"];

    /// Begins with the first stage.
    pub fn begin() -> Self {
        let style =
            ProgressStyle::with_template("{bar:40} {msg}, {elapsed}").expect("a valid template");
        let bar = ProgressBar::with_draw_target(
            Some(Self::STAGES.len() as u64),
            ProgressDrawTarget::hidden(),
        );
        let bar = bar.with_style(style).with_message(Self::STAGES[0]);
        let (over, waiting) = channel();
        let shown = bar.clone();
        if std::io::stderr().is_terminal() {
            std::thread::spawn(move || {
                if waiting.recv_timeout(Duration::from_secs(1)) == Err(RecvTimeoutError::Timeout) {
                    shown.set_draw_target(ProgressDrawTarget::stderr());
                    shown.enable_steady_tick(Duration::from_millis(200));
                    // Until there is nothing left to show.
                    let _ = waiting.recv();
                    shown.finish_and_clear();
                }
            });
        }
        Self { bar, _over: over }
    }

    /// Says a line on standard error; the bar continues below it.
    pub fn tell(&self, line: &str) {
        self.bar.suspend(|| tell(line));
    }

    /// Begins the next stage.
    pub fn next(&self) {
        self.bar.inc(1);
        let stage = usize::try_from(self.bar.position()).unwrap_or(usize::MAX);
        self.bar.set_message(Self::STAGES.get(stage).copied().unwrap_or_default());
    }
}

impl Drop for Loading {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Words for work whose length is unknown, with the time so far; shown once it takes two seconds.
pub(crate) struct Waiting {
    /// Dropping it ends the words.
    over: Option<Sender<()>>,
    shown: Option<JoinHandle<()>>,
}

impl Waiting {
    /// Begins to wait for `what`.
    pub fn begin(what: &'static str) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self { over: None, shown: None };
        }
        let style =
            ProgressStyle::with_template("{spinner} {msg}, {elapsed}").expect("a valid template");
        let (over, waiting) = channel::<()>();
        let shown = std::thread::spawn(move || {
            if waiting.recv_timeout(Duration::from_secs(2)) == Err(RecvTimeoutError::Timeout) {
                let spinner = ProgressBar::new_spinner()
                    .with_style(style)
                    .with_message(what)
                    .with_elapsed(Duration::from_secs(2));
                spinner.enable_steady_tick(Duration::from_millis(200));
                // Until the work is done.
                let _ = waiting.recv();
                spinner.finish_and_clear();
            }
        });
        Self { over: Some(over), shown: Some(shown) }
    }
}

impl Drop for Waiting {
    fn drop(&mut self) {
        drop(self.over.take());
        if let Some(shown) = self.shown.take() {
            let _ = shown.join();
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "some thousand steps"
)]
fn steps(studies: usize, part: f64) -> u64 {
    ((studies as f64 + part) * STEPS) as u64
}

/// A bar over the runs of a sweep.
pub(crate) fn runs_bar(runs: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs, {eta} left")
        .expect("a valid template");
    let bar = ProgressBar::new(runs).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}

/// A bar over the ticks of a run.
pub(crate) fn progress_bar(ticks: Option<u64>) -> ProgressBar {
    let bar = ticks.map_or_else(ProgressBar::new_spinner, ProgressBar::new);
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} ticks, {eta} left")
        .expect("a valid template");
    let bar = bar.with_style(style);
    // A tick may take a minute.
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}
