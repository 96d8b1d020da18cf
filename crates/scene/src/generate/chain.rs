//! Chains: points in a line, each joined to the next.

use glam::DVec3;

use super::soft::{Form, part, pinned, points, within_numbers};
use crate::check::Scope;
use crate::raw::coupled::RawSoftKeys;
use crate::scene::coupled::SoftKind;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    First,
    Last,
}

/// A checked chain.
pub(super) struct Chain {
    points: u32,
    from: DVec3,
    to: DVec3,
    pinned: Vec<End>,
}

impl Chain {
    pub fn resolve(keys: &RawSoftKeys, scope: Scope, faults: &mut Faults) -> Self {
        let from = faults.vector((scope, "from_m"), keys.from_m, DVec3::ZERO);
        if keys.to_m.is_none() {
            faults.missing(scope.path(), "to_m", "say where the chain ends");
        }
        let to = faults.vector((scope, "to_m"), keys.to_m, from + DVec3::X);
        if from == to || !within_numbers(&[from, to, to - from]) {
            let cure = "give a place other than from_m, within 1e150 m";
            faults.add(scope.key("to_m"), "a chain cannot reach from there to there", cure);
        }
        let ends = [("first", End::First), ("last", End::Last)];
        Self {
            points: points(keys.points, (scope, "points"), faults),
            from,
            to,
            pinned: pinned(keys, &ends, scope, faults),
        }
    }
}

impl Form for Chain {
    fn kind(&self) -> SoftKind {
        SoftKind::Chain
    }

    fn count(&self) -> u64 {
        u64::from(self.points)
    }

    fn springs(&self) -> u64 {
        self.count().saturating_sub(1)
    }

    fn numbering(&self) -> Numbering {
        Numbering::Line
    }

    fn position(&self, point: u32) -> DVec3 {
        self.from + (self.to - self.from) * part(point, self.points)
    }

    fn pinned(&self, point: u32) -> bool {
        self.pinned.iter().any(|end| match end {
            End::First => point == 0,
            End::Last => point + 1 == self.points,
        })
    }

    fn pairs(&self) -> Vec<[u32; 2]> {
        (1..self.points).map(|point| [point - 1, point]).collect()
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        Vec::new()
    }
}
