//! The parts of a snapshot, as files contain them.

use motion::clock::ClockState;
use motion::effects::Effect;
use motion::snapshot::{Effects, EmissionState};
use motion::units::{Scalar, Vector};
use motion::{Damping, Gravity, Method, Request};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::words::{self, Name};
use scene::lists::list;

/// A push: stable id and newtons.
pub(crate) type PushEntry = (u32, [f64; 3]);

/// The state of a clock of ticks.
#[derive(Default, Serialize, Deserialize)]
#[serde(remote = "ClockState", default)]
pub(crate) struct ClockFields {
    ticks: u64,
    since_tick: u64,
    since_time: Scalar,
    step: Scalar,
    scene_began: Scalar,
}

/// Gravity and damping of a world, and the effects that are off.
#[derive(Default, Serialize, Deserialize)]
#[serde(remote = "Effects", default)]
pub(crate) struct EffectsFields {
    /// Acceleration of gravity, m/s², and whether it acts.
    #[serde(with = "gravity")]
    gravity: Option<Gravity>,
    /// Rate of damping, 1/s.
    #[serde(with = "scene_damping")]
    damping: Option<Damping>,
    #[serde(with = "effects")]
    off: Vec<Effect>,
}

/// The counts of evaluations so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct CountsEntry {
    pub accelerations: u64,
    #[serde(deserialize_with = "list")]
    pub laws: Vec<(Name<&'static str>, u64)>,
    pub newton_iterations: u64,
    pub cg_iterations: u64,
    pub unconverged_steps: u64,
}

impl CountsEntry {
    /// The largest of all counts.
    pub fn largest(&self) -> u64 {
        let Self { accelerations, laws, newton_iterations, cg_iterations, unconverged_steps } = self;
        let all = [accelerations, newton_iterations, cg_iterations, unconverged_steps].into_iter();
        all.chain(laws.iter().map(|(_, count)| count)).copied().max().unwrap_or(0)
    }
}

/// A body that was quarantined.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RecordEntry {
    pub body: u32,
    pub tick: u64,
    pub system: Name<&'static str>,
    pub component: Name<&'static str>,
    pub fault: SavedFault,
}

/// The fault of a quarantined body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum SavedFault {
    Found,
    Law(Name<&'static str>),
    /// The stable id of the other end.
    Spring(u32),
    Overflow,
    Range(f64),
    Request,
}

/// The state of an emitter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct EmissionEntry(#[serde(with = "EmissionFields")] pub EmissionState);

#[derive(Default, Serialize, Deserialize)]
#[serde(remote = "EmissionState", default)]
struct EmissionFields {
    next: u64,
    oldest: u64,
    #[serde(deserialize_with = "list")]
    slots: Vec<Option<u64>>,
    seen: Option<(u64, Scalar)>,
}

/// A request that names its body by stable id.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct RequestEntry(#[serde(with = "RequestFields")] pub Request<u32>);

#[derive(Serialize, Deserialize)]
#[serde(remote = "Request<u32>", rename_all = "snake_case")]
enum RequestFields {
    Impulse(u32, #[serde(with = "vector")] Vector),
    SetVelocity(u32, #[serde(with = "vector")] Vector),
    SetPosition(u32, #[serde(with = "vector")] Vector),
    SetInverseMass(u32, f64),
    ReverseVelocities,
    SetGravity(#[serde(with = "vector")] Vector),
    SwitchGravity(bool),
    SetDamping(#[serde(with = "damping")] Damping),
    Switch(#[serde(with = "words")] Effect, bool),
    SetBodyMethod(u32, #[serde(with = "words::optional")] Option<Method>),
    Remove(u32),
}

pub(crate) mod requests {
    //! A list of requests.

    use super::{Deserializer, Request, RequestEntry, Serializer, list};

    pub(crate) fn serialize<S: Serializer>(all: &[Request<u32>], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(all.iter().copied().map(RequestEntry))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<Vec<Request<u32>>, D::Error> {
        Ok(list(source)?.into_iter().map(|RequestEntry(request)| request).collect())
    }
}

pub(crate) mod vector {
    //! A vector as three numbers.

    use super::{Deserialize, Deserializer, Serialize, Serializer, Vector};

    pub(crate) fn serialize<S: Serializer>(vector: &Vector, serializer: S) -> Result<S::Ok, S::Error> {
        vector.to_array().serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<Vector, D::Error> {
        <[f64; 3]>::deserialize(source).map(Vector::from_array)
    }
}

mod gravity {
    //! Gravity as its acceleration and whether it is on.

    use super::{Deserialize, Deserializer, Gravity, Serialize, Serializer, Vector};

    pub(super) fn serialize<S: Serializer>(
        gravity: &Option<Gravity>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        gravity.map(|gravity| (gravity.acceleration.to_array(), gravity.on)).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<Option<Gravity>, D::Error> {
        let gravity: Option<([f64; 3], bool)> = Deserialize::deserialize(source)?;
        Ok(gravity.map(|(acceleration, on)| Gravity { acceleration: Vector::from_array(acceleration), on }))
    }
}

mod scene_damping {
    //! Damping, which may be absent.

    use super::{Damping, Deserialize, Deserializer, Name, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(
        damping: &Option<Damping>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        damping.map(|damping| (Name(damping.model), damping.rate)).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<Option<Damping>, D::Error> {
        let damping: Option<_> = Deserialize::deserialize(source)?;
        Ok(damping.map(|(Name(model), rate)| Damping { model, rate }))
    }
}

mod effects {
    //! A list of effects.

    use super::{Deserializer, Effect, Name, Serializer, list};

    pub(super) fn serialize<S: Serializer>(all: &[Effect], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(all.iter().copied().map(Name))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<Vec<Effect>, D::Error> {
        Ok(list(source)?.into_iter().map(|Name(effect)| effect).collect())
    }
}

mod damping {
    //! Damping as its model and rate.

    use serde::de::Error as _;

    use super::{Damping, Deserialize, Deserializer, Name, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(damping: &Damping, serializer: S) -> Result<S::Ok, S::Error> {
        (Name(damping.model), damping.rate).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<Damping, D::Error> {
        let (Name(model), rate) = Deserialize::deserialize(source)?;
        if rate < 0.0 {
            return Err(D::Error::custom("a damping rate is below 0"));
        }
        Ok(Damping { model, rate })
    }
}
