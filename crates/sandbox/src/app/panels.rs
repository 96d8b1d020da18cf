//! What the panels show, taken from the session once a frame, and what a person changes in them.

use bevy_ecs::prelude::*;
use egui::{Align2, LayerId, Order};
use glam::DVec3;
use lab::Row;
use motion::clock::StepClock;
use motion::effects::Effect;
use motion::{Damping, ForceCause, Gravity, Method, PhysicsBody, Request, TimeStep, Transform};

use crate::app::control::Mode;
use crate::app::session::{
    ForecastRow, GhostLabel, GhostRow, Label, Measured, QuarantinedBody, Session, SoftSum, Within,
};
use crate::app::ui::{Panel, Ui};
use crate::input::Experiment;

use crate::tools::{cost, effects, finder, forecast, ghosts, help, ledger, settings, timeline};
use crate::view::{card, hud, marks};

pub(crate) use cost::panel::Axes;
pub(crate) use finder::Finder;

/// A change that a panel asks for.
#[derive(Clone, Debug)]
pub(crate) enum Edit {
    Ask(Request),
    Try(Experiment),
    Switch(Effect, bool),
    MeasureEffects,
    MeasureCost,
    ApplySetting(lab::cost::Setting),
    /// Draws the ghost of a method, or of the reference, or leaves it out.
    ShowGhost(Option<Method>, bool),
    StepHz(f64),
    /// Goes to the end of that tick.
    Seek(u64),
    SaveBundle,
    Open(String),
}

/// A copy of what the panels show.
pub(crate) struct Model {
    pub mode: Mode,
    pub gravity: Option<Gravity>,
    pub damping: Option<Damping>,
    pub step_hz: f64,
    pub scene: String,
    pub method: Method,
    /// Whether bodies have methods of their own.
    pub own_methods: bool,
    pub click_force: f64,
    pub pushes: bool,
    pub locked: bool,
    pub paused: bool,
    pub pace: f64,
    /// Time since the scene began, s.
    pub scene_s: f64,
    pub bodies: usize,
    pub drops_time: bool,
    /// Bodies that leave a trail and all that could, where these are more.
    pub trails_left_out: Option<(usize, usize)>,
    pub measured: Option<Measured>,
    /// How many bodies are frozen, and the first of them.
    pub quarantined: (usize, Vec<QuarantinedBody>),
    pub notices: Vec<String>,
    pub selection: Option<Selected>,
    /// Newtons of a force arrow of one meter, while these are drawn.
    pub newtons_per_meter: Option<f64>,
    pub labels: Vec<Label>,
    /// The body that went wrong, while the run stands next to that.
    pub mark: Option<Label>,
    /// The receipt, while its panel is open.
    pub effects: Vec<Row>,
    /// The study of the scene, while its panel is open.
    pub cost: Option<cost::panel::View>,
    /// What there is to say of each ghost, while its panel is open.
    pub ghosts: Vec<GhostRow>,
    /// Whose distances they are.
    pub ghost_subject: String,
    pub ghost_labels: Vec<GhostLabel>,
    /// The books, while their panel is open.
    pub ledger: Option<ledger::panel::View>,
    /// How far everything is from instability, while that panel is open.
    pub forecast: Option<Vec<ForecastRow>>,
    /// Where in the last minute it is, while that panel is open.
    pub within: Option<Within>,
}

/// So many quarantined bodies are listed.
const FROZEN: usize = 6;

/// So many springs of one body are listed each by itself.
const SPRINGS: usize = 3;

/// The selected thing in the tutorial's terms.
pub(crate) struct Selected {
    pub entity: Entity,
    pub name: String,
    pub position: DVec3,
    pub displacement: DVec3,
    /// At the time of the position; absent for scenery.
    pub body: Option<PhysicsBody>,
    /// The forces on it, N, by cause; springs together if there are many. Of a soft body, none.
    pub forces: Vec<(String, DVec3)>,
    /// The method that it asks for, whatever the scene's is.
    pub own_method: Option<Method>,
    /// Why and when it was frozen, if it was.
    pub quarantined: Option<String>,
    /// What is summed up over the points, of a soft body.
    pub soft: Option<SoftSum>,
}

impl Model {
    pub fn of(session: &mut Session, notices: Vec<String>) -> Self {
        let effects = if session.ui.shows(Panel::Effects) { session.receipt() } else { Vec::new() };
        let ghosts = if session.ui.shows(Panel::Ghosts) { session.ghosts() } else { Vec::new() };
        let gravity = session.sim.world.get_resource::<Gravity>().copied();
        let frozen = session.frozen();
        Self {
            mode: session.control.mode,
            gravity,
            damping: session.sim.world.get_resource::<Damping>().copied(),
            step_hz: 1.0 / session.sim.world.resource::<TimeStep>().0,
            scene: session.sim.scene.name.clone(),
            method: session.sim.method(),
            own_methods: !session.sim.stepper.plan().own.is_empty(),
            click_force: session.control.click_force,
            pushes: session.sim.scene.push.is_some(),
            locked: session.control.locked.is_some(),
            paused: session.control.paused,
            pace: session.clock.pace(),
            scene_s: session.sim.world.resource::<StepClock>().scene_seconds(),
            bodies: session.sim.bodies.len(),
            drops_time: session.drops_time(),
            trails_left_out: session.trails.left_out().filter(|_| session.control.trails),
            measured: session.measured,
            quarantined: (frozen.len(), frozen.iter().take(FROZEN).cloned().collect()),
            notices,
            effects,
            cost: if session.ui.shows(Panel::Cost) { cost::panel::View::of(session) } else { None },
            ghosts,
            ghost_subject: session.ghost_subject(),
            ghost_labels: session.ghost_labels(),
            ledger: session.ui.shows(Panel::Ledger).then(|| ledger::panel::View::of(session)).flatten(),
            forecast: session.shown_forecast().map(<[_]>::to_vec),
            within: if session.ui.shows(Panel::Timeline) { session.within() } else { None },
            labels: session.visible_labels(),
            mark: session.fault_mark(),
            selection: session.control.selection.and_then(|thing| Selected::of(session, thing)),
            newtons_per_meter: session.force_scale,
        }
    }
}

impl Selected {
    pub(crate) fn of(session: &mut Session, entity: Entity) -> Option<Self> {
        match session.soft_sum(entity) {
            Some(soft) => Some(Self::of_points(session, entity, soft)),
            None => Self::of_thing(session, entity),
        }
    }

    /// A soft body as its center of mass.
    fn of_points(session: &mut Session, entity: Entity, mut soft: SoftSum) -> Self {
        soft.body = session.synchronized_points(entity, soft.body);
        Self {
            entity,
            name: session.name(entity),
            position: soft.position,
            displacement: soft.displacement,
            body: Some(soft.body),
            forces: Vec::new(),
            own_method: None,
            quarantined: None,
            soft: Some(soft),
        }
    }

    fn of_thing(session: &mut Session, entity: Entity) -> Option<Self> {
        let position = session.sim.world.get::<Transform>(entity)?.position;
        let start =
            session.ids.get(&entity).map_or(position, |id| session.sim.scene.bodies[*id as usize].position);
        let forces = session.forces_on(entity);
        Some(Self {
            entity,
            name: session.name(entity),
            position,
            displacement: position - start,
            body: session.synchronized(entity, &forces),
            forces: Self::named(session, &forces),
            own_method: session.sim.world.get_entity(entity).ok().and_then(motion::own_method),
            quarantined: session.frozen_because(entity),
            soft: None,
        })
    }

    /// The forces under their names: a few springs each by its other end, many as one sum.
    fn named(session: &Session, forces: &[(ForceCause, DVec3)]) -> Vec<(String, DVec3)> {
        let springs = forces.iter().filter(|(cause, _)| matches!(cause, ForceCause::Spring(_))).count();
        let mut named: Vec<(String, DVec3)> = Vec::new();
        for (cause, newtons) in forces {
            let name = match cause {
                ForceCause::Spring(other) if springs <= SPRINGS => {
                    format!("by spring to {}", session.name(*other))
                }
                ForceCause::Spring(_) => format!("by {springs} springs"),
                cause => format!("by {}", cause.name().replace('_', " ")),
            };
            match named.iter_mut().find(|(known, _)| *known == name) {
                Some((_, sum)) => *sum += *newtons,
                None => named.push((name, *newtons)),
            }
        }
        named
    }
}

/// Lays everything out.
pub(crate) fn show(context: &egui::Context, ui: &mut Ui, model: &Model) -> Vec<Edit> {
    let mut edits = Vec::new();
    let painter = context.layer_painter(LayerId::new(Order::Background, egui::Id::unique("hud")));
    let mut taken = marks::show(&painter, &model.labels);
    taken.extend(model.mark.as_ref().map(|mark| marks::show_mark(&painter, mark)));
    let panel = if ui.shows(Panel::Ghosts) { ghosts::panel::show(context, model, &mut edits) } else { None };
    ghosts::panel::show_labels(&painter, &model.ghost_labels, taken, panel);
    hud::show(&painter, model);
    if let Some(selected) = &model.selection {
        card::show(context, selected, model.method);
    }
    if ui.shows(Panel::Help) {
        help::show(context);
    }
    if ui.shows(Panel::Settings) {
        settings::show(context, model, &mut edits);
    }
    if ui.shows(Panel::Effects) {
        effects::panel::show(context, model, &mut edits);
    }
    if ui.shows(Panel::Cost) {
        cost::panel::show(context, model, model.cost.as_ref(), &mut ui.axes, &mut edits);
    }
    if let Some(view) = &model.ledger {
        let any = |panels: [Panel; 2]| panels.into_iter().any(|panel| ui.shows(panel));
        let place = match (any([Panel::Effects, Panel::Cost]), any([Panel::Settings, Panel::Ghosts])) {
            (false, _) => Align2::RIGHT_CENTER,
            (true, false) => Align2::LEFT_CENTER,
            (true, true) => Align2::CENTER_BOTTOM,
        };
        ledger::panel::show(context, model, view, place);
    }
    if let Some(rows) = &model.forecast {
        forecast::panel::show(context, rows);
    }
    if ui.shows(Panel::Timeline) {
        timeline::panel::show(context, model, &mut edits);
    }
    if ui.shows(Panel::Finder) && !ui.finder.show(context, &mut edits) {
        ui.close(Panel::Finder);
    }
    edits
}

#[cfg(test)]
mod tests {
    use motion::SoftBody;
    use motion::clock::FrameClock;
    use scene::Scene;

    use super::*;
    use crate::app::session::Options;
    use crate::input::{Input, InputFrame};

    #[test]
    fn the_clock_shown_is_the_scenes() {
        let scene = Scene::parse("empty", "(version: 1)").expect("a good scene");
        let mut session = Session::new(scene.clone(), Options::default());
        let mut clock = FrameClock::default();
        let mut shown = |session: &mut Session| {
            session.advance(&InputFrame::NOTHING, clock.advance_by(0.1).expect("a time"));
            Model::of(session, Vec::new()).scene_s
        };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} s is not {b} s");
        close(shown(&mut session), 0.1);
        close(shown(&mut session), 0.2);
        session.reset_world();
        close(shown(&mut session), 0.1);
        session.open(scene);
        close(shown(&mut session), 0.1);
        close(session.simulated(), 0.4);
    }

    #[test]
    fn a_change_of_the_method_while_time_stands_still_changes_no_velocity_on_the_card() {
        for name in ["orbit", "oscillator", "cape", "jelly", "everything"] {
            let mut scene = scene::load(name).expect("it is shipped");
            // Mutual gravity is not for every method.
            scene.method = Method::PositionVerlet;
            let options = Options { pictures: false, ..Options::default() };
            // A few ticks: the cape does not live long under position Verlet.
            let seconds = 2.0 / scene.step_hz;
            let (mut session, mut clock) = (Session::new(scene, options), FrameClock::default());
            session.advance(&InputFrame::NOTHING, clock.advance_by(seconds).expect("a time"));
            let velocities = |session: &mut Session| {
                let of = |session: &mut Session, thing| Selected::of(session, thing)?.body;
                let mut softs = session.sim.world.query_filtered::<Entity, With<SoftBody>>();
                let softs: Vec<_> = softs.iter(&session.sim.world).collect();
                let bodies = session.sim.bodies.clone();
                bodies
                    .into_iter()
                    .chain(softs)
                    .map(|body| of(session, body).map(|body| body.velocity))
                    .collect::<Vec<_>>()
            };
            let stored = |session: &Session, body| {
                session.sim.world.get::<PhysicsBody>(body).map(|body| body.velocity)
            };
            let lagged: Vec<_> = session.sim.bodies.iter().map(|body| stored(&session, *body)).collect();
            let before = velocities(&mut session);
            session.set_method(Method::VelocityVerlet);
            let after = velocities(&mut session);
            let most = |a: &[Option<DVec3>], b: &[Option<DVec3>]| {
                let apart = a.iter().zip(b).filter_map(|(a, b)| Some(a.as_ref()?.distance(*b.as_ref()?)));
                apart.fold(0.0, f64::max)
            };
            let (changed, lag) = (most(&before, &after), most(&lagged, &after));
            assert!(changed < 1e-9 * lag && lag > 1e-3, "{name}: {changed} m/s of {lag} m/s");
        }
    }

    #[test]
    fn a_card_that_gets_wider_stays_in_the_picture_in_the_same_frame() {
        let text =
            "(version: 1, bodies: [(name: \"ball\", shape: sphere(radius_m: 1), position_m: (0, 0, -9))])";
        let mut session = Session::new(Scene::parse("card", text).expect("a good scene"), Options::default());
        session.control.selection = session.body("ball");
        let mut clock = FrameClock::default();
        let mut right = |session: &mut Session, x: f64| {
            let put = Experiment::OfBody("ball".to_owned(), Request::SetPosition, [x; 3]);
            let input = [Input::Experiment(put)].into_iter().collect();
            let frame = session.frame(&input, clock.advance_by(0.1).expect("a time"));
            let of_mesh = |primitive: &egui::ClippedPrimitive| match &primitive.primitive {
                egui::epaint::Primitive::Mesh(mesh) => {
                    mesh.vertices.iter().map(|vertex| vertex.pos.x).fold(0.0, f32::max)
                }
                egui::epaint::Primitive::Callback(_) => 0.0,
            };
            frame.panels.expect("pictures").primitives.iter().map(of_mesh).fold(0.0, f32::max)
        };
        for x in [1.0, 1.0, 1e5, -1.234_567e-7, -1e5] {
            let edge = right(&mut session, x);
            // With the card's shadow.
            assert!((1272.0..=1290.0).contains(&edge), "at {x} m the card ends at {edge}");
        }
    }
}
