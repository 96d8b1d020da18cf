//! The subject of a study: a problem, or a scene from its start.

use history::Simulation;
use motion::effects::Effect;
use motion::margin::{Margin, Margins};
use motion::{Law, Laws, Method};
use scene::{Scene, SceneError, Substepping, unsolvable};

use super::arithmetic::MakeLoop;
use super::problem::{Exact, Problem};
use super::record::Setting;
use crate::run::movable;
use crate::trial::{Ahead, Trial};

/// Most ticks of a run of a scene; the rest is left out.
const MOST_TICKS: f64 = 1e15;

/// A run of fewer ticks is not shortened.
const LEAST_TICKS: u64 = 16;

/// Default length of the run of a scene, s.
const SECONDS: f64 = 10.0;

/// Least number of ticks of that run: a scene whose motion takes hours has ticks as long.
const TICKS: f64 = 600.0;

/// A problem or a scene, and the length of its run.
#[derive(Clone, Debug)]
pub struct Subject {
    pub(crate) scene: Scene,
    /// The problem, if the subject is one.
    pub(crate) problem: Option<Problem>,
    pub(crate) ticks: u64,
    /// Whether the run may be shortened, because its length is the default.
    pub(crate) may_be_shortened: bool,
    pub(crate) notes: Vec<String>,
}

impl Subject {
    /// The start of a run in a world.
    pub(crate) fn run(&self, setting: Setting) -> Simulation {
        let mut run = Simulation::new(self.scene_with(setting));
        let laws = self.laws();
        if !laws.is_empty() {
            run.world.insert_resource(Laws(laws));
            run.stepper.recompile(&mut run.world);
        }
        run
    }

    /// The laws that no scene file can declare.
    fn laws(&self) -> Vec<Box<dyn Law>> {
        let law = self.problem.and_then(|problem| problem.law);
        law.map(|law| Box::new(law) as Box<dyn Law>).into_iter().collect()
    }

    /// The subject of a problem.
    ///
    /// # Errors
    /// If its bodies take more memory than is allowed.
    pub fn of_problem(problem: &Problem) -> Result<Self, SceneError> {
        Self::of_text(*problem, &(problem.scene)(), problem.description.to_owned())
    }

    /// The harmonic oscillator over `periods` whole periods, at least 1.
    ///
    /// # Errors
    /// As [`Self::of_problem`].
    pub fn oscillator(periods: u32) -> Result<Self, SceneError> {
        let problem =
            super::problem::problem("harmonic_oscillator").expect("a problem of the list");
        let text = super::problem::oscillator_scene(periods.max(1));
        let description = format!("A mass on an ideal spring, {periods} periods");
        Self::of_text(Problem { ladder: (1, 8192), ..*problem }, &text, description)
    }

    fn of_text(problem: Problem, text: &str, description: String) -> Result<Self, SceneError> {
        let scene = Scene::parse(problem.name, text)?;
        Ok(Self {
            scene: Scene { description, ..scene },
            problem: Some(problem),
            ticks: problem.ticks,
            may_be_shortened: false,
            notes: Vec::new(),
        })
    }

    /// A scene from its start, for `seconds` rounded up to whole ticks; if `None`, for 10 s and at least 600 ticks, or less
    /// where that takes too long or the motion is chaotic.
    ///
    /// Gravity that is off at the start is switched on, because nothing would move without it; a note says so.
    pub fn of_scene(mut scene: Scene, seconds: Option<f64>) -> Self {
        let mut notes = Vec::new();
        if let Some(gravity) = &mut scene.gravity
            && !gravity.on
        {
            gravity.on = true;
            notes.push(
                "gravity, which waits for the key G in this scene, is on from the start".to_owned(),
            );
        }
        let ticks =
            seconds.map_or((SECONDS * scene.step_hz).max(TICKS), |seconds| seconds * scene.step_hz);
        let ticks = (ticks - 1e-9).ceil().clamp(1.0, MOST_TICKS) as u64;
        Self { scene, problem: None, ticks, may_be_shortened: seconds.is_none(), notes }
    }

    /// Halves the run, if it may be shortened, with a note that says why. Returns whether it did.
    pub(crate) fn halve(&mut self, why: &str) -> bool {
        let halves = self.may_be_shortened && self.ticks >= LEAST_TICKS;
        if halves {
            self.ticks = self.ticks.div_ceil(2);
            self.notes.retain(|note| !note.ends_with(why));
            self.notes.push(format!("the first {:.3} s alone: {why}", self.seconds()));
        }
        halves
    }

    /// Copies of a problem with at least `bodies` movable bodies, whose ticks are as long as one of `substeps`
    /// substeps of a tick of the problem.
    pub fn of_bodies(&self, bodies: u32, substeps: u32) -> Self {
        let each = movable(&self.scene).count();
        self.copies(bodies.div_ceil(u32::try_from(each.max(1)).unwrap_or(u32::MAX)), substeps)
    }

    /// Copies of a problem that do not act on each other, with the ticks of [`Self::of_bodies`].
    pub(crate) fn copies(&self, copies: u32, substeps: u32) -> Self {
        let mut subject = self.clone();
        let scene = &mut subject.scene;
        scene.step_hz *= f64::from(substeps);
        let count = u32::try_from(scene.bodies.len()).unwrap_or(u32::MAX);
        for copy in 1..copies {
            scene.bodies.extend_from_within(..count as usize);
            let laws = self.scene.own_laws.iter();
            let moved = |id: u32| id + copy * count;
            scene
                .own_laws
                .extend(laws.map(|(id, laws)| (moved(*id), laws.renumbered(|id| Some(moved(id))))));
            let motions = self.scene.motions.iter();
            scene.motions.extend(motions.map(|(id, motion)| (moved(*id), motion.clone())));
            let springs = self.scene.springs.iter().cloned();
            scene.springs.extend(springs.map(|mut spring| {
                spring.ends = spring.ends.map(|end| end + copy * count);
                spring
            }));
        }
        subject
    }

    /// The same run in shorter ticks, each a step of `setting`, unless these are chosen.
    pub(crate) fn by_steps(&self, setting: Setting) -> (Self, Setting) {
        let mut subject = self.clone();
        if setting.substeps.fixed().is_none() {
            return (subject, setting);
        }
        subject.scene.step_hz *= f64::from(setting.substeps.least());
        subject.ticks *= u64::from(setting.substeps.least());
        (subject, Setting { substeps: Substepping::Fixed(1), ..setting })
    }

    /// Its name on the command line.
    pub fn name(&self) -> &str {
        &self.scene.name
    }

    /// Its bodies and laws.
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Its closed form, if it has one.
    pub(crate) fn exact(&self) -> Option<Exact> {
        self.problem.and_then(|problem| problem.exact)
    }

    /// The loop over arrays of the same arithmetic, if one was written.
    pub(crate) fn in_loop(&self) -> Option<MakeLoop> {
        self.problem.and_then(|problem| problem.in_loop)
    }

    /// Length of a run, s.
    pub fn seconds(&self) -> f64 {
        self.ticks as f64 / self.scene.step_hz
    }

    /// The scene's own setting.
    pub fn own(&self) -> Setting {
        Setting { method: self.scene.method, substeps: self.scene.substeps }
    }

    fn is_off(&self, effect: Effect) -> bool {
        self.scene.off_at_start.contains(&effect)
    }

    /// Why `method` cannot run it, if it cannot.
    pub fn refusal(&self, method: Method) -> Option<String> {
        let attracts = self.scene.mutual_gravity.is_some() && !self.is_off(Effect::MutualGravity);
        unsolvable(method, attracts).map(|why| why.to_string())
    }

    /// Whether a forecast of the subject with this setting finds a fault.
    pub fn has_fault(&self, setting: Setting) -> bool {
        let run = self.run(setting);
        let margins = Margins::of(&run.world, setting.method);
        if margins.list().iter().any(Margin::is_reported) {
            return true;
        }
        let mut trial = Trial::new(&run, Ahead::DEFAULT);
        trial.finish();
        trial.found().iter().any(|tried| tried.verdict.is_fault())
    }

    /// Its scene with one method and number of substeps for every body.
    pub(crate) fn scene_with(&self, setting: Setting) -> Scene {
        let mut scene = self.scene.clone();
        (scene.method, scene.substeps) = (setting.method, setting.substeps);
        for body in &mut scene.bodies {
            (body.method, body.substeps) = (None, None);
            // Only position Verlet reads this, and it would start from another state than the other methods.
            body.verlet_previous = None;
        }
        scene
    }

    /// The motion that every method approximates: damping per tick is replaced by its law. Also returns whether that
    /// changes the subject.
    pub(crate) fn continuous(&self) -> (Self, bool) {
        let mut truth = self.clone();
        if !self.is_off(Effect::Damping) {
            truth.scene = truth.scene.damped_by_law();
        }
        let model = |scene: &Scene| scene.damping.map(|damping| damping.model);
        let changed = model(&truth.scene) != model(&self.scene);
        (truth, changed)
    }
}
