//! The list of notices, each shown for a few seconds, and the record of a quarantined body.

/// How long a notice stays, s.
const NOTICE_S: f64 = 4.0;

/// Notices without a topic of their own that are shown at once.
const MOST_OTHERS: usize = 3;

/// Refusals that wait to be told.
const MOST_REFUSALS: usize = 16;

/// A body that was quarantined, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct QuarantinedBody {
    /// Name in the scene.
    pub body: String,
    /// The tick that it did not survive.
    pub tick: u64,
    /// What happened, as a sentence.
    pub what: String,
    /// The system that noticed.
    pub system: &'static str,
    /// The component or resource at fault.
    pub component: &'static str,
    /// What had happened to it: a word, with the name of the law or of the body at the other end of the spring.
    pub cause: String,
}

/// What a notice is about. Of each topic but the last there is one notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Topic {
    /// A file that was written or opened: true whatever is simulated.
    File,
    Fault,
    Forecast,
    /// What the editor could not do.
    Editor,
    Gravity,
    Ghosts,
    Method,
    /// Where in the last minute the run stands.
    Place,
    /// The size of the panels.
    Size,
    Speed,
    Unconverged,
    Other,
}

/// Words in the picture.
struct Notice {
    topic: Topic,
    text: String,
    /// When it goes, s; known once it is seen.
    until: Option<f64>,
}

/// The notices of a session, oldest first.
#[derive(Default)]
pub struct Notices {
    shown: Vec<Notice>,
    /// Texts of refusals that no one has read yet.
    refusals: Vec<String>,
}

impl Notices {
    /// Says something for a few seconds, in place of what was said of its topic before.
    pub(crate) fn say(&mut self, topic: Topic, text: impl Into<String>) {
        let text = text.into();
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

    /// Says to the person, and to a run that no person looks at, that something was not done.
    pub(crate) fn refuse(&mut self, topic: Topic, what: impl Into<String>) {
        let what = what.into();
        if self.refusals.len() < MOST_REFUSALS {
            self.refusals.push(what.clone());
        }
        self.say(topic, what);
    }

    /// Takes the recent refusals: what was requested and not done.
    pub fn take_refusals(&mut self) -> Vec<String> {
        std::mem::take(&mut self.refusals)
    }

    /// Takes back what is no longer true.
    pub(crate) fn retract(&mut self, topic: Topic) {
        self.shown.retain(|notice| notice.topic != topic);
    }

    /// Takes back what was said of a run that has come to its end.
    pub(crate) fn retract_run(&mut self) {
        self.shown.retain(|notice| notice.topic == Topic::File);
    }

    pub(crate) fn clear(&mut self) {
        self.shown.clear();
    }

    /// Drops those that have been seen long enough at `now`, s.
    pub(crate) fn expire(&mut self, now: f64) {
        self.shown.retain_mut(|notice| now <= *notice.until.get_or_insert(now + NOTICE_S));
    }

    /// When the next one goes, s; one that has not been seen yet goes `now`.
    pub(crate) fn next_end(&self, now: f64) -> f64 {
        self.shown.iter().map(|notice| notice.until.unwrap_or(now)).fold(f64::INFINITY, f64::min)
    }

    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.shown.iter().map(|notice| notice.text.as_str())
    }
}
