//! The panel of the ledger: where energy, momentum and angular momentum go, and what the method invents.

use egui::{Color32, Grid, RichText, TextStyle, Ui};
use egui_plot::{Corner, Legend};
use glam::DVec3;
use motion::ledger::{Ledger, LedgerLines, LedgerTotals};
use motion::{Method, TimeStep};
use report::numbers::{four_digits, scene_time, signed, significant};

use crate::stage::Stage;
use crate::tools::curves;
use crate::tools::ledger::state::{Period, Point, method_of};
use crate::view::inks;

/// Color of the residual, which stands out.
const RESIDUAL: Color32 = Color32::from_rgb(255, 140, 90);
const ENERGY: Color32 = Color32::from_rgb(120, 190, 255);
const KINETIC: Color32 = Color32::from_rgb(130, 210, 130);

/// Sum of rounding errors, relative to the energies.
const ROUNDING: f64 = 1e-12;

/// Width that the sentence and the tables need, points.
pub(super) const WIDTH: f32 = 316.0;
const PLOT_HEIGHT: f32 = 72.0;
/// Width of the curves, points.
const CURVE: f32 = 1.5;

/// Size of the words, points: small, because every cause has five lines.
const TEXT_SIZE: f32 = 11.0;

pub(super) fn show(ui: &mut Ui, stage: &Stage, ledger: &Ledger, past: &[Period], points: &[Point]) {
    for style in [TextStyle::Body, TextStyle::Monospace] {
        if let Some(font) = ui.style_mut().text_styles.get_mut(&style) {
            font.size = TEXT_SIZE;
        }
    }
    let last_second = ledger.last_second();
    let words = RichText::new(sentence(stage, ledger)).strong();
    let color = inks::words(ui.visuals(), RESIDUAL);
    ui.label(if keeps_energy(ledger) { words } else { words.color(color) });
    let particles = stage.sim().scene.particles_on_device();
    if particles > 0 {
        ui.label(format!(
            "The {particles} particles on the graphics device are not in the ledger."
        ));
    }
    if !past.is_empty() {
        before(ui, past, stage.sim().world.resource::<TimeStep>().0);
        ui.separator();
    }
    energy(ui, ledger, &last_second);
    ui.separator();
    let totals = ledger.since_opening();
    let lines = [&totals.momentum, &last_second.momentum];
    vectors(ui, ["momentum", "N s", "N"], ledger.momentum(), lines);
    ui.separator();
    let lines = [&totals.angular_momentum, &last_second.angular_momentum];
    vectors(ui, ["angular momentum", "N m s", "N m"], ledger.angular_momentum(), lines);
    ui.separator();
    plots(ui, points);
}

/// Lays out what earlier methods did since the scene began.
fn before(ui: &mut Ui, past: &[Period], step: f64) {
    Grid::new("ledger before")
        .num_columns(3)
        .striped(true)
        .min_row_height(0.0)
        .spacing([10.0, 0.0])
        .show(ui, |ui| {
            heading(ui, ["before", "residual, J", "share"]);
            for Period { method, from, to, residual, share } in past {
                let [from, to] = [from, to].map(|time| scene_time(*time, step));
                let times = format!("{method}, {} to {to}", from.trim_end_matches(" s"));
                row(ui, &times, [signed(*residual), percent(*share)]);
            }
        });
}

/// A share in percent; below rounding it is 0.
fn percent(share: f64) -> String {
    match share {
        share if share.is_nan() || share < ROUNDING => "0 %".to_owned(),
        share => format!("{} %", significant(100.0 * share, 2, 1e-3..1e6)),
    }
}

/// Whether the residual is rounding, or nothing was simulated.
fn keeps_energy(ledger: &Ledger) -> bool {
    let residual = ledger.since_opening().energy.residual;
    ledger.seconds() <= 0.0 || residual == 0.0 || ledger.relative_residual() < ROUNDING
}

/// The sentence on what the method has done to energy.
fn sentence(stage: &Stage, ledger: &Ledger) -> String {
    let (stepper, method) = (&stage.sim().stepper, method_of(stage));
    let (residual, seconds) = (ledger.since_opening().energy.residual, ledger.seconds());
    let time = scene_time(seconds, stage.sim().world.resource::<TimeStep>().0);
    if seconds <= 0.0 {
        return format!("{method}: nothing simulated yet");
    }
    if keeps_energy(ledger) {
        return format!("{method} conserved energy to rounding over {time}.");
    }
    let share = ledger.relative_residual();
    let rate = signed(ledger.last_second().energy.residual);
    let plan = stepper.plan();
    let methods = [stepper.method()].into_iter().chain(plan.own.iter().copied());
    if methods
        .chain(plan.groups.iter().copied().flatten())
        .any(|method| method == Method::PositionVerlet)
    {
        // With such velocities, even an exact method would show a residual: it is neither gain nor loss.
        let residual = signed(residual);
        return format!(
            "{method}: residual {residual} J after {time}, {rate} J/s in the last second. Velocities of position Verlet \
             are half a step late, and kinetic energy and momentum with them."
        );
    }
    let verb = if residual > 0.0 { "invented" } else { "lost" };
    let (size, share) = (four_digits(residual.abs()), percent(share));
    let at_start = ledger.energies_at_opening().total().abs();
    let of = match ledger.peak_kinetic() <= at_start {
        true => "the energy at its start",
        false => "the largest kinetic energy",
    };
    format!("{method} {verb} {size} J in {time}, {share} of {of}; {rate} J/s in the last second")
}

fn energy(ui: &mut Ui, ledger: &Ledger, last_second: &LedgerTotals) {
    Grid::new("ledger energy")
        .num_columns(4)
        .striped(true)
        .min_row_height(0.0)
        .spacing([10.0, 0.0])
        .show(ui, |ui| {
            heading(ui, ["energy", "now, J", "since open, J", "last second, W"]);
            let (now, then) = (ledger.energies(), ledger.energies_at_opening());
            held(ui, "kinetic", now.kinetic, then.kinetic);
            for (law, now) in &now.potential {
                let before = then
                    .potential
                    .iter()
                    .find(|(name, _)| name == law)
                    .map_or(0.0, |(_, energy)| *energy);
                held(ui, &law.replace('_', " "), *now, before);
            }
            let (sums, rates) = (&ledger.since_opening().energy, &last_second.energy);
            for (name, sum, rate) in lines(sums, rates) {
                row(ui, &name, ["".to_owned(), signed(sum), signed(rate)]);
            }
            let cells = [
                "residual".to_owned(),
                String::new(),
                signed(sums.residual),
                signed(rates.residual),
            ];
            emphasised(ui, cells);
        });
}

/// Lays out a vector quantity, with the units of its sums and rates.
fn vectors(
    ui: &mut Ui,
    [quantity, unit, rate_unit]: [&str; 3],
    now: DVec3,
    [sums, rates]: [&LedgerLines<DVec3>; 2],
) {
    let lines = lines(sums, rates);
    Grid::new(("ledger", quantity))
        .num_columns(2)
        .striped(true)
        .min_row_height(0.0)
        .spacing([10.0, 0.0])
        .show(ui, |ui| {
            ui.weak(quantity);
            ui.label(RichText::new(["x", "y", "z"].map(column).concat()).monospace().weak());
            ui.end_row();
            row(ui, &format!("now, {unit}"), [triple(now)]);
            heading(ui, ["since open"]);
            for (name, sum, _) in &lines {
                row(ui, name, [triple(*sum)]);
            }
            emphasised(ui, ["residual".to_owned(), triple(sums.residual)]);
            heading(ui, [&format!("last second, {rate_unit}")]);
            for (name, _, rate) in &lines {
                row(ui, name, [triple(*rate)]);
            }
            emphasised(ui, ["residual".to_owned(), triple(rates.residual)]);
        });
}

/// The lines of pushes, of laws, and of other causes whose sum is not 0: name, sum and rate.
fn lines<T: Copy + Default + PartialEq>(
    sums: &LedgerLines<T>,
    rates: &LedgerLines<T>,
) -> Vec<(String, T, T)> {
    let laws = sums
        .laws
        .iter()
        .zip(&rates.laws)
        .map(|((name, sum), (_, rate))| (name.replace('_', " "), *sum, *rate));
    let others = [
        ("damping", sums.damping, rates.damping),
        ("limits", sums.limits, rates.limits),
        ("anchors", sums.anchors, rates.anchors),
        ("interventions", sums.interventions, rates.interventions),
    ];
    let others = others.into_iter().filter(|(_, sum, _)| *sum != T::default());
    std::iter::once(("pushes".to_owned(), sums.pushes, rates.pushes))
        .chain(laws)
        .chain(others.map(|(name, sum, rate)| (name.to_owned(), sum, rate)))
        .collect()
}

fn heading<const N: usize>(ui: &mut Ui, words: [&str; N]) {
    for word in words {
        ui.weak(word);
    }
    ui.end_row();
}

fn held(ui: &mut Ui, name: &str, now: f64, then: f64) {
    row(ui, name, [four_digits(now), signed(now - then), String::new()]);
}

fn row<const N: usize>(ui: &mut Ui, name: &str, cells: [String; N]) {
    ui.label(name);
    for cell in cells {
        ui.monospace(cell);
    }
    ui.end_row();
}

fn emphasised<const N: usize>(ui: &mut Ui, cells: [String; N]) {
    let color = inks::words(ui.visuals(), RESIDUAL);
    for cell in cells {
        ui.label(RichText::new(cell).monospace().color(color).strong());
    }
    ui.end_row();
}

/// A curve of the ledger.
type Curve = fn(&Point) -> f64;

fn plots(ui: &mut Ui, points: &[Point]) {
    let curve = |(name, color, of): (&'static str, Color32, Curve)| {
        let points = points.iter().map(|point| [point.time, of(point)]);
        curves::Curve { name: name.to_owned(), color, width: CURVE, points: points.collect() }
    };
    let energies: [(&str, Color32, Curve); 2] = [
        ("energy, J", ENERGY, |point| point.energy),
        ("kinetic, J", KINETIC, |point| point.kinetic),
    ];
    // At the left: the newest end of the curves is at the right.
    let legend = || Some(Legend::default().position(Corner::LeftTop));
    curves::show(ui, "ledger energies", PLOT_HEIGHT, legend(), &energies.map(curve));
    curves::show(
        ui,
        "ledger residual",
        PLOT_HEIGHT,
        legend(),
        &[curve(("residual, J", RESIDUAL, |point| point.residual))],
    );
}

/// A column of a vector: as wide as a sign, seven digits and the space before them.
fn column(text: impl std::fmt::Display) -> String {
    format!("{text:>9}")
}

/// Three components in columns, or the magnitude alone if they are too small or too large for columns.
fn triple(v: DVec3) -> String {
    if v == DVec3::ZERO {
        return [0; 3].map(column).concat();
    }
    let largest = v.abs().max_element();
    if (5e-4..1e5).contains(&largest) {
        let decimals = if largest < 1e3 { 3 } else { 1 };
        return v.to_array().map(|part| column(format!("{part:.decimals$}"))).concat();
    }
    format!("magnitude {}", significant(v.length(), 2, 1.0..1e5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::options::Options;

    #[test]
    fn a_velocity_of_half_a_step_ago_is_not_called_lost() {
        let said = |method| {
            let mut scene = scene::load("orbit").expect("a shipped scene");
            scene.method = method;
            let mut stage = Stage::new(scene, Options::default());
            let sim = stage.sim_mut();
            let mut ledger = Ledger::open(&sim.world);
            (0..99).for_each(|_| sim.tick_with(&mut ledger));
            sentence(&stage, &ledger)
        };
        assert!(
            said(Method::ExplicitEuler).starts_with("explicit Euler invented "),
            "{}",
            said(Method::ExplicitEuler)
        );
        assert!(said(Method::ImplicitEuler).starts_with("implicit Euler lost "));
        let late = said(Method::PositionVerlet);
        assert!(
            late.starts_with("position Verlet: residual ") && late.contains(" half a step late"),
            "{late}"
        );
        assert!(!late.contains("lost") && !late.contains("invented"), "{late}");
    }

    #[test]
    fn momenta_are_triples_or_magnitudes() {
        assert_eq!(triple(DVec3::new(1.0, -2.5, 0.0)), "    1.000   -2.500    0.000");
        assert_eq!(triple(DVec3::new(-999.9994, 0.0, 2.0)), " -999.999    0.000    2.000");
        assert_eq!(triple(DVec3::new(0.0, -1377.073, -99_999.9)), "      0.0  -1377.1 -99999.9");
        assert_eq!(triple(DVec3::new(0.0, 3e-9, 4e-9)), "magnitude 5.0e-9");
        assert_eq!(triple(DVec3::ZERO), "        0        0        0");
    }
}
