//! The laws of a swarm in plain numbers.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use crate::laws::damping::{Damping, DampingModel};
use crate::laws::{Affine, DeviceForm, Gravity, Law, SharedLaws, Well};
use crate::units::Vector;

/// The laws of a swarm: `a = constant - rate v`, plus drag and wells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SwarmLaws {
    /// The sum of constant accelerations, m/s².
    pub constant: [f32; 3],
    /// The sum of rates of linear drag, with that of exact damping, 1/s.
    pub rate: f32,
    /// Drag that is quadratic, or in gusts.
    pub drag: Option<SwarmDrag>,
    /// Wells, each as its place, m, its strength mu, m³/s², and its softening, m.
    pub wells: Arc<[[f32; 5]]>,
    /// Damping that multiplies velocities, and its rate, 1/s.
    pub damping: Option<(DampingModel, f32)>,
}

/// Drag in [`SwarmLaws`]: as [`Drag`](crate::Drag), in wind as [`Wind`](crate::Wind).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SwarmDrag {
    /// Rate of the linear term, 1/s.
    pub linear: f32,
    /// Coefficient of the quadratic term, 1/m.
    pub quadratic: f32,
    /// Mean wind, m/s.
    pub mean: [f32; 3],
    /// Gusts: `across sin p + up sin(2p) / 2`, m/s. Zero in steady wind.
    pub across: [f32; 3],
    /// Amplitude of the gusts along the second direction, m/s: see [`across`](Self::across).
    pub up: [f32; 3],
    /// `p = phase + turns t - wave x`: wave vector, rad/m.
    pub wave: [f32; 3],
    /// Change of the phase, rad/s.
    pub turns: f32,
}

/// Converts numbers to the precision of a device. A number out of its range becomes infinite.
#[expect(clippy::cast_possible_truncation, reason = "the precision of a device")]
pub(crate) fn single<const N: usize>(numbers: [f64; N]) -> [f32; N] {
    numbers.map(|number| number as f32)
}

impl SwarmLaws {
    /// The laws of `world` for a swarm with that anchor, and the phase of gusts there at `time`, s. They are those
    /// of `before`, shared, if nothing has changed.
    ///
    /// # Panics
    /// If a law of every body has no [`DeviceForm`].
    pub(crate) fn of(
        world: &World,
        anchor: Vector,
        time: f64,
        before: Option<&Arc<Self>>,
    ) -> (Arc<Self>, f32) {
        let mut sum = Affine { constant: Vector::ZERO, rate: 0.0 };
        let (mut laws, mut phase) = (Self::default(), 0.0);
        let mut wells: SmallVec<[&[Well]; 2]> = SmallVec::new();
        let gravity = world.get_resource::<Gravity>();
        for law in SharedLaws::of(world).on_body(gravity, false, &[]) {
            match form_of(law) {
                DeviceForm::Affine(Affine { constant, rate }) => {
                    sum = Affine { constant: sum.constant + constant, rate: sum.rate + rate };
                }
                DeviceForm::Drag(drag) => {
                    let wind = drag.wind.unwrap_or_default();
                    let air = wind.air(time);
                    let [gusts, turns] = if air.steady { [0.0; 2] } else { [1.0, wind.gust_hz] };
                    phase = within_a_turn(air.phase(anchor));
                    let [linear, quadratic, turns] =
                        single([drag.linear, drag.quadratic, std::f64::consts::TAU * turns]);
                    laws.drag = Some(SwarmDrag {
                        linear,
                        quadratic,
                        mean: single(air.mean.to_array()),
                        across: single((air.across * gusts).to_array()),
                        up: single((air.up * gusts).to_array()),
                        wave: single((air.wave * gusts).to_array()),
                        turns,
                    });
                }
                DeviceForm::Wells(these) => wells.push(these),
            }
        }
        match world.get_resource::<Damping>() {
            Some(damping) if damping.is_exact() => sum.rate += damping.rate,
            Some(Damping { model, rate }) => laws.damping = Some((*model, single([*rate])[0])),
            None => {}
        }
        (laws.constant, laws.rate) = (single(sum.constant.to_array()), single([sum.rate])[0]);
        let row = |well: &Well| {
            let [x, y, z] = (well.position - anchor).to_array();
            single([x, y, z, well.strength, well.softening])
        };
        let rows = || wells.iter().copied().flatten().map(row);
        let [phase] = single([phase]);
        let Some(before) = before else {
            laws.wells = rows().collect();
            return (Arc::new(laws), phase);
        };
        // A steady tick allocates nothing.
        laws.wells = if before.wells.iter().copied().eq(rows()) {
            Arc::clone(&before.wells)
        } else {
            rows().collect()
        };
        (if laws == **before { Arc::clone(before) } else { Arc::new(laws) }, phase)
    }

    /// The bits of all numbers.
    pub fn words(&self) -> impl Iterator<Item = u64> + '_ {
        let Self { constant, rate, drag, wells, damping } = self;
        let drag = drag.iter().flat_map(|drag| {
            let SwarmDrag { linear, quadratic, mean, across, up, wave, turns } = *drag;
            [linear, quadratic, turns]
                .into_iter()
                .chain([mean, across, up, wave].into_iter().flatten())
        });
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

/// # Panics
/// If the law has none.
fn form_of(law: &dyn Law) -> DeviceForm<'_> {
    law.device_form().unwrap_or_else(|| {
        panic!(
            "the law `{}` has no form for a graphics device; give it a `device_form`, or the emitter a pool of bodies",
            law.name()
        )
    })
}
