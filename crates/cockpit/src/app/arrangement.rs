//! Saves the arrangement of the panels as text, and restores it.

use std::collections::{BTreeMap, BTreeSet};

use crate::actions::Act;
use crate::app::ui::Ui;
use crate::panels::{PANELS, Tab};
use crate::tools::learn::Learn;

const DOCK_WIDTH: &str = "dock_width";
const DOCK_TAB: &str = "dock_tab";
/// First word of a line that names a finished lesson.
const LESSON_DONE: &str = "lesson_done";

/// First word of a line that names a lesson that was left, and how many of its steps were done.
const LESSON_LEFT: &str = "lesson_left";

const WELCOME: &str = "welcome";

/// The line that shows the welcome card at the first start. It stays in the file until a window can show the card.
pub const FIRST_START: &str = "welcome on\n";

/// Limit of the counts of `larger` and `smaller`; higher ones are clamped.
const MOST_SIZES: isize = 10;

/// Writes the arrangement of the panels, one line per action and its state: `on`, `off`, or how many times it was done.
pub(crate) fn of(ui: &Ui, learn: &Learn) -> String {
    let is_chosen = |(act, _): &(Act, bool)| {
        (*act != Act::ToggleBrowser || ui.cockpit.scenes.is_chosen())
            && (*act != Act::ToggleDock || ui.cockpit.dock.is_chosen())
    };
    let switches = switches(ui).into_iter().filter(is_chosen);
    let mut text: String = switches
        .map(|(act, on)| format!("{} {}\n", act.name(), if on { "on" } else { "off" }))
        .collect();
    match ui.sizes_above_usual() {
        0 => {}
        up @ 1.. => text += &format!("larger {up}\n"),
        down => text += &format!("smaller {}\n", -down),
    }
    if ui.cockpit.tab != Tab::default() {
        text += &format!("{DOCK_TAB} {}\n", ui.cockpit.tab.words()[1]);
    }
    if let Some(points) = ui.cockpit.chosen_dock_width() {
        text += &format!("{DOCK_WIDTH} {points}\n");
    }
    text.extend(learn.done.iter().map(|name| format!("{LESSON_DONE} {name}\n")));
    text.extend(learn.left.iter().map(|(name, steps)| format!("{LESSON_LEFT} {name} {steps}\n")));
    text
}

/// Arranges the panels as `text` says, whatever panels or questions are open, and returns the actions that are still needed.
/// Ignores unknown lines. Shows the bars and the dock unless a line hides them.
pub(crate) fn arrange(ui: &mut Ui, learn: &mut Learn, text: &str) -> Vec<Act> {
    let states: Vec<_> = text.lines().filter_map(|line| line.split_once(' ')).collect();
    let state =
        |name: &str| states.iter().find(|(other, _)| *other == name).map(|(_, state)| *state);
    let count = |name: &str| {
        state(name).and_then(|count| count.parse().ok()).unwrap_or(0).clamp(0, MOST_SIZES)
    };
    let sizes: isize = count("larger") - count("smaller");
    for _ in 0..sizes.abs() {
        ui.zoom_by(sizes.signum());
    }
    learn.welcome = state(WELCOME) == Some("on");
    learn.done.extend(
        states.iter().filter(|(name, _)| *name == LESSON_DONE).map(|(_, name)| (*name).to_owned()),
    );
    let left = states.iter().filter(|(name, _)| *name == LESSON_LEFT).filter_map(|(_, lesson)| {
        let (name, steps) = lesson.rsplit_once(' ')?;
        Some((name.to_owned(), steps.parse().ok()?))
    });
    learn.left.extend(left);
    let mut acts = Vec::new();
    for (act, on) in switches(ui) {
        let wanted = match state(act.name()) {
            Some("on") => true,
            Some("off") => false,
            // The cockpit starts hidden, but no person hid it.
            _ if act == Act::ToggleCockpit => true,
            _ => continue,
        };
        if act == Act::ToggleBrowser {
            ui.cockpit.scenes.set(wanted);
        } else if wanted != on {
            acts.push(act);
        }
    }
    let tab =
        state(DOCK_TAB).and_then(|name| Tab::ALL.into_iter().find(|tab| tab.words()[1] == name));
    ui.cockpit.next_tab = tab;
    let dock_width = state(DOCK_WIDTH).and_then(|points| points.parse().ok());
    if let Some(points) = dock_width.filter(|points: &f64| points.is_finite() && *points > 0.0) {
        ui.cockpit.set_dock_width(points);
    }
    acts
}

/// Actions that switch something on and off, and whether it is on.
fn switches(ui: &Ui) -> Vec<(Act, bool)> {
    let parts = [(Act::ToggleCockpit, ui.cockpit.shown), (Act::ToggleTheme, ui.is_light())];
    let panels = PANELS.iter().map(|(panel, _)| *panel).filter(|panel| !panel.is_transient());
    let panels = panels.map(|panel| (Act::Panel(panel), ui.shows(panel)));
    // Last, because their lines are added once a person has chosen.
    let sides = [
        (Act::ToggleBrowser, ui.cockpit.scenes.is_open(ui.width())),
        (Act::ToggleDock, ui.cockpit.dock.is_open(ui.width())),
    ];
    parts.into_iter().chain(panels).chain(sides).collect()
}

/// The lines of `there`, with those replaced that differ between `before` and `now`: what another session changed meanwhile stays.
#[must_use]
pub fn with_changes(there: &str, before: &str, now: &str) -> String {
    // A key has one line, except that each lesson has its own.
    let key = |line: &'_ str| match line.split_once(' ') {
        Some((LESSON_LEFT, lesson)) => {
            let name = lesson.rsplit_once(' ').map_or(lesson, |(name, _)| name);
            format!("{LESSON_LEFT} {name}")
        }
        Some((key, _)) if key != LESSON_DONE => key.to_owned(),
        _ => line.to_owned(),
    };
    let only = |one: &str, other: &str| -> BTreeSet<String> {
        one.lines().filter(|line| !other.lines().any(|other| other == *line)).map(key).collect()
    };
    let (gone, new) = (only(before, now), only(now, before));
    let changed: BTreeMap<_, _> =
        now.lines().filter(|line| new.contains(&key(line))).map(|line| (key(line), line)).collect();
    let kept = there.lines().filter(|line| !gone.contains(&key(line)) || new.contains(&key(line)));
    let replaced = kept.map(|line| changed.get(&key(line)).copied().unwrap_or(line));
    let has = |line: &str| there.lines().any(|other| key(other) == key(line));
    let added = now.lines().filter(|line| new.contains(&key(line)) && !has(line));
    replaced.chain(added).map(|line| format!("{line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arrangement_changes_only_what_its_window_changed() {
        let there = "toggle_dock on\ntoggle_theme on\nlesson_done force\nlesson_done mass\n";
        // The window read it when the theme was dark and one lesson was done.
        let before = "toggle_dock on\ntoggle_theme off\nlesson_done force\ndock_width 300\n";
        let now = "toggle_dock off\ntoggle_theme off\nlesson_done force\nlesson_done gravity\n";
        let all = "toggle_dock off\ntoggle_theme on\nlesson_done force\nlesson_done mass\nlesson_done gravity\n";
        assert_eq!(with_changes(there, before, now), all);
        assert_eq!(with_changes(there, now, now), there);
        assert_eq!(with_changes("", "", now), now);
        assert_eq!(
            with_changes("dock_width 300\n", before, now).lines().count(),
            2,
            "it is the usual again"
        );
    }
}
