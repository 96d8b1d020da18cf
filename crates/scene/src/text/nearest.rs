//! Suggestions: the known word that a misspelled one was probably meant to be.

use std::fmt::Display;

/// Similarity from which a word is worth suggesting: high enough that `springs` is not taken for `push`, low
/// enough that a forgotten unit (`mass` for `mass_kg`) is seen.
const SIMILAR: f64 = 0.8;

/// The known word nearest to `word`, if any is near (Jaro and Winkler 1990). Among the near ones, a candidate that begins with
/// `word` always wins: `runge_kutta_2` means `runge_kutta_2_heun`, not `runge_kutta_4` with a typo.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let rated =
        known.into_iter().map(|candidate| (strsim::jaro_winkler(word, candidate), candidate));
    let near = rated.filter(|(similarity, _)| *similarity >= SIMILAR);
    let best = near.max_by(|(a, one), (b, other)| {
        one.starts_with(word).cmp(&other.starts_with(word)).then(a.total_cmp(b))
    });
    best.map(|(_, candidate)| candidate)
}

/// A guess at what was meant, before the rest of a cure; empty for none.
#[must_use]
pub fn did_you_mean(near: Option<impl Display>) -> String {
    near.map(|near| format!("did you mean {near}? ")).unwrap_or_default()
}

/// The cure for an unknown word: the nearest known one, or all of them.
pub(crate) fn suggest(word: &str, known: &[&str]) -> String {
    match nearest(word, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("known here: {}", known.join(", ")),
    }
}

/// `a, b or c`.
pub(crate) fn one_of(known: &[&str]) -> String {
    match known {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typo_and_a_forgotten_unit_find_their_key_and_another_word_finds_none() {
        let known = ["name", "position_m", "velocity_m_s", "mass_kg", "color"];
        assert_eq!(suggest("posititon_m", &known), "did you mean `position_m`?");
        assert_eq!(suggest("mass", &known), "did you mean `mass_kg`?");
        assert_eq!(suggest("wobble", &known), format!("known here: {}", known.join(", ")));
        assert_eq!(one_of(&["x", "y", "z"]), "x, y or z");
        let known = ["runge_kutta_2_heun", "runge_kutta_4"];
        assert_eq!(nearest("runge_kutta_2", known), Some(known[0]));
        assert_eq!(nearest("runge_kuta_4", known), Some(known[1]));
    }
}
