//! Graphs: how a quantity of the selection goes over the last seconds.

use std::collections::VecDeque;
use std::fmt::Write as _;

use bevy_ecs::entity::Entity;
use egui::{Align2, Color32, ComboBox, Ui};
use glam::DVec3;
use motion::clock::{FrameTime, StepClock};

use crate::tools::curves::{self, Curve};
use crate::tools::tool::{Anchor, Desk, Edit, Tool};
use crate::view::card::Selected;
use crate::view::stage::Stage;

/// How long a sample is kept, s.
const KEPT_S: f64 = 10.0;
/// Samples that are kept at most.
const MOST: usize = 4096;

const HEIGHT: f32 = 160.0;
const WIDTH: f32 = 420.0;
const COLORS: [Color32; 3] =
    [Color32::from_rgb(255, 120, 110), Color32::from_rgb(130, 210, 130), Color32::from_rgb(120, 180, 255)];

/// What is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Quantity {
    #[default]
    Position,
    Velocity,
    Acceleration,
    Force,
    KineticEnergy,
}

impl Quantity {
    const ALL: [Self; 5] =
        [Self::Position, Self::Velocity, Self::Acceleration, Self::Force, Self::KineticEnergy];

    const fn name(self) -> &'static str {
        match self {
            Self::Position => "position, m",
            Self::Velocity => "velocity, m/s",
            Self::Acceleration => "acceleration, m/s²",
            Self::Force => "force, N",
            Self::KineticEnergy => "kinetic energy, J",
        }
    }
}

/// The selection at one time.
struct Sample {
    time: f64,
    /// Position, velocity, acceleration and force; of a soft body, which pins may hold, only the first two are known.
    vectors: [Option<DVec3>; 4],
    kinetic: f64,
}

/// The graphs of the selection, while their panel is open.
#[derive(Default)]
pub(crate) struct Graphs {
    of: Option<Entity>,
    name: String,
    samples: VecDeque<Sample>,
    quantity: Quantity,
}

impl Graphs {
    fn sample(&mut self, stage: &mut Stage, selection: Entity) {
        let Some(Selected { position, body: Some(body), forces, name, soft, .. }) =
            Selected::of(stage, selection)
        else {
            return;
        };
        let force: Option<DVec3> = soft.is_none().then(|| forces.iter().map(|(_, newtons)| *newtons).sum());
        self.name = name;
        self.samples.push_back(Sample {
            time: stage.sim.world.resource::<StepClock>().scene_seconds(),
            vectors: [
                Some(position),
                Some(body.velocity),
                force.map(|force| force * body.inverse_mass),
                force,
            ],
            kinetic: soft.map_or_else(|| body.kinetic_energy(), |soft| soft.kinetic_energy),
        });
    }

    /// Every sample as CSV.
    fn csv(&self) -> String {
        let mut text = "time_s".to_owned();
        for (what, unit) in [("position", "m"), ("velocity", "m_s"), ("acceleration", "m_s2"), ("force", "n")]
        {
            ["x", "y", "z"].iter().for_each(|axis| text += &format!(",{what}_{axis}_{unit}"));
        }
        text += ",kinetic_energy_j\n";
        for Sample { time, vectors, kinetic } in &self.samples {
            text += &time.to_string();
            for vector in vectors {
                match vector {
                    Some(DVec3 { x, y, z }) => write!(text, ",{x},{y},{z}"),
                    None => write!(text, ",,,"),
                }
                .expect("a string takes what is written");
            }
            text += &format!(",{kinetic}\n");
        }
        text
    }
}

impl Tool for Graphs {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::RIGHT_TOP, [-8.0, 100.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        ui.set_width(desk.width(WIDTH));
        ui.horizontal(|ui| {
            let list = ComboBox::from_id_salt("quantity").selected_text(self.quantity.name());
            list.show_ui(ui, |ui| {
                for quantity in Quantity::ALL {
                    ui.selectable_value(&mut self.quantity, quantity, quantity.name());
                }
            });
            let save = ui.add_enabled(!self.samples.is_empty(), egui::Button::new("Save CSV"));
            if save.on_hover_text("every quantity of the graph's seconds as a table").clicked() {
                desk.edits.push(Edit::SaveTable(self.csv()));
            }
        });
        if self.of.is_none() {
            ui.weak("Select a body to see how it moves.");
            return;
        }
        ui.label(&self.name);
        let over_time = |of: &dyn Fn(&Sample) -> Option<f64>| {
            let points = self.samples.iter().filter_map(|sample| Some([sample.time, of(sample)?]));
            points.collect::<Vec<_>>()
        };
        let curves: Vec<_> = match self.quantity {
            Quantity::KineticEnergy => {
                vec![Curve {
                    name: "kinetic",
                    color: COLORS[1],
                    points: over_time(&|sample| Some(sample.kinetic)),
                }]
            }
            quantity => (0..3)
                .map(|axis| Curve {
                    name: ["x", "y", "z"][axis],
                    color: COLORS[axis],
                    points: over_time(&|sample| Some(sample.vectors[quantity as usize]?[axis])),
                })
                .collect(),
        };
        if curves.iter().all(|curve| curve.points.is_empty()) {
            ui.weak("Not computed for a soft body: pins hold it with forces that only its springs know.");
        } else {
            curves::show(ui, "graph", HEIGHT, &curves);
        }
    }

    /// Samples the selection after the ticks of a frame.
    fn after_ticks(&mut self, stage: &mut Stage, open: bool, _: FrameTime) {
        let selection = stage.seen.selection.filter(|_| open);
        if self.of != selection {
            self.samples.clear();
            self.of = selection;
        }
        let Some(selection) = selection else { return };
        let now = stage.sim.world.resource::<StepClock>().scene_seconds();
        // After going back, what came later has not happened.
        while self.samples.back().is_some_and(|sample| sample.time > now) {
            self.samples.pop_back();
        }
        if self.samples.back().is_none_or(|sample| sample.time < now) {
            self.sample(stage, selection);
        }
        while self.samples.len() > MOST
            || self.samples.front().is_some_and(|sample| sample.time < now - KEPT_S)
        {
            self.samples.pop_front();
        }
    }
}
