//! The ticks of a swarm in files. Laws are written once for all ticks that share them.

use std::sync::Arc;

use motion::Substeps;
use motion::lists::list;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::laws::SwarmLaws;
use crate::log::{SwarmLog, SwarmTick};
use crate::swarm::Swarm;

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct LogFields {
    key: u64,
    reversed: bool,
    #[serde(deserialize_with = "list")]
    laws: Vec<SwarmLaws>,
    #[serde(deserialize_with = "list")]
    ticks: Vec<TickEntry>,
}

/// The number of the laws of a tick, and the rest of it.
#[derive(Serialize, Deserialize)]
struct TickEntry(usize, SwarmTick);

impl Serialize for SwarmLog {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { ticks, key, reversed } = self;
        let mut fields = LogFields { key: *key, reversed: *reversed, ..LogFields::default() };
        let mut written: Option<&Arc<SwarmLaws>> = None;
        for tick in ticks {
            if written.is_none_or(|laws| !Arc::ptr_eq(laws, &tick.laws)) {
                fields.laws.push((*tick.laws).clone());
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
        let laws: Vec<_> = laws.into_iter().map(Arc::new).collect();
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
