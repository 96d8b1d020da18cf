//! The laws of a swarm in plain numbers.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use motion::internals::{DeviceForm, device_forms};
use motion::lists::list;
use motion::units::Vector;
use motion::{Affine, Damping, DampingModel, Well};
use serde::{Deserialize, Deserializer, Serialize};
use smallvec::SmallVec;

/// The laws of a swarm: `a = constant - rate v`, plus drag and wells.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SwarmLaws {
    /// The sum of constant accelerations, m/s².
    pub constant: [f32; 3],
    /// The sum of rates of linear drag, with that of exact damping, 1/s.
    pub rate: f32,
    /// [`Drag`](motion::Drag) that is quadratic, or in gusts: its linear rate, 1/s, its quadratic coefficient, 1/m, and the
    /// change of the phase of gusts, rad/s.
    pub drag: Option<[f32; 3]>,
    /// The [`Wind`](motion::Wind) of the drag: its mean, m/s, both amplitudes of gusts, `across sin p + up sin(2p) / 2`, m/s, which
    /// are 0 in steady wind, and the wave vector of `p = phase + turns t - wave x`, rad/m.
    pub wind: [[f32; 3]; 4],
    /// Wells, each as its place, m, its strength mu, m³/s², and its softening, m.
    #[serde(serialize_with = "<[_]>::serialize", deserialize_with = "read_wells")]
    pub wells: Arc<[[f32; 5]]>,
    /// Damping that multiplies velocities, and its rate, 1/s.
    pub damping: Option<(DampingModel, f32)>,
}

fn read_wells<'de, D: Deserializer<'de>>(source: D) -> Result<Arc<[[f32; 5]]>, D::Error> {
    list(source).map(Vec::into)
}

/// Converts numbers to the precision of a device. A number out of its range becomes infinite.
#[expect(clippy::cast_possible_truncation, reason = "the precision of a device")]
pub(crate) fn single<const N: usize>(numbers: [f64; N]) -> [f32; N] {
    numbers.map(|number| number as f32)
}

impl SwarmLaws {
    /// Most wells: a uniform buffer of any device has room for these.
    pub const WELLS: usize = 64;

    /// The laws of `world` for a swarm with that anchor, and the phase of gusts there at `time`, s. They are those
    /// of `before`, shared, if nothing has changed.
    ///
    /// # Panics
    /// If a law of every body has no [`device_form`](motion::Law::device_form).
    pub(crate) fn of(
        world: &World,
        anchor: Vector,
        time: f64,
        before: Option<&Arc<Self>>,
    ) -> (Arc<Self>, f32) {
        let mut sum = Affine { constant: Vector::ZERO, rate: 0.0 };
        let (mut laws, mut phase) = (Self::default(), 0.0);
        let mut wells: SmallVec<[&[Well]; 2]> = SmallVec::new();
        for form in device_forms(world) {
            match form {
                DeviceForm::Affine(Affine { constant, rate }) => {
                    sum = Affine { constant: sum.constant + constant, rate: sum.rate + rate };
                }
                DeviceForm::Drag(drag) => {
                    let wind = drag.wind.unwrap_or_default();
                    let air = wind.air(time);
                    let [gusts, turns] = if air.steady { [0.0; 2] } else { [1.0, wind.gust_hz] };
                    phase = within_a_turn(air.phase(anchor));
                    let turns = std::f64::consts::TAU * turns;
                    laws.drag = Some(single([drag.linear, drag.quadratic, turns]));
                    let [across, up, wave] =
                        [air.across, air.up, air.wave].map(|part| part * gusts);
                    laws.wind = [air.mean, across, up, wave].map(|part| single(part.to_array()));
                }
                DeviceForm::Wells(these) => wells.push(these),
            }
        }
        match world.get_resource::<Damping>() {
            Some(Damping { model: DampingModel::Exact, rate }) => sum.rate += rate,
            Some(Damping { model, rate }) => laws.damping = Some((*model, single([*rate])[0])),
            None => {}
        }
        (laws.constant, laws.rate) = (single(sum.constant.to_array()), single([sum.rate])[0]);
        let row = |well: &Well| {
            let [x, y, z] = (well.position - anchor).to_array();
            single([x, y, z, well.strength, well.softening])
        };
        let rows = || wells.iter().copied().flatten().map(row);
        // A steady tick allocates nothing.
        laws.wells = match before {
            Some(before) if before.wells.iter().copied().eq(rows()) => Arc::clone(&before.wells),
            _ => rows().collect(),
        };
        let before = before.filter(|before| laws == ***before).map(Arc::clone);
        let [phase] = single([phase]);
        (before.unwrap_or_else(|| Arc::new(laws)), phase)
    }

    /// The bits of all numbers.
    pub fn words(&self) -> impl Iterator<Item = u64> + '_ {
        let Self { constant, rate, drag, wind, wells, damping } = self;
        let drag = drag.iter().flat_map(|drag| drag.iter().chain(wind.iter().flatten())).copied();
        let damping =
            damping.iter().flat_map(|(model, rate)| [u64::from(*model as u8), word(rate)]);
        let numbers = constant.iter().chain([rate]).copied().chain(drag);
        let numbers = numbers.chain(wells.iter().flatten().copied());
        numbers.map(|number| word(&number)).chain(damping)
    }
}

/// The bits of a number.
pub(crate) fn word(number: &f32) -> u64 {
    u64::from(number.to_bits())
}

/// Reduces an angle, rad, to the range from -pi to pi.
fn within_a_turn(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - (angle / turn).round() * turn
}
