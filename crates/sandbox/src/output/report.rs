//! The summary of a run, as JSON and as a table, and the hash of its state.

use std::fmt::Write as _;

use history::FaultEntry;
use motion::ledger::{Ledger, LedgerLines};
use motion::{LAWS, Method, Totals, totals};
use report::ForecastRow;
use report::numbers::json_number as number;
use serde_json::{Map, Value, json};

use cockpit::app::session::Session;
use cockpit::stage::Stage;
use cockpit::stage::quarantines::QuarantinedBody;

/// The hash of the state: XXH3-64 over the little-endian f64 bits of position and velocity of every body with physics, in
/// stable-id order.
#[must_use]
pub fn state_hash(stage: &Stage) -> u64 {
    stage.sim().hash()
}

/// The summary of a run.
#[derive(Clone, Debug)]
pub struct Summary {
    fields: Map<String, Value>,
}

impl Summary {
    /// Energy and momentum at the start of a run, from which its drift is measured.
    #[must_use]
    pub fn totals_at_start(stage: &Stage) -> Totals {
        totals(&stage.sim().world)
    }

    /// The summary of `session`, which began with the totals `start`. `adapter` drew the `pictures`, if any.
    #[must_use]
    pub fn of(
        session: &mut Session,
        start: Totals,
        pictures: u64,
        adapter: Option<String>,
    ) -> Self {
        let now = totals(&session.stage.sim().world);
        let evaluations = session.stage.sim().evaluations();
        // Every law is listed: an inactive law was evaluated 0 times.
        let laws: Map<_, _> = LAWS
            .iter()
            .map(|(law, _)| (*law, 0))
            .chain(evaluations.laws().iter().copied())
            .map(|(law, count)| (law.to_owned(), json!(count)))
            .collect();
        let (accelerations, cg_iterations) =
            (evaluations.accelerations(), evaluations.cg_iterations());
        let (newton_iterations, unconverged_steps) =
            (evaluations.newton_iterations(), evaluations.unconverged_steps());
        let quarantined: Vec<_> = session
            .stage
            .quarantines()
            .all()
            .iter()
            .map(|QuarantinedBody { body, tick, what, system, component, cause }| {
                json!({
                    "body": body, "tick": tick, "what": what,
                    "system": system, "component": component, "cause": cause,
                })
            })
            .collect();
        let forecast: Vec<_> =
            session.tools.forecast_at_start().iter().map(ForecastRow::json).collect();
        let methods: Map<_, _> = session
            .stage
            .sim()
            .bodies_per_method()
            .into_iter()
            .map(|(method, bodies)| (method.name().to_owned(), json!(bodies)))
            .collect();
        let fields = [
            ("scene", json!(session.stage.sim().scene.name)),
            ("method", json!(session.stage.sim().stepper.method().name())),
            ("methods", Value::Object(methods)),
            ("step_hz", number(session.stage.playback().step_hz())),
            ("ticks", json!(session.stage.sim().ticks())),
            ("simulated_s", number(session.stage.sim().seconds())),
            ("dropped_s", number(session.stage.playback().dropped())),
            ("force_evaluations", json!(accelerations)),
            ("laws", Value::Object(laws)),
            ("cg_iterations", json!(cg_iterations)),
            ("newton_iterations", json!(newton_iterations)),
            ("unconverged_steps", json!(unconverged_steps)),
            ("kinetic_energy_j", number(now.kinetic_energy)),
            ("potential_energy_j", number(now.potential_energy)),
            ("momentum_kg_m_s", vector(now.momentum)),
            ("angular_momentum_kg_m2_s", vector(now.angular_momentum)),
            ("energy_at_start_j", number(start.kinetic_energy + start.potential_energy)),
            ("forecast", Value::Array(forecast)),
            ("quarantined", Value::Array(quarantined)),
            ("state_hash", json!(format!("{:016x}", state_hash(&session.stage)))),
            // The contract's name for the number of pictures.
            ("frames", json!(pictures)),
            ("adapter", adapter.map_or(Value::Null, Value::String)),
        ];
        let on_device = session.stage.sim().scene.on_device();
        let without: Vec<_> = on_device.map(|(_, emitter)| emitter.name.as_str()).collect();
        let ledger = session.tools.ledger().map(|ledger| ("ledger", ledger_json(ledger, &without)));
        let fields = fields.into_iter().chain(ledger);
        Self { fields: fields.map(|(name, value)| (name.to_owned(), value)).collect() }
    }

    /// Adds a field at the end.
    pub(crate) fn add(&mut self, field: &str, value: Value) {
        self.fields.insert(field.to_owned(), value);
    }

    /// The summary as JSON, with the fields in the order of the contract.
    #[must_use]
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(&self.fields)
            .expect("maps of numbers and strings are JSON");
        text.push('\n');
        text
    }

    /// The summary as a table for people.
    #[must_use]
    #[expect(clippy::wildcard_enum_match_arm, reason = "JSON shows itself")]
    pub fn to_table(&self) -> String {
        let mut table = String::new();
        for (field, value) in &self.fields {
            let value = match value {
                Value::String(name) if field == "method" => Method::from_name(name).map_or_else(
                    || name.clone(),
                    |method| format!("{name} ({})", method.claims().title),
                ),
                Value::String(text) => text.clone(),
                Value::Null => "none".to_owned(),
                Value::Array(items) if field == "quarantined" || field == "forecast" => {
                    let _ = writeln!(table, "{field:<26} {}", items.len());
                    for item in items.iter().take(10) {
                        let _ = writeln!(table, "  {item}");
                    }
                    continue;
                }
                Value::Object(lines) if field == "ledger" => {
                    let _ = writeln!(table, "{field}");
                    for (line, value) in lines {
                        let _ = writeln!(table, "  {line:<24} {value}");
                    }
                    continue;
                }
                other => other.to_string(),
            };
            let _ = writeln!(table, "{field:<26} {value}");
        }
        table
    }
}

/// The ledger since it was opened, as JSON. `without` names the emitters whose particles it omits.
fn ledger_json(ledger: &Ledger, without: &[&str]) -> Value {
    let sums = ledger.since_opening();
    let LedgerLines { pushes, laws, damping, limits, anchors, interventions, residual } =
        &sums.energy;
    let mut fields = json!({
        "kept_s": number(ledger.seconds()),
        "change_j": number(sums.energy.change()),
        "push_work_j": number(*pushes),
        "laws": by_law(laws, |work| number(*work)),
        "damping_j": number(*damping),
        "limits_j": number(*limits),
        "anchors_j": number(*anchors),
        "interventions_j": number(*interventions),
        "residual_j": number(*residual),
        "residual_j_per_s": number(ledger.mean_residual_rate()),
        "relative_residual": number(ledger.relative_residual()),
        "momentum": vectors(&sums.momentum, "n_s"),
        "angular_momentum": vectors(&sums.angular_momentum, "n_m_s"),
    });
    if !without.is_empty() {
        fields["without"] = json!(without);
    }
    fields
}

/// The ledger lines of a vector quantity as JSON, in `unit`.
fn vectors(lines: &LedgerLines<glam::DVec3>, unit: &str) -> Value {
    let LedgerLines { pushes, laws, damping, limits, anchors, interventions, residual } = lines;
    let line = |name: &str, amount: glam::DVec3| (format!("{name}_{unit}"), vector(amount));
    let fields = [
        line("change", lines.change()),
        line("pushes", *pushes),
        ("laws".to_owned(), by_law(laws, |amount| vector(*amount))),
        line("damping", *damping),
        line("limits", *limits),
        line("anchors", *anchors),
        line("interventions", *interventions),
        line("residual", *residual),
    ];
    Value::Object(fields.into_iter().collect())
}

fn by_law<T>(laws: &[(&'static str, T)], value: fn(&T) -> Value) -> Value {
    Value::Object(laws.iter().map(|(name, amount)| ((*name).to_owned(), value(amount))).collect())
}

/// A fault as JSON; null without one.
pub(crate) fn fault_json(fault: Option<&FaultEntry>) -> Value {
    fault.map_or(
        Value::Null,
        |FaultEntry { tick, body, what }| json!({ "tick": tick, "body": body, "what": what }),
    )
}

fn vector(v: glam::DVec3) -> Value {
    Value::Array(v.to_array().map(number).to_vec())
}
