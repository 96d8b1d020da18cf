//! What a single body may ask for about how it is integrated: its own method, substeps and laws.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::prelude::*;

use crate::kernels::Known;
use crate::laws::Law;
use crate::methods::table::Method;
use crate::methods::with_method;
use crate::state::springs::structure_changed;
use crate::units::Scalar;

/// Parts into which a tick is divided for every body without [`OwnSubsteps`], at least 1.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Substeps(pub u32);

impl Substeps {
    /// Most parts that a tick may have: a slip of the finger must not stop a program for minutes.
    pub const MOST: u32 = 100_000;

    /// How many parts a tick has, 1 where nothing is said.
    pub(crate) fn parts(substeps: Option<&Self>) -> u32 {
        substeps.map_or(1, |substeps| substeps.0.max(1))
    }
}

impl Default for Substeps {
    fn default() -> Self {
        Self(1)
    }
}

/// Parts into which a tick is divided for this body, at least 1. Present only on bodies that ask for it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(on_insert = structure_changed, on_discard = structure_changed)]
pub struct OwnSubsteps(pub u32);

/// Laws of this body alone, such as its engines. Present only on bodies that have some.
#[derive(Component, Debug)]
pub struct OwnLaws {
    laws: Vec<Box<dyn Law<Scalar>>>,
    /// The place of each law among all that the body was given: it is added up there also after it was off.
    places: Vec<usize>,
    version: u64,
}

impl OwnLaws {
    /// These laws, added up.
    #[must_use]
    pub fn new(laws: Vec<Box<dyn Law<Scalar>>>) -> Self {
        let places = (0..laws.len()).collect();
        Self { laws, places, version: next_version() }
    }

    /// The laws.
    #[must_use]
    pub fn laws(&self) -> &[Box<dyn Law<Scalar>>] {
        &self.laws
    }

    pub(crate) const fn version(&self) -> u64 {
        self.version
    }

    /// Those of that name, and the others; none of the two is empty.
    pub(crate) fn split(self, name: &str) -> (Option<Self>, Option<Self>) {
        let all = self.places.into_iter().zip(self.laws);
        let (named, others): (Vec<_>, Vec<_>) = all.partition(|(_, law)| law.name() == name);
        (Self::of_places(named), Self::of_places(others))
    }

    /// Both in the order in which the body was given them.
    pub(crate) fn merge(self, other: Self) -> Self {
        let mut all: Vec<_> = self.places.into_iter().zip(self.laws).collect();
        all.extend(other.places.into_iter().zip(other.laws));
        all.sort_by_key(|(place, _)| *place);
        let (places, laws) = all.into_iter().unzip();
        Self { laws, places, version: next_version() }
    }

    fn of_places(laws: Vec<(usize, Box<dyn Law<Scalar>>)>) -> Option<Self> {
        let (places, laws): (Vec<_>, Vec<_>) = laws.into_iter().unzip();
        (!laws.is_empty()).then(|| Self { laws, places, version: next_version() })
    }
}

/// No two lists of laws have the same version, also on different bodies and in different worlds: an acceleration of
/// the one is never taken for one of the other.
fn next_version() -> u64 {
    static VERSIONS: AtomicU64 = AtomicU64::new(1);
    VERSIONS.fetch_add(1, Ordering::Relaxed)
}

/// What position Verlet keeps of a body: the length of its last step, s. 0 is a start, with the Taylor value;
/// negative, velocities were turned round since. Only bodies of that method carry it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct LastStep(pub Scalar);

/// What velocity Verlet and Yoshida's composition keep of a body where laws are called: the last acceleration,
/// which is the next one's first. Only bodies of these methods carry it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, bytemuck::TransparentWrapper)]
#[repr(transparent)]
pub struct LastAcceleration(pub(crate) Known<Scalar>);

/// A body that has a method of its own, marked by the method's component, whatever the world's is.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_insert = structure_changed, on_discard = structure_changed)]
pub struct OwnMethod;

/// Marks a body as one that uses `method` whatever the world's is; `None` takes the mark away.
///
/// Only for bodies that have not been integrated yet: a running body changes its method by
/// [`Request::SetBodyMethod`](crate::Request::SetBodyMethod), which starts the new one as it should.
pub fn mark_method(body: &mut EntityWorldMut, method: Option<Method>) {
    while let Some(old) = own_method(body.as_readonly()) {
        with_method!(old, M => body.remove::<(OwnMethod, M)>());
    }
    if let Some(method) = method {
        with_method!(method, M => body.insert(M::default()));
    }
}

/// The method that a body is marked with.
#[must_use]
pub fn own_method(body: EntityRef) -> Option<Method> {
    Method::ALL.into_iter().find(|method| with_method!(method, M => body.contains::<M>()))
}
