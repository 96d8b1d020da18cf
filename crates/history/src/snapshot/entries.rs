//! What a snapshot is made of, as it is written into files.

use motion::clock::ClockState;
use motion::effects::Effect;
use motion::snapshot::EmissionState;
use motion::units::{Scalar, Vector};
use motion::{Damping, DampingModel, Method, Request};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::Name;
use crate::lists::list;

/// A push: stable id and newtons.
pub(crate) type PushEntry = (u32, [f64; 3]);

/// What a clock of ticks counts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ClockEntry(#[serde(with = "ClockFields")] pub ClockState);

#[derive(Serialize, Deserialize)]
#[serde(remote = "ClockState")]
struct ClockFields {
    #[serde(default)]
    ticks: u64,
    #[serde(default)]
    since_tick: u64,
    #[serde(default)]
    since_time: Scalar,
    #[serde(default)]
    step: Scalar,
    #[serde(default)]
    scene_began: Scalar,
}

/// What was counted so far.
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

/// What had happened to it.
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

/// What an emitter goes on from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct EmissionEntry(#[serde(with = "EmissionFields")] pub EmissionState);

#[derive(Serialize, Deserialize)]
#[serde(remote = "EmissionState")]
struct EmissionFields {
    #[serde(default)]
    next: u64,
    #[serde(default)]
    oldest: u64,
    #[serde(default, deserialize_with = "list")]
    slots: Vec<Option<u64>>,
    #[serde(default)]
    seen: Option<(u64, Scalar)>,
}

/// A request that names its body by stable id.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RequestEntry(pub Request<u32>);

impl Serialize for RequestEntry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        SavedRequest::from(self.0).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for RequestEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self(SavedRequest::deserialize(deserializer)?.into()))
    }
}

/// A request as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum SavedRequest {
    Impulse(u32, [f64; 3]),
    SetVelocity(u32, [f64; 3]),
    SetPosition(u32, [f64; 3]),
    SetInverseMass(u32, f64),
    ReverseVelocities,
    SetGravity([f64; 3]),
    SwitchGravity(bool),
    SetDamping(Name<DampingModel>, f64),
    Switch(Name<Effect>, bool),
    SetBodyMethod(u32, Option<Name<Method>>),
    Remove(u32),
}

impl From<Request<u32>> for SavedRequest {
    fn from(request: Request<u32>) -> Self {
        match request {
            Request::Impulse(body, value) => Self::Impulse(body, value.to_array()),
            Request::SetVelocity(body, value) => Self::SetVelocity(body, value.to_array()),
            Request::SetPosition(body, value) => Self::SetPosition(body, value.to_array()),
            Request::SetInverseMass(body, w) => Self::SetInverseMass(body, w),
            Request::ReverseVelocities => Self::ReverseVelocities,
            Request::SetGravity(value) => Self::SetGravity(value.to_array()),
            Request::SwitchGravity(on) => Self::SwitchGravity(on),
            Request::SetDamping(Damping { model, rate }) => Self::SetDamping(Name(model), rate),
            Request::Switch(effect, on) => Self::Switch(Name(effect), on),
            Request::SetBodyMethod(body, method) => Self::SetBodyMethod(body, method.map(Name)),
            Request::Remove(body) => Self::Remove(body),
        }
    }
}

impl From<SavedRequest> for Request<u32> {
    fn from(saved: SavedRequest) -> Self {
        match saved {
            SavedRequest::Impulse(body, value) => Self::Impulse(body, Vector::from_array(value)),
            SavedRequest::SetVelocity(body, value) => Self::SetVelocity(body, Vector::from_array(value)),
            SavedRequest::SetPosition(body, value) => Self::SetPosition(body, Vector::from_array(value)),
            SavedRequest::SetInverseMass(body, w) => Self::SetInverseMass(body, w),
            SavedRequest::ReverseVelocities => Self::ReverseVelocities,
            SavedRequest::SetGravity(value) => Self::SetGravity(Vector::from_array(value)),
            SavedRequest::SwitchGravity(on) => Self::SwitchGravity(on),
            SavedRequest::SetDamping(Name(model), rate) => Self::SetDamping(Damping { model, rate }),
            SavedRequest::Switch(Name(effect), on) => Self::Switch(effect, on),
            SavedRequest::SetBodyMethod(body, method) => {
                Self::SetBodyMethod(body, method.map(|Name(method)| method))
            }
            SavedRequest::Remove(body) => Self::Remove(body),
        }
    }
}
