//! The keys, lists and names of the program's texts as people say them.

use motion::Method;

/// Endings of keys that have a unit, longer ones first, and the unit.
const UNITS: [(&str, &str); 19] = [
    ("_m3_kg_s2", "m³/(kg s²)"),
    ("_m3_s2", "m³/s²"),
    ("_m_s2", "m/s²"),
    ("_n_s_m", "N s/m"),
    ("_m_s", "m/s"),
    ("_n_m", "N/m"),
    ("_rad_s", "rad/s"),
    ("_per_s", "1/s"),
    ("_per_m", "1/m"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_kg_s", "kg/s"),
    ("_kg_m", "kg/m"),
    ("_m2", "m²"),
    ("_kg", "kg"),
    ("_hz", "Hz"),
    ("_m", "m"),
    ("_s", "s"),
    ("_n", "N"),
];

/// A key without its unit, in words, and the unit.
pub(crate) fn label(key: &str) -> (String, &'static str) {
    match key {
        "step_hz" => return ("ticks per second".to_owned(), ""),
        "step" => return ("kind of tick".to_owned(), ""),
        _ => {}
    }
    let unit = UNITS.iter().find_map(|(end, unit)| Some((key.strip_suffix(end)?, *unit)));
    let (words, unit) = unit.filter(|(words, _)| !words.is_empty()).unwrap_or((key, ""));
    (words.replace('_', " "), unit)
}

/// The text with the names of methods in it as titles: `runge_kutta_4` is "Runge-Kutta 4".
pub(crate) fn with_titles(text: &str) -> String {
    by_word(text, str::to_owned)
}

/// The text with keys, paths and methods in it as people say them: `wells[0], line 13` is "well 1". Not for texts with names
/// that people gave.
pub(crate) fn plain(text: &str) -> String {
    let mut parts = text.split(", line ");
    let first = parts.next().unwrap_or_default().to_owned();
    let text = parts.fold(first, |text, part| {
        let rest = part.trim_start_matches(|c: char| c.is_ascii_digit());
        if rest.len() < part.len() { text + rest } else { text + ", line " + part }
    });
    by_word(&text, |name| match name.strip_prefix("--") {
        Some(flag) => flag.replace('-', " "),
        None if name.contains('[') => name.split('.').map(place).collect::<Vec<_>>().join(" "),
        None => name.replace('_', " "),
    })
}

/// The text with methods as titles, and its other words by `other`.
fn by_word(text: &str, other: impl Fn(&str) -> String) -> String {
    let plain = |word: &str| {
        let name = word.trim_end_matches([',', ';', ':', '.']);
        let method = Method::ALL.into_iter().find(|method| method.name() == name);
        let said = method.map_or_else(|| other(name), |method| method.claims().title.to_owned());
        said + &word[name.len()..]
    };
    text.split(' ').map(plain).collect::<Vec<_>>().join(" ")
}

/// A part of a path, such as `soft_bodies[0]` or `drag_area_m2`.
fn place(part: &str) -> String {
    let Some((list, number)) = part.split_once('[') else { return label(part).0 };
    let number: usize = number.trim_end_matches(']').parse().unwrap_or_default();
    let one = match list.strip_suffix("ies") {
        Some(stem) => format!("{stem}y"),
        None => list.trim_end_matches('s').to_owned(),
    };
    format!("{} {}", one.replace('_', " "), number + 1)
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn names_are_said_as_people_say_them() {
        for (text, words) in [
            ("wells[0], line 13", "well 1"),
            ("soft_bodies[2], line 7, and more", "soft body 3, and more"),
            ("bodies[1].drag_area_m2, line 17", "body 2 drag area"),
            ("method: runge_kutta_4 or yoshida_4", "method: Runge-Kutta 4 or Yoshida 4"),
            ("mutual_gravity", "mutual gravity"),
            ("going back: the window, --black-box", "going back: the window, black box"),
            ("in a row, line up", "in a row, line up"),
        ] {
            assert_eq!(plain(text), words);
        }
    }
}
