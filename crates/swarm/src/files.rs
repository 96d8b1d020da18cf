//! The ticks of a swarm in files. Laws are written once for all ticks that share them.

use std::sync::Arc;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::laws::damping::DampingModel;
use crate::lists::list;
use crate::schedule::swarm::{Swarm, SwarmLog, SwarmTick};
use crate::schedule::swarm_laws::{SwarmDrag, SwarmLaws};
use crate::state::substeps::Substeps;

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct LogFields {
    key: u64,
    reversed: bool,
    #[serde(deserialize_with = "list")]
    laws: Vec<LawsFields>,
    #[serde(deserialize_with = "list")]
    ticks: Vec<TickEntry>,
}

/// The number of the laws of a tick, and the rest of it.
#[derive(Serialize, Deserialize)]
struct TickEntry(usize, SwarmTick);

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct LawsFields {
    constant: [f32; 3],
    rate: f32,
    /// Linear, quadratic and turns.
    drag: Option<[f32; 3]>,
    /// Mean, across, up and wave.
    wind: [[f32; 3]; 4],
    #[serde(deserialize_with = "list")]
    wells: Vec<[f32; 5]>,
    damping: Option<(DampingModel, f32)>,
}

impl From<&SwarmLaws> for LawsFields {
    fn from(laws: &SwarmLaws) -> Self {
        let SwarmLaws { constant, rate, drag, wells, damping } = laws;
        let SwarmDrag { linear, quadratic, mean, across, up, wave, turns } =
            drag.unwrap_or_default();
        Self {
            constant: *constant,
            rate: *rate,
            drag: drag.map(|_| [linear, quadratic, turns]),
            wind: [mean, across, up, wave],
            wells: wells.to_vec(),
            damping: *damping,
        }
    }
}

impl From<LawsFields> for SwarmLaws {
    fn from(fields: LawsFields) -> Self {
        let [mean, across, up, wave] = fields.wind;
        let drag = |[linear, quadratic, turns]: [f32; 3]| SwarmDrag {
            linear,
            quadratic,
            mean,
            across,
            up,
            wave,
            turns,
        };
        Self {
            constant: fields.constant,
            rate: fields.rate,
            drag: fields.drag.map(drag),
            wells: fields.wells.into(),
            damping: fields.damping,
        }
    }
}

impl Serialize for SwarmLog {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { ticks, key, reversed } = self;
        let mut fields = LogFields { key: *key, reversed: *reversed, ..LogFields::default() };
        let mut written: Option<&Arc<SwarmLaws>> = None;
        for tick in ticks {
            if written.is_none_or(|laws| !Arc::ptr_eq(laws, &tick.laws)) {
                fields.laws.push((&*tick.laws).into());
                written = Some(&tick.laws);
            }
            fields.ticks.push(TickEntry(fields.laws.len() - 1, tick.clone()));
        }
        fields.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for SwarmLog {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        let LogFields { key, reversed, laws, ticks } = LogFields::deserialize(source)?;
        let laws: Vec<_> = laws.into_iter().map(|laws| Arc::new(SwarmLaws::from(laws))).collect();
        let tick = |TickEntry(which, tick): TickEntry| {
            let laws = laws.get(which).map(Arc::clone);
            let laws = laws.ok_or_else(|| D::Error::custom("a tick of a swarm has no laws"))?;
            let count = tick.births[1].checked_sub(tick.births[0]);
            let holds = (1..=Substeps::MOST).contains(&tick.substeps)
                && tick.step > 0.0
                && tick.step.is_finite()
                && count.is_some_and(|count| count <= Swarm::MOST);
            if !holds {
                return Err(D::Error::custom("invalid tick of a swarm"));
            }
            Ok(SwarmTick { laws, ..tick })
        };
        let ticks = ticks.into_iter().map(tick).collect::<Result<_, _>>()?;
        Ok(Self { ticks, key, reversed })
    }
}
