//! Fields for numbers: they show what is, and only what a person types or drags changes it.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use egui::emath::Numeric;
use egui::{Context, DragValue, Id, Response, Ui};
use report::numbers::rounded;
use scene::{Rule, broken};

/// Most characters of a number that a field shows with all of its digits.
const LONGEST: usize = 9;

/// Lays out a field for a number that only this field changes: while the person types, and by `speed` per point of a drag.
pub(crate) fn number_field(ui: &mut Ui, number: &mut f64, speed: f64, suffix: &str) -> Response {
    let all = f64::NEG_INFINITY..=f64::INFINITY;
    let what = "a number; type one such as 0.75 or 2e-3";
    field(ui, number, all, what, speed, suffix, read_number)
}

/// Lays out a field for a whole number within `range`, as [`number_field`] does.
pub(crate) fn count_field<N: Numeric>(
    ui: &mut Ui,
    count: &mut N,
    range: RangeInclusive<f64>,
    suffix: &str,
) -> Response {
    let what = format!("a whole number from {} to {}", range.start(), range.end());
    let is_count = |number: &f64| number.fract() == 0.0 && range.contains(number);
    // In a count a comma may stand between thousands.
    let read = |text: &str| read_number(text).filter(is_count).filter(|_| !text.contains(','));
    field(ui, count, range.clone(), &what, 0.1, suffix, read)
}

/// A field for a number of that range and description.
fn field<N: Numeric>(
    ui: &mut Ui,
    number: &mut N,
    range: RangeInclusive<f64>,
    what: &str,
    speed: f64,
    suffix: &str,
    read: impl Fn(&str) -> Option<f64>,
) -> Response {
    let (typing, before) = (types_into(ui, ui.next_auto_id()), number.to_f64());
    let unread = RefCell::new(None);
    // egui reads the shown text even if nothing was typed: the number then keeps all of its digits.
    let read = |text: &str| {
        let number = if text == shown(before) { Some(before) } else { read(text) };
        let is_wrong = number.is_none() && !typing && !text.trim().is_empty();
        *unread.borrow_mut() = is_wrong.then(|| format!("{:?} is not {what}", text.trim()));
        number
    };
    let field = DragValue::new(number)
        .speed(speed)
        .suffix(suffix)
        .range(N::from_f64(*range.start())..=N::from_f64(*range.end()))
        .clamp_existing_to_range(false)
        .custom_formatter(|number, _| shown(number))
        .custom_parser(read);
    let response = ui.add(field);
    if let Some(text) = unread.into_inner() {
        ui.data_mut(|data| data.insert_temp(Id::NULL, Unread(text)));
    }
    response
}

/// Lays out a field for `present`, the value of `key`, which may change while the person types: egui would drop what was typed.
/// Returns the number that the person asks for, or what is wrong with it once it is typed.
pub(crate) fn value_field(
    ui: &mut Ui,
    key: &str,
    rule: Rule,
    present: f64,
    speed: f64,
    suffix: &str,
) -> Option<Result<f64, String>> {
    let id = ui.next_auto_id();
    let kept = id.with("number");
    let before = ui.data_mut(|data| data.remove_temp(kept)).unwrap_or(present);
    let mut number = before;
    number_field(ui, &mut number, speed, suffix);
    let typing = types_into(ui, id);
    if typing {
        ui.data_mut(|data| data.insert_temp(kept, number));
    }
    let is_changed = number.to_bits() != before.to_bits();
    match broken(key, number, rule) {
        None => is_changed.then_some(Ok(number)),
        Some(fault) => (!typing && number.to_bits() != present.to_bits()).then_some(Err(fault)),
    }
}

fn types_into(ui: &Ui, id: Id) -> bool {
    ui.memory(|memory| memory.has_focus(id))
}

/// The refusal of what was typed into a field.
#[derive(Clone, Default)]
struct Unread(String);

/// The refusal of what was typed into a field of the last layout, if it cannot be its value.
pub(crate) fn refusal(context: &Context) -> Option<String> {
    let Unread(refusal) = context.data_mut(|data| data.remove_temp(Id::NULL))?;
    Some(refusal)
}

/// Reads a number as people type it: with a point or a comma before its decimals, and with blanks.
pub(crate) fn read_number(text: &str) -> Option<f64> {
    let text: String = text.split_whitespace().collect();
    text.replace(',', ".").replace('\u{2212}', "-").parse().ok()
}

/// A number as its field shows it: with six digits where it has many more, so that three of them fit into the dock.
fn shown(number: f64) -> String {
    let mut words = format!("{number:?}");
    if words.len() > LONGEST {
        words = format!("{:?}", rounded(number, 6));
    }
    words.strip_suffix(".0").map_or(words.clone(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_of_many_digits_is_shown_with_six() {
        for (number, text) in [
            (34.800_000_000_000_004, "34.8"),
            (-20.943_951_023_931_955, "-20.944"),
            (0.123_456_789_1, "0.123457"),
            (1e-20, "1e-20"),
            (1_234_567.0, "1234567"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(shown(number), text);
        }
    }

    #[test]
    fn decimals_follow_a_point_or_a_comma() {
        for (text, number) in [
            ("0,75", Some(0.75)),
            (" -1.5e3 ", Some(-1500.0)),
            ("\u{2212}2", Some(-2.0)),
            ("1 000", Some(1000.0)),
            ("1,2,3", None),
            ("ten", None),
        ] {
            assert_eq!(read_number(text), number, "{text}");
        }
    }
}
