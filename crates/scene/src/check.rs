//! Checks of single values: each returns a usable value and records the fault, so that resolving continues.

use glam::DVec3;
use motion::Method;

use crate::scene::BodySpec;
use crate::substepping::Substepping;
use crate::text::faults::Faults;
pub(crate) use crate::text::faults::shown;
use crate::text::nearest::one_of;
use crate::text::syntax::{Triple, Word};

/// A requirement on a number.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    holds: fn(f64) -> bool,
    /// What a number that fails it is not.
    noun: &'static str,
    pub(crate) cure: &'static str,
}

pub(crate) const fn rule(holds: fn(f64) -> bool, noun: &'static str, cure: &'static str) -> Rule {
    Rule { holds, noun, cure }
}

/// The rule of `rate_per_s` of damping.
pub const DAMPING_RATE: Rule =
    rule(not_negative, "a damping rate", "give a rate per second from 0 up");
/// The rule of `mass_kg` of a body that moves.
pub const BODY_MASS: Rule = rule(|v| positive(v) && (1.0 / v).is_finite(), "a mass", MASS);
/// The rule of every component of a vector.
pub const COMPONENT: Rule = rule(f64::is_finite, "finite", "give three finite numbers");
pub(crate) const RADIUS: Rule = rule(positive, "a radius", "give a positive number of meters");
pub(crate) const SPEED: Rule = rule(not_negative, "a speed", "give meters per second from 0 up");
/// The rule of `step_hz`.
pub const STEP_RATE: Rule = rule(
    |v| positive(v) && (1.0 / v).is_finite(),
    "a step rate",
    "give a positive number of steps per second",
);

pub(crate) const STIFFNESS: Rule =
    rule(not_negative, "a stiffness", "give a number of N/m from 0 up");

/// The cure for a bad mass.
pub(crate) const MASS: &str = "give a positive number of kilograms";

/// The place of a group of keys in the file; its path is built only for faults.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scope {
    pub section: &'static str,
    pub index: Option<usize>,
}

impl Scope {
    /// The outermost group.
    pub const ROOT: Self = Self::section("");

    /// The group behind a key of the outermost one.
    pub const fn section(section: &'static str) -> Self {
        Self { section, index: None }
    }

    /// One entry of a list.
    pub const fn item(section: &'static str, index: usize) -> Self {
        Self { section, index: Some(index) }
    }

    /// The path of the group itself.
    pub fn path(self) -> String {
        match self.index {
            Some(index) => format!("{}[{index}]", self.section),
            None => self.section.to_owned(),
        }
    }

    /// The path of a key of the group.
    pub fn key(self, key: &str) -> String {
        match self.path() {
            path if path.is_empty() => key.to_owned(),
            path => format!("{path}.{key}"),
        }
    }
}

pub(crate) fn positive(v: f64) -> bool {
    v > 0.0 && v.is_finite()
}

pub(crate) fn not_negative(v: f64) -> bool {
    v >= 0.0 && v.is_finite()
}

/// What is wrong with the value of `key`, and the cure, as the error of a scene file says it; `None` if it keeps the rule.
#[must_use]
pub fn broken(key: &str, value: f64, Rule { holds, noun, cure }: Rule) -> Option<String> {
    (!holds(value)).then(|| format!("{key}: {} is not {noun}; {cure}", shown(value)))
}

/// A vector as the file has it.
pub(crate) fn shown_vector(v: DVec3) -> String {
    format!("({})", v.to_array().map(shown).join(", "))
}

impl Faults {
    /// A number, or `default` where none is given.
    pub fn number(
        &mut self,
        scope: Scope,
        key: &str,
        value: Option<f64>,
        default: f64,
        Rule { holds, noun, cure }: Rule,
    ) -> f64 {
        match value {
            Some(v) if !holds(v) => {
                self.refuse(scope, key, format!("{} is not {noun}", shown(v)), cure);
                default
            }
            Some(v) => v,
            None => default,
        }
    }

    /// Records what is wrong with a key.
    pub fn refuse(
        &mut self,
        scope: Scope,
        key: &str,
        what: impl Into<String>,
        cure: impl Into<String>,
    ) {
        self.add(scope.key(key), what, cure);
    }

    /// A number where one is given.
    pub fn optional(
        &mut self,
        scope: Scope,
        key: &str,
        value: Option<f64>,
        rule: Rule,
    ) -> Option<f64> {
        value.map(|_| self.number(scope, key, value, 0.0, rule))
    }

    /// Three finite numbers, or `default` where none are given.
    pub fn vector(
        &mut self,
        scope: Scope,
        key: &str,
        value: Option<Triple>,
        default: DVec3,
    ) -> DVec3 {
        let v = value.map_or(default, DVec3::from_array);
        if v.is_finite() {
            return v;
        }
        self.refuse(
            scope,
            key,
            format!("{} is not finite", shown_vector(v)),
            "give three finite numbers",
        );
        default
    }

    /// A color, or white.
    pub fn color(&mut self, scope: Scope, value: Option<Triple>) -> [f32; 3] {
        self.color_to(scope, value, BodySpec::DEFAULT.color, 1.0, "from 0 to 1")
    }

    /// A color, or `default` where none is given; `largest` is the limit of each part, and `range` says so.
    pub fn color_to(
        &mut self,
        scope: Scope,
        value: Option<Triple>,
        default: [f32; 3],
        largest: f64,
        range: &str,
    ) -> [f32; 3] {
        let Some(parts) = value else { return default };
        if parts.iter().all(|part| (0.0..=largest).contains(part)) {
            return parts.map(|part| part as f32);
        }
        let what = format!("{} is not a color", shown_vector(DVec3::from_array(parts)));
        self.refuse(scope, "color", what, format!("give red, green and blue, each {range}"));
        default
    }

    /// One of a few words, or `default` where none is given.
    pub fn word<T: Copy>(
        &mut self,
        scope: Scope,
        key: &str,
        value: Option<&Word>,
        default: T,
        known: &[(&str, T)],
    ) -> T {
        let Some(Word(word)) = value else { return default };
        if let Some((_, meaning)) = known.iter().find(|(name, _)| name == word) {
            return *meaning;
        }
        let words: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        self.refuse(
            scope,
            key,
            format!("unknown word `{word}`"),
            format!("give {}", one_of(&words)),
        );
        default
    }

    /// A method of integration, where one is given.
    pub fn method(&mut self, scope: Scope, value: Option<&Word>) -> Option<Method> {
        let known = Method::ALL.map(|method| (method.name(), Some(method)));
        self.word(scope, "method", value, None, &known)
    }

    /// Substeps, where they are given.
    pub fn substeps(&mut self, scope: Scope, value: Option<Substepping>) -> Option<Substepping> {
        self.substeps_of(scope, "substeps", value?)
    }

    /// A number of substeps under any key, if one is given.
    pub fn count_of_substeps(
        &mut self,
        scope: Scope,
        key: &str,
        value: Option<u32>,
    ) -> Option<u32> {
        self.substeps_of(scope, key, value?.into()).map(Substepping::least)
    }

    fn substeps_of(
        &mut self,
        scope: Scope,
        key: &str,
        substeps: Substepping,
    ) -> Option<Substepping> {
        let Some((what, cure)) = substeps.fault() else { return Some(substeps) };
        self.refuse(scope, key, what, cure);
        None
    }

    /// Records that the group at `path` lacks a required key.
    pub fn missing(&mut self, path: String, key: &str, cure: &str) {
        self.add(path, format!("`{key}` is missing"), cure);
    }

    /// Records that a key is missing, if it is not `given`.
    pub fn require(&mut self, given: bool, scope: Scope, key: &str, cure: &str) {
        if !given {
            self.missing(scope.path(), key, cure);
        }
    }

    /// The reciprocal of the mass of each of `bodies`, 1/kg. `mass` is the mass of all bodies together; `default` if
    /// it is missing.
    pub fn inverse_mass(
        &mut self,
        scope: Scope,
        mass: Option<f64>,
        default: f64,
        bodies: f64,
        cure: &str,
    ) -> f64 {
        let given = mass.unwrap_or(default);
        if positive(given) && (bodies / given).is_finite() {
            return bodies / given;
        }
        self.refuse(scope, "mass_kg", format!("{} is not a mass", shown(given)), cure);
        bodies / default
    }
}
