//! The list of notices, each shown for a few seconds, and the record of a quarantined body.

/// How long a notice stays, s.
const NOTICE_S: f64 = 4.0;

/// Notices without a topic of their own that are shown at once.
const MOST_OTHERS: usize = 3;

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
pub(crate) struct Notices(Vec<Notice>);

impl Notices {
    /// Says something for a few seconds, in place of what was said of its topic before.
    pub fn say(&mut self, topic: Topic, text: String) {
        if topic == Topic::Other {
            self.0.retain(|notice| notice.text != text);
            let others = self.0.iter().filter(|notice| notice.topic == topic).count();
            if others >= MOST_OTHERS
                && let Some(oldest) = self.0.iter().position(|notice| notice.topic == topic)
            {
                self.0.remove(oldest);
            }
        } else {
            self.retract(topic);
        }
        self.0.push(Notice { topic, text, until: None });
    }

    /// Takes back what is no longer true.
    pub fn retract(&mut self, topic: Topic) {
        self.0.retain(|notice| notice.topic != topic);
    }

    /// Takes back what was said of a run that has come to its end.
    pub fn retract_run(&mut self) {
        self.0.retain(|notice| notice.topic == Topic::File);
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Drops those that have been seen long enough at `now`, s.
    pub fn expire(&mut self, now: f64) {
        self.0.retain_mut(|notice| now <= *notice.until.get_or_insert(now + NOTICE_S));
    }

    /// When the next one goes, s; one that has not been seen yet goes `now`.
    pub fn next_end(&self, now: f64) -> f64 {
        self.0.iter().map(|notice| notice.until.unwrap_or(now)).fold(f64::INFINITY, f64::min)
    }

    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|notice| notice.text.as_str())
    }
}
