//! The list of notices, each shown for a few seconds.

/// Display time of a notice, s.
const NOTICE_S: f64 = 4.0;

/// Maximum number of notices with `Topic::Other` at a time.
const MOST_OTHERS: usize = 3;

/// Maximum number of unread refusals.
const MOST_REFUSALS: usize = 16;

/// The topic of a notice. Each topic except `Other` has at most one notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// A file that was written or opened; stays true when the run ends.
    File,
    /// A file that was not written or opened: with bars, told until it is closed.
    FileError,
    /// A fault of the run.
    Fault,
    /// What the forecast found.
    Forecast,
    /// A failure of the editor.
    Editor,
    /// Gravity on or off.
    Gravity,
    /// Ghosts begin or end.
    Ghosts,
    /// The method, or that it cannot solve a law.
    Method,
    /// The position of the run in the last minute.
    Place,
    /// The size of the panels.
    Size,
    /// The pace of the run.
    Speed,
    /// Steps that did not converge, or whose error is too large.
    Unconverged,
    /// Anything else.
    Other,
}

/// A message in the picture.
struct Notice {
    topic: Topic,
    text: String,
    /// When the notice disappears, s; set once it is seen.
    until: Option<f64>,
}

/// The notices of a session, oldest first.
#[derive(Default)]
pub struct Notices {
    shown: Vec<Notice>,
    /// Texts of unread refusals.
    refusals: Vec<String>,
}

impl Notices {
    /// Shows a notice for a few seconds; replaces the notice of the same topic, if any.
    pub fn say(&mut self, topic: Topic, text: impl Into<String>) {
        let text = text.into();
        if topic == Topic::File {
            self.retract(Topic::FileError);
        }
        if topic == Topic::Other {
            self.shown.retain(|notice| notice.text != text);
            let others = self.shown.iter().filter(|notice| notice.topic == topic).count();
            if others >= MOST_OTHERS
                && let Some(oldest) = self.shown.iter().position(|notice| notice.topic == topic)
            {
                self.shown.remove(oldest);
            }
        } else {
            self.retract(topic);
        }
        self.shown.push(Notice { topic, text, until: None });
    }

    /// Reports a request that was not carried out, as a notice and as a refusal for runs without a window.
    pub(crate) fn refuse(&mut self, topic: Topic, what: impl Into<String>) {
        let what = what.into();
        if self.refusals.len() < MOST_REFUSALS {
            self.refusals.push(what.clone());
        }
        self.say(topic, what);
    }

    /// Takes the unread refusals: requests that were not carried out.
    pub fn take_refusals(&mut self) -> Vec<String> {
        std::mem::take(&mut self.refusals)
    }

    /// Removes the notices of a topic that are no longer true.
    pub(crate) fn retract(&mut self, topic: Topic) {
        self.shown.retain(|notice| notice.topic != topic);
    }

    /// Removes the notices about a run that has ended.
    pub(crate) fn retract_run(&mut self) {
        self.shown.retain(|notice| matches!(notice.topic, Topic::File | Topic::FileError));
    }

    pub(crate) fn clear(&mut self) {
        self.shown.clear();
    }

    /// Drops the notices whose display time is over at `now`, s. That of a new one begins now.
    pub(crate) fn expire(&mut self, now: f64, has_bars: bool) {
        self.shown.retain_mut(|notice| {
            let stays = has_bars && notice.topic == Topic::FileError;
            let length = if stays { f64::INFINITY } else { NOTICE_S };
            now <= *notice.until.get_or_insert(now + length)
        });
    }

    /// What is told of a file until it is closed.
    pub(crate) fn file_error(&self) -> Option<&str> {
        self.shown.iter().find(|notice| notice.topic == Topic::FileError).map(|it| &*it.text)
    }

    /// When the next notice disappears, s; `now` if one has not been seen yet, infinity if there are no notices.
    pub(crate) fn next_end(&self, now: f64) -> f64 {
        self.shown.iter().map(|notice| notice.until.unwrap_or(now)).fold(f64::INFINITY, f64::min)
    }

    /// The texts that are shown in the picture. With bars, one of them tells of faults; while it does, what was forecast
    /// is not told again.
    pub(crate) fn in_picture(&self, has_bars: bool) -> impl Iterator<Item = &str> {
        let is_told = self.shown.iter().any(|it| it.topic == Topic::Fault);
        let in_bar = move |topic| {
            matches!(topic, Topic::Fault | Topic::FileError)
                || (is_told && topic == Topic::Forecast)
        };
        let shown = self.shown.iter().filter(move |it| !has_bars || !in_bar(it.topic));
        shown.map(|notice| notice.text.as_str())
    }

    /// The texts that are shown.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.shown.iter().map(|notice| notice.text.as_str())
    }
}
