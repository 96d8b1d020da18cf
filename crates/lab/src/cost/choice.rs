//! What is cheapest at an error. Sentences, tables, buttons and recommendations all ask [`Study::cheapest`].

use motion::Method;

use super::front::{Accuracy, Cost};
use super::record::{Cell, Host, Study};

/// Counts that differ by less than this part are equal: the single evaluation with which some methods start is not what one
/// chooses by.
const EVEN: f64 = 0.03;

/// Steps at which an error exceeds this part of the motion are too coarse for anything.
const USABLE: f64 = 0.1;

/// Bounds that are answered, at most, a decade each.
const DECADES: i32 = 6;

/// The cheapest setting for an error.
#[derive(Clone, Debug, PartialEq)]
pub struct Cheapest<'a> {
    /// It.
    pub cell: &'a Cell,
    /// The best setting of each other method that costs the same, the most accurate first: counts that differ by less than
    /// 3 %, or times that differ by no more than the spread of their rounds.
    pub ties: Vec<&'a Cell>,
}

impl Cheapest<'_> {
    /// The methods, the cheapest first.
    pub fn methods(&self) -> Vec<Method> {
        [self.cell].iter().chain(&self.ties).map(|cell| cell.setting.method).collect()
    }
}

/// The answer to "which setting, for a position error of at most this".
#[derive(Clone, Debug, PartialEq)]
pub struct Answer<'a> {
    /// The bound, m.
    pub below_m: f64,
    /// By the cost that was asked for.
    pub cheapest: Cheapest<'a>,
}

impl Study {
    /// The cheapest setting of f64 whose error is at most `error`, the truth's own added to it; `None` if none was
    /// measured.
    pub fn cheapest(&self, accuracy: Accuracy, cost: Cost, error: f64) -> Option<Cheapest<'_>> {
        let keeps = |cell: &Cell| self.promised(cell, accuracy).is_some_and(|promised| promised <= error);
        let cell = self.front(accuracy, cost).into_iter().find(|cell| keeps(cell))?;
        let least = self.cost(cell, cost)?;
        let own = cell.setting.method;
        let mut ties: Vec<&Cell> = Vec::new();
        for other in self.in_double().filter(|other| keeps(other)) {
            let method = other.setting.method;
            let most = least * (1.0 + self.tie(cost, [own, method]));
            if method == own || self.cost(other, cost).is_none_or(|price| price > most) {
                continue;
            }
            match ties.iter_mut().find(|tied| tied.setting.method == method) {
                Some(tied) if self.error(other, accuracy) < self.error(tied, accuracy) => *tied = other,
                Some(_) => {}
                None => ties.push(other),
            }
        }
        let error = |cell: &Cell| self.error(cell, accuracy).unwrap_or(f64::INFINITY);
        ties.sort_by(|a, b| error(a).total_cmp(&error(b)));
        Some(Cheapest { cell, ties })
    }

    /// The largest error that a cell may have: what was measured, and the truth's own.
    pub fn promised(&self, cell: &Cell, accuracy: Accuracy) -> Option<f64> {
        let (relative, position_m) = self.truth.own_error();
        let own = match accuracy {
            Accuracy::Relative => relative,
            Accuracy::Position => position_m,
            Accuracy::Velocity => relative * self.velocity_scale_m_s,
        };
        Some(self.error(cell, accuracy)? + own)
    }

    /// Part by which the costs of two methods may differ and are equal: of times, the spread of their rounds.
    fn tie(&self, cost: Cost, methods: [Method; 2]) -> f64 {
        match cost {
            Cost::Evaluations | Cost::Instructions => EVEN,
            Cost::Time | Cost::RealTime => self.largest_spread(methods, Host::World),
            Cost::Arithmetic => self.largest_spread(methods, Host::Arithmetic),
        }
    }

    /// Whether the positions of a run that went through are near enough to the truth to be of use.
    pub fn is_usable(&self, cell: &Cell) -> bool {
        cell.errors().is_some_and(|errors| errors.position_m <= USABLE * self.position_scale_m)
    }

    /// Whether the truth itself is too uncertain to tell usable runs apart.
    pub fn is_uncertain(&self) -> bool {
        let (_, own_m) = self.truth.own_error();
        own_m.is_nan() || 10.0 * own_m > USABLE * self.position_scale_m
    }

    /// A position error, or the noise floor where it is below that, m.
    fn resolved(&self, cell: &Cell) -> Option<f64> {
        let accuracy = Accuracy::Position;
        Some(self.error(cell, accuracy)?.max(self.trusted(cell, accuracy)))
    }

    /// The cheapest settings for position errors of powers of ten, from the largest that is of use down to what was
    /// reached, six at most.
    pub fn answers(&self, cost: Cost) -> Vec<Answer<'_>> {
        let usable = || self.in_double().filter(|cell| self.is_usable(cell));
        let errors = || usable().filter_map(|cell| self.resolved(cell));
        let (largest, least) = (errors().fold(0.0, f64::max), errors().fold(f64::INFINITY, f64::min));
        if largest <= 0.0 {
            return Vec::new();
        }
        let start = largest.log10().ceil() as i32;
        // Not by powi: 10^-3 is to be the number that is written 0.001.
        let bounds = (0..DECADES).filter_map(|down| format!("1e{}", start - down).parse::<f64>().ok());
        let answer = |below_m: f64| {
            let cheapest = self.cheapest(Accuracy::Position, cost, below_m)?;
            Some(Answer { below_m, cheapest })
        };
        bounds.filter(|below_m| *below_m >= least).filter_map(answer).collect()
    }

    /// Methods whose every setting another one beats clearly in error or cost, and does not lose to in the other.
    pub fn never_best(&self, cost: Cost) -> Vec<Method> {
        let points: Vec<_> = self
            .in_double()
            .filter_map(|cell| Some((cell, self.cost(cell, cost)?, self.resolved(cell)?)))
            .collect();
        let beats = |(cell, price, error): &(&Cell, f64, f64),
                     (other, other_price, other_error): &(&Cell, f64, f64)| {
            let more = 1.0 + self.tie(cost, [cell.setting.method, other.setting.method]);
            (price * more < *other_price && *error <= other_error * (1.0 + EVEN))
                || (error * (1.0 + EVEN) < *other_error && *price <= other_price * more)
        };
        let stands = |point: &&(&Cell, f64, f64)| {
            self.is_usable(point.0) && !points.iter().any(|other| beats(other, point))
        };
        let never = |method: &Method| {
            let mut own = points.iter().filter(|(cell, ..)| cell.setting.method == *method).peekable();
            own.peek().is_some() && own.find(stands).is_none()
        };
        Method::ALL.into_iter().filter(never).collect()
    }
}
