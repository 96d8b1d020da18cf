//! The laws that all bodies share, except gravity: those that are resources of a world, and your own.

use bevy_ecs::change_detection::Tick;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use super::{DeviceForm, Gravity, Law, Laws, with_world_laws};

/// A law that is a resource of a world.
pub(crate) trait WorldLaw: Resource + Clone + Law {
    /// Whether its parameters are valid numbers.
    fn is_finite(&self) -> bool;

    /// Checks that its parameters are in their range.
    ///
    /// # Panics
    /// If one is not; the message names it.
    fn check(&self) {}

    /// Size of the lists that it holds, bytes.
    fn list_bytes(&self) -> usize {
        0
    }
}

/// The name of a law. An alias, because derives would borrow a reference from the file that they read.
pub(crate) type LawName = &'static str;

#[cfg(feature = "serde")]
crate::names::one_of!(
    /// The name of a law in files.
    law_name,
    super::LAWS.iter().map(|(law, _)| *law)
);

macro_rules! declare {
    ($($law:ident: $Law:ident ($($part:tt)*) $formula:literal;)*) => {
        /// The laws of this crate: the name under which [`Evaluations`](crate::Evaluations) counts each, and its
        /// formula.
        pub const LAWS: &[(&str, &str)] = &[
            ("gravity", "the same acceleration for every body: a = g"),
            $((stringify!($law), $formula),)*
            ("thrusts", "engines of single bodies: forces that follow a polynomial, a sine or a table in time"),
            ("damping", "the exact damping model: a = -c v"),
            ("springs", "springs with damping along their axes: F = k (L - L0) + c dL/dt"),
            ("mutual_gravity", "every two bodies attract each other: F = G m1 m2 r / (r² + s²)^(3/2)"),
        ];

        /// Laws of every body, each of which can be a resource of a world.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct WorldLaws {
            $(#[doc = concat!($formula, ".")] pub $law: Option<super::$Law>,)*
        }

        impl WorldLaws {
            /// Names of their resources, in the order in which the laws are summed.
            pub(crate) const RESOURCES: &[&str] = &[$(stringify!($Law)),*];

            /// Copies the laws of `world`.
            #[must_use]
            pub fn of(world: &World) -> Self {
                Self { $($law: world.get_resource().cloned(),)* }
            }

            /// Inserts these laws into `world`.
            pub fn insert_into(self, world: &mut World) {
                $(
                    if let Some(law) = self.$law {
                        world.insert_resource(law);
                    }
                )*
            }

            /// The name of the first law that no graphics device can evaluate.
            #[must_use]
            pub fn without_device_form(&self) -> Option<&'static str> {
                let mut laws = self.and(&[]).resources().map(|(_, law)| law);
                laws.find(|law| law.device_form().is_none()).map(Law::name)
            }

            /// These laws and `more`.
            pub(crate) fn and<'a>(&'a self, more: &'a [Box<dyn Law>]) -> SharedLaws<'a> {
                SharedLaws { $($law: self.$law.as_ref(),)* more }
            }
        }

        /// The laws that all bodies share, except gravity, in the order in which they are summed.
        #[derive(Clone, Copy)]
        pub(crate) struct SharedLaws<'a> {
            $(pub $law: Option<&'a super::$Law>,)*
            pub more: &'a [Box<dyn Law>],
        }

        impl<'a> SharedLaws<'a> {
            /// The laws that are resources, with the names of the resources.
            pub fn resources(self) -> impl Iterator<Item = (&'static str, &'a dyn Law)> {
                let laws = [$(self.$law.map(|law| (stringify!($Law), law as &dyn Law)),)*];
                laws.into_iter().flatten()
            }

            /// [Checks](WorldLaw::check) the laws that are resources.
            pub fn check(self) {
                $(self.$law.map(WorldLaw::check);)*
            }

            /// The first resource that is not [finite](WorldLaw::is_finite).
            pub fn not_finite(self) -> Option<&'static str> {
                let laws = [$((stringify!($Law), self.$law.is_none_or(WorldLaw::is_finite)),)*];
                laws.into_iter().find(|(_, is_finite)| !is_finite).map(|(name, _)| name)
            }
        }

        impl<'a> SharedLaws<'a> {
            /// The laws of `world`.
            pub fn of(world: &'a World) -> Self {
                let more = world.get_resource::<Laws>().map_or(&[][..], |laws| &laws.0);
                Self { $($law: world.get_resource(),)* more }
            }
        }

        /// [`SharedLaws`] as a parameter of a system.
        #[derive(SystemParam)]
        pub struct SharedLawsParam<'w> {
            $($law: Option<Res<'w, super::$Law>>,)*
            more: Option<Res<'w, Laws>>,
        }

        impl SharedLawsParam<'_> {
            pub(crate) fn laws(&self) -> SharedLaws<'_> {
                let more = self.more.as_deref().map_or(&[][..], |laws| &laws.0);
                SharedLaws { $($law: self.$law.as_deref(),)* more }
            }

            /// The last changes of the laws.
            pub(crate) fn changes(&self) -> Changes {
                Changes {
                    $($law: self.$law.as_ref().map(DetectChanges::last_changed),)*
                    more: self.more.as_ref().map(DetectChanges::last_changed),
                }
            }
        }

        /// System ticks of the last change of each resource; `None` for one that does not exist.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub(crate) struct Changes {
            $($law: Option<Tick>,)*
            more: Option<Tick>,
        }
    };
}

with_world_laws!(declare);

impl<'a> SharedLaws<'a> {
    /// The laws that act on a body with its `own` laws, and `gravity` if it acts on the body. Drag acts on the triangles of a
    /// sheet, not on its bodies.
    pub fn on_body(
        self,
        gravity: Option<&'a Gravity>,
        in_sheet: bool,
        own: &'a [Box<dyn Law>],
    ) -> impl Iterator<Item = &'a dyn Law> {
        let gravity = gravity.map(|gravity| gravity as &dyn Law);
        let drag = self.drag.filter(|_| !in_sheet);
        let own = own.iter().map(|law| &**law);
        gravity.into_iter().chain(Self { drag, ..self }.all()).chain(own)
    }
}

impl<'a> SharedLaws<'a> {
    /// Every law.
    pub fn all(self) -> impl Iterator<Item = &'a dyn Law> {
        self.resources().map(|(_, law)| law).chain(self.more.iter().map(|law| &**law))
    }

    /// The laws that are summed before a tick.
    pub fn affine(self) -> impl Iterator<Item = &'a dyn Law> {
        self.all().filter(|law| law.affine().is_some())
    }

    /// The laws that have to be called.
    pub fn called(self) -> impl Iterator<Item = &'a dyn Law> {
        self.all().filter(|law| law.affine().is_none())
    }
}

/// The formulas of gravity and the laws of every body of `world`, for particles that a graphics device integrates.
///
/// # Panics
/// If a law has no [`device_form`](Law::device_form).
pub fn device_forms(world: &World) -> impl Iterator<Item = DeviceForm<'_>> {
    let laws = SharedLaws::of(world).on_body(world.get_resource(), false, &[]);
    laws.map(|law| {
        law.device_form().unwrap_or_else(|| {
            panic!(
                "the law `{}` has no form for a graphics device; give it a `device_form`, or the emitter a pool of bodies",
                law.name()
            )
        })
    })
}
