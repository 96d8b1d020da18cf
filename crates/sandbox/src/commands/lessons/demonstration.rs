//! A lesson that a run shows.

use lab::lesson::{RunLimit, run_lesson};
use scene::lesson::{Goal, Lesson};

use crate::failure::Failure;
use crate::output::progress::Waiting;
use cockpit::app::pupil::{frame_bodies, player};
use cockpit::app::session::Session;

/// Seconds for which a step of a demonstration is read before it is done.
const READ_S: f64 = 3.0;

/// A lesson that is shown in a run: each step is read, then done by its solution.
pub(crate) struct Demonstration {
    lesson: Lesson,
    fps: f64,
    /// The step that is being done, and the frame in which its question is answered.
    step: Option<(usize, u64)>,
}

impl Demonstration {
    /// Shows `lesson` at `fps` frames per second.
    pub fn new(lesson: Lesson, fps: f64) -> Self {
        Self { lesson, fps, step: None }
    }

    /// Begins the lesson in `session`, which has its scene.
    pub fn begin(&self, session: &mut Session) -> Result<(), Failure> {
        let _waiting = Waiting::begin("measuring the runs of the lesson");
        session.begin_lesson(self.lesson.clone(), run_lesson(&self.lesson, 1.0, RunLimit::USUAL)?);
        session.free_pointer();
        frame_bodies(session);
        Ok(())
    }

    /// A message that says how many steps were done, if the lesson in `session` is not finished.
    pub fn left(&self, session: &Session) -> Option<String> {
        let (step, all) = (session.tools.lesson()?.step, self.lesson.steps.len());
        let what = format!(
            "{}: {step} of {all} steps were done; let the run last longer",
            self.lesson.name
        );
        (step < all).then_some(what)
    }

    /// Whether it will do something in `session` by itself: a step that begins paused is read before it is done.
    pub fn waits(&self, session: &Session) -> bool {
        let now = session.stage.playback().frames();
        session.tools.lesson().is_some_and(|state| {
            let is_new = self.step.is_none_or(|(before, due)| before != state.step || due >= now);
            is_new && state.step < self.lesson.steps.len()
        })
    }

    /// Does in `session` what is due in the next frame.
    pub fn before_frame(&mut self, session: &mut Session) -> Result<(), Failure> {
        let Some(state) = session.tools.lesson() else { return Ok(()) };
        let Some(step) = self.lesson.steps.get(state.step) else { return Ok(()) };
        let now = session.stage.playback().frames();
        if self.step.is_none_or(|(before, _)| before != state.step) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a few hundred frames"
            )]
            let due = now + (READ_S * self.fps).ceil() as u64;
            self.step = Some((state.step, due));
            if let Goal::Done { solution, .. } = &step.goal {
                session.play(player(solution, due, self.fps)?.0);
            }
        }
        if let Goal::Number { solution, .. } | Goal::Choice { solution, .. } = &step.goal
            && self.step.is_some_and(|(_, due)| due == now)
        {
            session.tools.lessons().answer(solution);
        }
        Ok(())
    }
}
