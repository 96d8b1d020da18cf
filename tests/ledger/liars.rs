//! Laws that lie about their work are caught by the residual.

use glam::DVec3;
use motion::ledger::Ledger;
use motion::{BodyState, EvaluationTime, Jacobians, Law, Laws, Method};

use super::Kept;

/// A spring to the origin, `a = -w² x`, that states `stated` times its potential, if it states one.
#[derive(Debug)]
struct Harmonic {
    stated: Option<f64>,
}

const W2: f64 = 9.0;

impl Law for Harmonic {
    fn name(&self) -> &'static str {
        "harmonic"
    }
    fn acceleration(&self, _: EvaluationTime, body: BodyState) -> DVec3 {
        body.position * -W2
    }
    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians { position: glam::DMat3::IDENTITY * -W2, ..Jacobians::zero() }
    }
    fn depends_on_velocity(&self) -> bool {
        false
    }
    fn has_potential(&self) -> bool {
        self.stated.is_some()
    }
    fn potential_energy(&self, body: BodyState) -> f64 {
        self.stated.unwrap_or(0.0) * W2 * body.position.dot(body.position)
            / (2.0 * body.inverse_mass)
    }
}

/// Half a second of a body of 2 kg at rest 1 m out; its kinetic energy at the end.
fn run(stated: Option<f64>) -> (Kept, f64) {
    let scene = "bodies: [(name: \"a\", position_m: (1.0, 0.0, 0.0), mass_kg: 2.0)]";
    let mut kept = Kept::of(scene, Method::RungeKutta4, 240.0, 4);
    kept.simulation.world.insert_resource(Laws(vec![Box::new(Harmonic { stated })]));
    kept.simulation.stepper.recompile(&mut kept.simulation.world);
    kept.ledger = Ledger::open(&kept.simulation.world);
    let kinetic = kept.run(120).check().ledger.energies().kinetic;
    (kept, kinetic)
}

#[test]
fn a_law_with_an_honest_potential_and_one_without_any_leave_next_to_nothing() {
    let (honest, kinetic) = run(Some(1.0));
    assert!(kinetic > 1.0 && honest.residual().abs() < 1e-9 * kinetic, "{}", honest.residual());
    assert!(honest.ledger.since_opening().energy.laws.is_empty());
    let (powered, kinetic) = run(None);
    let work = powered.ledger.since_opening().energy.law("harmonic");
    assert!(
        (work - kinetic).abs() < 1e-9 * kinetic && powered.residual().abs() < 1e-9 * kinetic,
        "{work}"
    );
    assert!(powered.ledger.energies().potential.is_empty());
}

#[test]
fn a_wrong_potential_and_work_left_out_are_residual() {
    // What it gave is the kinetic energy; the potential stated fell by 0.9 of it.
    let (wrong, kinetic) = run(Some(0.9));
    assert!(
        (wrong.residual() - 0.1 * kinetic).abs() < 1e-9 * kinetic,
        "{} {kinetic}",
        wrong.residual()
    );
    let (silent, kinetic) = run(Some(0.0));
    assert!(
        (silent.residual() - kinetic).abs() < 1e-12 * kinetic,
        "{} {kinetic}",
        silent.residual()
    );
}
