//! An entry of a scene file that makes bodies, and all bodies of a scene.

use std::ops::Range;

use glam::DVec3;
use motion::Method;
use rand_pcg::Pcg64;

use super::body::Defaults;
use crate::check::{Scope, shown_vector};
use crate::memory::Census;
use crate::raw;
use crate::scene::BodySpec;
use crate::scene::coupled::{EmitterSpec, SoftBodySpec};
use crate::scene::names::{Names, Numbering};
use crate::substepping::Substepping;
use crate::text::faults::Faults;
use crate::text::syntax::Triple;

/// Every body of a scene and what belongs to it by stable id.
#[derive(Default)]
pub(crate) struct Bodies {
    /// The written bodies at least; all of them if there are names.
    pub bodies: Vec<BodySpec>,
    /// `None` if there are too many bodies for names.
    pub names: Option<Names>,
    pub labels: Vec<(u32, String)>,
    pub emitters: Vec<EmitterSpec>,
    pub soft_bodies: Vec<SoftBodySpec>,
    /// The entries of the file, in the order of their ids.
    pub sections: Vec<Section>,
}

/// The bodies of one entry of the file, which have one method and one number of substeps.
pub(crate) struct Section {
    pub scope: Scope,
    pub ids: Range<u32>,
    /// Their method; `None` if the text is not the name of a method.
    pub method: Option<Method>,
    /// Whether the entry itself names the method.
    pub own_method: bool,
    /// Their substeps; `None` if the text does not give valid ones.
    pub substeps: Option<Substepping>,
}

/// Whether an entry names a method itself, and whether it names a number of substeps.
#[derive(Clone, Copy)]
pub(super) struct Own {
    pub method: bool,
    pub substeps: bool,
}

/// An entry that makes bodies.
pub(super) struct GeneratedEntry {
    pub scope: Scope,
    pub own: Own,
    pub count: u64,
    /// Number of particles on a graphics device.
    pub on_device: u64,
    /// Number of springs between its bodies.
    pub springs: u64,
    /// Number of triangles of its sheet.
    pub triangles: u64,
    pub numbering: Numbering,
    /// What its bodies have in common.
    pub body: BodySpec,
    /// Makes its bodies, whose names begin with the given text.
    pub make: Box<dyn Fn(String, &mut Bodies, &mut Pcg64)>,
}

impl GeneratedEntry {
    /// An entry of `count` bodies without springs, triangles and particles on a device; `own` is of [`shared`].
    pub fn new(
        scope: Scope,
        own: Own,
        count: u64,
        numbering: Numbering,
        body: BodySpec,
        make: impl Fn(String, &mut Bodies, &mut Pcg64) + 'static,
    ) -> Self {
        let make = Box::new(make);
        Self { scope, own, count, on_device: 0, springs: 0, triangles: 0, numbering, body, make }
    }

    pub fn census(&self, attracts: bool, in_air: bool) -> Census {
        let (is_pool, is_soft) =
            (self.scope.section == "emitters", self.scope.section == "soft_bodies");
        let those = |are: bool| if are { self.count } else { 0 };
        let is_grouped = is_soft || attracts && !is_pool;
        Census {
            bodies: self.count,
            on_device: self.on_device,
            moved: those(is_grouped || is_pool),
            grouped: those(is_grouped),
            links: self.springs,
            blown: if in_air { self.triangles } else { 0 },
            ..Census::default()
        }
    }
}

impl Section {
    pub(super) fn new(
        scope: Scope,
        ids: Range<u32>,
        own: Own,
        body: &BodySpec,
        scenes: Defaults,
    ) -> Self {
        Self {
            scope,
            ids,
            method: if own.method { body.method } else { scenes.method },
            own_method: own.method,
            substeps: if own.substeps { body.substeps } else { Some(scenes.substeps) },
        }
    }
}

/// What the bodies of an entry have in common by its shared keys. The mass is `mass` by default, and shared by
/// `bodies`; `cure` is that of a wrong mass.
pub(super) fn shared(
    keys: &raw::SharedKeys<'_>,
    scope: Scope,
    mass: f64,
    bodies: f64,
    cure: &str,
    faults: &mut Faults,
) -> (BodySpec, Own) {
    let body = BodySpec {
        inverse_mass: Some(faults.inverse_mass(scope, keys.mass_kg, mass, bodies, cure)),
        color: faults.color(scope, keys.color),
        method: faults.method(scope, keys.method),
        substeps: faults.substeps(scope, keys.substeps),
        ..BodySpec::DEFAULT
    };
    (body, Own { method: keys.method.is_some(), substeps: keys.substeps.is_some() })
}

/// A number of bodies, at least 1; 0 if it is missing or invalid.
pub(super) fn count(value: Option<u32>, scope: Scope, key: &str, faults: &mut Faults) -> u32 {
    const CURE: &str = "give a whole number from 1 up";
    faults.require(value.is_some(), scope, key, CURE);
    if value == Some(0) {
        faults.refuse(scope, key, format!("{key} is 0, which makes no body"), CURE);
    }
    value.unwrap_or(0)
}

/// A unit vector; up if it is missing or invalid.
pub(super) fn direction(
    scope: Scope,
    key: &str,
    value: Option<Triple>,
    faults: &mut Faults,
) -> DVec3 {
    let given = faults.vector(scope, key, value, DVec3::Y);
    given.try_normalize().unwrap_or_else(|| {
        let what = format!("{} is not a direction", shown_vector(given));
        faults.refuse(
            scope,
            key,
            what,
            "give a vector that is not zero; its length does not matter",
        );
        DVec3::Y
    })
}
