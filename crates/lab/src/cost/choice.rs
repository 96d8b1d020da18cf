//! Finds the cheapest setting for an error. Sentences, tables, buttons and recommendations all ask
//! [`Study::cheapest`].

use motion::Method;

use super::front::{Accuracy, Cost};
use super::record::{Cell, Host, Setting, Study};

/// Counts that differ by less than this part are equal: the single start-up evaluation of some methods does not
/// decide a choice.
const EVEN: f64 = 0.03;

/// A change of the setting is worthwhile if it makes the error at least this many times smaller.
const WORTH: f64 = 1.5;

/// Steps at which the error exceeds this part of the motion are too coarse to use.
const USABLE: f64 = 0.1;

/// Most error bounds in a list of answers, one per decade.
const DECADES: i32 = 6;

/// The cheapest setting for an error.
#[derive(Clone, Debug, PartialEq)]
pub struct Cheapest<'a> {
    /// The cell of the setting.
    pub cell: &'a Cell,
    /// The best setting of each other method that costs the same, the most accurate first: counts that differ by less than
    /// 3 %, or times that differ by no more than the spread of their passes.
    pub ties: Vec<&'a Cell>,
}

impl<'a> Cheapest<'a> {
    /// The cells, the cheapest first.
    pub fn cells(&self) -> impl Iterator<Item = &'a Cell> {
        std::iter::once(self.cell).chain(self.ties.iter().copied())
    }

    /// The methods, the cheapest first.
    pub fn methods(&self) -> Vec<Method> {
        self.cells().map(|cell| cell.setting.method).collect()
    }
}

/// The cheapest setting for a bound on the position error.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer<'a> {
    /// The bound, m.
    pub below_m: f64,
    /// The cheapest setting by the cost that was asked for.
    pub cheapest: Cheapest<'a>,
}

/// The methods that are the cheapest for successive bounds on the position error.
#[derive(Clone, Debug, PartialEq)]
pub struct Lead {
    /// The methods, which tie if there are several.
    pub methods: Vec<Method>,
    /// The smallest bound for which they are the cheapest, m.
    pub below_m: f64,
    /// Whether the errors of all of them are below the noise floor at every step.
    pub are_exact: bool,
}

/// The cheapest settings for one bound on the error, by every cost that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice<'a> {
    /// The bound, m.
    pub below_m: f64,
    /// By evaluations.
    pub by_evaluations: Cheapest<'a>,
    /// By time.
    pub by_time: Option<Cheapest<'a>>,
    /// By the time of the arithmetic alone.
    pub by_arithmetic: Option<Cheapest<'a>>,
}

impl Choice<'_> {
    fn settings(&self) -> [Option<Vec<Setting>>; 3] {
        let all = [Some(&self.by_evaluations), self.by_time.as_ref(), self.by_arithmetic.as_ref()];
        all.map(|cheapest| Some(cheapest?.cells().map(|cell| cell.setting).collect()))
    }
}

/// Joins successive answers with the same methods.
fn leads(study: &Study, answers: &[Answer<'_>]) -> Vec<Lead> {
    let methods = |answer: &Answer<'_>| answer.cheapest.methods();
    let lead = |same: &[Answer<'_>]| {
        let last = same.last()?;
        let methods = methods(last);
        let are_exact = methods.iter().all(|method| study.is_exact(*method));
        Some(Lead { methods, below_m: last.below_m, are_exact })
    };
    answers.chunk_by(|a, b| methods(a) == methods(b)).filter_map(lead).collect()
}

impl Study {
    /// The cheapest setting whose error, with the truth's own error added, is at most `error`; `None` if none was
    /// measured.
    pub fn cheapest(&self, accuracy: Accuracy, cost: Cost, error: f64) -> Option<Cheapest<'_>> {
        let keeps = |cell: &Cell| {
            self.error_bound(cell, accuracy).is_some_and(|promised| promised <= error)
        };
        // The front is in the order of costs.
        let cell = self.front(accuracy, cost).into_iter().find(|cell| keeps(cell))?;
        let least = self.cost(cell, cost)?;
        let own = cell.setting.method;
        let mut ties: Vec<&Cell> = Vec::new();
        for other in self.cells.iter().filter(|other| keeps(other)) {
            let method = other.setting.method;
            let most = least * (1.0 + self.tie(cost, [own, method]));
            if method == own || self.cost(other, cost).is_none_or(|price| price > most) {
                continue;
            }
            match ties.iter_mut().find(|tied| tied.setting.method == method) {
                Some(tied) if self.error(other, accuracy) < self.error(tied, accuracy) => {
                    *tied = other;
                }
                Some(_) => {}
                None => ties.push(other),
            }
        }
        let error_of = |cell: &Cell| self.error(cell, accuracy).unwrap_or(f64::INFINITY);
        ties.sort_by(|a, b| error_of(a).total_cmp(&error_of(b)));
        Some(Cheapest { cell, ties })
    }

    /// The most accurate cell that costs no more than `present`, and how many times smaller its error is, with the
    /// truth's own error added to it; `None` if it is less than 1.5 times smaller.
    pub fn better_at_cost_of(
        &self,
        present: &Cell,
        accuracy: Accuracy,
        cost: Cost,
    ) -> Option<(&Cell, f64)> {
        let (price, error) = (self.cost(present, cost)?, self.error(present, accuracy)?);
        let own = present.setting.method;
        let is_affordable = |cell: &&Cell| {
            let most = price * (1.0 + self.tie(cost, [own, cell.setting.method]));
            self.cost(cell, cost).is_some_and(|other| other <= most)
        };
        let with_error = |cell| Some((cell, self.error_bound(cell, accuracy)?));
        let errors = self.cells.iter().filter(is_affordable).filter_map(with_error);
        let (cell, least) = errors.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let times = error / least;
        (times >= WORTH).then_some((cell, times))
    }

    /// Whether substeps do little for most methods: their error at the most substeps is above half of that at the fewest.
    pub fn is_flat(&self, accuracy: Accuracy) -> bool {
        let ends = |method: &Method| {
            let mut errors = self.curve(*method).filter_map(|cell| self.error(cell, accuracy));
            let first = errors.next()?;
            Some((first, errors.last()?))
        };
        let methods: Vec<_> = Method::ALL.iter().filter_map(ends).collect();
        let flat =
            methods.iter().filter(|(first, last)| *first > 0.0 && *last > 0.5 * first).count();
        2 * flat > methods.len()
    }

    /// Bound on the error of a cell: its measured error plus the truth's own error.
    pub fn error_bound(&self, cell: &Cell, accuracy: Accuracy) -> Option<f64> {
        let (relative, position_m) = self.truth.own_error();
        let own = match accuracy {
            Accuracy::Relative => relative,
            Accuracy::Position => position_m,
            Accuracy::Velocity => relative * self.velocity_scale_m_s,
        };
        Some(self.error(cell, accuracy)? + own)
    }

    /// Relative difference up to which the costs of two methods are equal: for times, the spread of their passes.
    fn tie(&self, cost: Cost, methods: [Method; 2]) -> f64 {
        match cost {
            Cost::Evaluations => EVEN,
            Cost::Time | Cost::RealTime => self.largest_spread(methods, Host::World),
            Cost::Arithmetic => self.largest_spread(methods, Host::Arithmetic),
        }
    }

    /// Whether a run finished with positions near enough to the truth to be of use.
    pub fn is_usable(&self, cell: &Cell) -> bool {
        cell.errors().is_some_and(|errors| errors.position_m <= USABLE * self.position_scale_m)
    }

    /// Whether the truth itself is too uncertain to tell usable runs apart.
    pub fn is_uncertain(&self) -> bool {
        let (_, own_m) = self.truth.own_error();
        own_m.is_nan() || 10.0 * own_m > USABLE * self.position_scale_m
    }

    /// The position error of a cell, or the noise floor if that is larger, m.
    fn resolved(&self, cell: &Cell) -> Option<f64> {
        let accuracy = Accuracy::Position;
        Some(self.error(cell, accuracy)?.max(self.trusted(cell, accuracy)))
    }

    /// The cheapest settings for position errors of powers of ten, from the largest usable error down to the smallest
    /// that was reached, six at most. Empty if methods cannot be ranked.
    pub fn answers(&self, cost: Cost) -> Vec<Answer<'_>> {
        if !self.ranks() {
            return Vec::new();
        }
        let usable = || self.cells.iter().filter(|cell| self.is_usable(cell));
        let errors = || usable().filter_map(|cell| self.resolved(cell));
        let (largest, least) =
            (errors().fold(0.0, f64::max), errors().fold(f64::INFINITY, f64::min));
        if largest <= 0.0 {
            return Vec::new();
        }
        let start = largest.log10().ceil() as i32;
        // Parsed, because `powi` may not give exactly the number that is written 0.001.
        let bounds =
            (0..DECADES).filter_map(|down| format!("1e{}", start - down).parse::<f64>().ok());
        let answer = |below_m: f64| {
            let cheapest = self.cheapest(Accuracy::Position, cost, below_m)?;
            Some(Answer { below_m, cheapest })
        };
        bounds.filter(|below_m| *below_m >= least).filter_map(answer).collect()
    }

    /// The cheapest methods, each group with the smallest error for which it is the cheapest.
    pub fn leads(&self, cost: Cost) -> Vec<Lead> {
        leads(self, &self.answers(cost))
    }

    /// The leads by time with [`Self::size`] bodies, and with each other size whose cheapest methods differ from those and
    /// from those of the size before; empty if nothing was timed.
    pub fn leads_by_size(&self) -> Vec<(usize, Vec<Lead>)> {
        let methods = |answers: &[Answer<'_>]| -> Vec<_> {
            answers.iter().map(|answer| answer.cheapest.methods()).collect()
        };
        let answers = self.answers(Cost::Time);
        let here = methods(&answers);
        if here.is_empty() {
            return Vec::new();
        }
        let mut found = vec![(self.size(), leads(self, &answers))];
        let mut last = here.clone();
        for size in self.sizes().into_iter().filter(|size| *size != self.size()) {
            let study = self.at_size(size);
            let answers = study.answers(Cost::Time);
            let there = methods(&answers);
            if there != here && there != last {
                found.push((size, leads(&study, &answers)));
            }
            last = there;
        }
        found
    }

    /// The cheapest settings for each error by evaluations, by time and by the arithmetic alone, the largest error
    /// first. Only the smallest of several errors with the same settings is listed.
    pub fn choices<'a>(&'a self) -> Vec<Choice<'a>> {
        let [by_evaluations, by_time, by_arithmetic] =
            [Cost::Evaluations, Cost::Time, Cost::Arithmetic].map(|cost| self.answers(cost));
        let at = |answers: &[Answer<'a>], below_m: f64| {
            let of_bound = |answer: &&Answer<'a>| answer.below_m.to_bits() == below_m.to_bits();
            answers.iter().find(of_bound).map(|answer| answer.cheapest.clone())
        };
        let choice = |Answer { below_m, cheapest }: Answer<'a>| Choice {
            below_m,
            by_evaluations: cheapest,
            by_time: at(&by_time, below_m),
            by_arithmetic: at(&by_arithmetic, below_m),
        };
        let choices: Vec<_> = by_evaluations.into_iter().map(choice).collect();
        let same = choices.chunk_by(|a, b| a.settings() == b.settings());
        same.filter_map(|same| same.last().cloned()).collect()
    }

    /// Methods that are among the cheapest for some error, ties included, in the order of the table; `None` if no error is
    /// usable.
    pub fn ever_cheapest(&self, cost: Cost) -> Option<Vec<Method>> {
        let answers = self.answers(cost);
        let cheapest: Vec<_> =
            answers.iter().flat_map(|answer| answer.cheapest.methods()).collect();
        (!answers.is_empty())
            .then(|| Method::ALL.into_iter().filter(|method| cheapest.contains(method)).collect())
    }
}
