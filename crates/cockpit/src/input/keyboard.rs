//! The keys of a keyboard as those of the program, by the names that W3C's "UI Events" gives them: winit and browsers have these.

use crate::input::Key;

/// Keys that are held while another one goes down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modifiers {
    /// Control.
    pub ctrl: bool,
    /// Shift.
    pub shift: bool,
    /// Alt.
    pub alt: bool,
    /// The logo key, or Command of a Mac.
    pub logo: bool,
}

/// Reads a keyboard.
#[derive(Clone, Copy, Debug)]
pub struct Keyboard {
    /// Whether Command is the control key.
    is_mac: bool,
    /// Whether the last letter was Latin.
    latin: bool,
}

impl Keyboard {
    /// Begins to read the keyboard of a Mac or of another machine.
    #[must_use]
    pub const fn new(is_mac: bool) -> Self {
        Self { is_mac, latin: true }
    }

    /// The key that went down, by its `key`, which is the text that it types or a name, and its `code`, which is its place; `None` for
    /// keys that the program does not use, and for those of the system, with Alt or the logo key. A letter that is not Latin is the
    /// key that a US keyboard has at its place. So is a mark at the place of a letter, such as that of Q in Greek, if the last letter
    /// was not Latin.
    pub fn named(&mut self, key: &str, code: &str, modifiers: Modifiers) -> Option<Key> {
        let Modifiers { ctrl, shift, alt, logo } = modifiers;
        let command = self.is_mac && logo;
        let is_of_system = alt || (logo && !self.is_mac);
        let name = match key {
            "Shift" | "Alt" => key,
            "Control" => "Ctrl",
            "Meta" | "Super" if self.is_mac => "Ctrl",
            _ if is_of_system => return None,
            " " => "Space",
            _ => key.strip_prefix("Arrow").unwrap_or(key),
        };
        if let Ok(named) = name.parse::<Key>()
            && named.name().chars().count() > 1
            && named.name() == name
        {
            return Some(named.with_shift(shift));
        }
        // Only keys without a text have a longer name in Latin letters.
        if key.len() > 1 && key.is_ascii() {
            return None;
        }
        let us = on_us_keyboard(code);
        if key.chars().all(char::is_alphabetic) {
            self.latin = key.chars().all(is_latin);
        }
        let is_mark = !self.latin
            && us.is_some_and(char::is_alphabetic)
            && !key.chars().any(char::is_alphanumeric);
        let is_us = is_mark || !key.chars().all(is_latin);
        let one = if is_us { us } else { single(key) };
        Some(Key::character(one?).with_ctrl(ctrl || command).with_shift(shift))
    }
}

fn single(text: &str) -> Option<char> {
    let mut characters = text.chars();
    characters.next().filter(|_| characters.next().is_none())
}

/// Whether a character is no letter or digit of another script than Latin.
fn is_latin(character: char) -> bool {
    !character.is_alphanumeric() || matches!(character, '\0'..='\u{24f}' | '\u{1e00}'..='\u{1eff}')
}

/// The character without Shift of that key of a US keyboard.
fn on_us_keyboard(code: &str) -> Option<char> {
    let named = code.strip_prefix("Key").or(code.strip_prefix("Digit")).and_then(single);
    named.or(match code {
        "BracketLeft" => Some('['),
        "BracketRight" => Some(']'),
        "Comma" => Some(','),
        "Period" => Some('.'),
        "Minus" => Some('-'),
        "Equal" => Some('='),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Modifiers = Modifiers { ctrl: false, shift: false, alt: false, logo: false };
    const CTRL: Modifiers = Modifiers { ctrl: true, ..NONE };
    const SHIFT: Modifiers = Modifiers { shift: true, ..NONE };
    const ALT: Modifiers = Modifiers { alt: true, ..NONE };
    const LOGO: Modifiers = Modifiers { logo: true, ..NONE };

    fn typed(text: &str, code: &str, modifiers: Modifiers, is_mac: bool) -> String {
        typed_on(&mut Keyboard::new(is_mac), text, code, modifiers)
    }

    fn typed_on(keyboard: &mut Keyboard, text: &str, code: &str, modifiers: Modifiers) -> String {
        keyboard.named(text, code, modifiers).map_or_else(String::new, |key| key.to_string())
    }

    #[test]
    fn letters_of_every_layout_are_keys() {
        for (text, code, modifiers, key) in [
            // Russian, Greek, Hebrew, Arabic with two letters, and digits of Arabic.
            ("\u{43f}", "KeyG", NONE, "G"),
            ("\u{42b}", "KeyS", Modifiers { shift: true, ..CTRL }, "Ctrl+Shift+S"),
            ("\u{44e}", "Period", NONE, "."),
            ("\u{445}", "BracketLeft", NONE, "["),
            ("\u{3b6}", "KeyZ", CTRL, "Ctrl+Z"),
            ("\u{5e2}", "KeyG", NONE, "G"),
            ("\u{644}\u{627}", "KeyB", NONE, "B"),
            ("\u{661}", "Digit1", NONE, "1"),
            // French and German, as printed.
            ("q", "KeyA", NONE, "Q"),
            (",", "KeyM", NONE, ","),
            ("\u{e9}", "Digit2", NONE, "\u{c9}"),
            ("z", "KeyY", CTRL, "Ctrl+Z"),
            ("\u{2116}", "Digit3", SHIFT, "\u{2116}"),
        ] {
            assert_eq!(typed(text, code, modifiers, false), key, "{text}");
        }
    }

    #[test]
    fn marks_at_the_places_of_letters_are_letters_after_a_letter_that_is_not_latin() {
        let keyboard = &mut Keyboard::new(false);
        let mut down = |text, code, modifiers| typed_on(keyboard, text, code, modifiers);
        // Dvorak.
        assert_eq!(down(";", "KeyZ", CTRL), "Ctrl+;");
        // Greek, Hebrew.
        for letter in ["\u{3b6}", "\u{5e2}"] {
            down(letter, "KeyZ", NONE);
            down("1", "Digit1", NONE);
            assert_eq!(down(";", "KeyQ", CTRL), "Ctrl+Q");
            assert_eq!(down(":", "KeyQ", SHIFT), "Shift+Q");
            assert_eq!(down("'", "KeyW", NONE), "W");
            assert_eq!(down(".", "Period", NONE), ".");
        }
        down("a", "KeyA", NONE);
        assert_eq!(down("'", "KeyQ", NONE), "'");
    }

    #[test]
    fn keys_of_the_system_are_no_keys_and_command_is_ctrl() {
        for modifiers in [ALT, LOGO, Modifiers { alt: true, ..CTRL }] {
            assert_eq!(typed("g", "KeyG", modifiers, false), "");
            assert_eq!(typed("Tab", "Tab", modifiers, false), "");
        }
        assert_eq!(typed("s", "KeyS", LOGO, true), "Ctrl+S");
        for name in ["Super", "Meta"] {
            assert_eq!(typed(name, "MetaLeft", LOGO, true), "Ctrl");
            assert_eq!(typed(name, "MetaLeft", LOGO, false), "");
        }
    }

    #[test]
    fn names_are_those_of_the_program_and_others_are_no_keys() {
        for (key, name) in [
            ("ArrowUp", "Up"),
            (" ", "Space"),
            ("Control", "Ctrl"),
            ("Escape", "Escape"),
            ("F12", "F12"),
            ("F3", ""),
            ("CapsLock", ""),
        ] {
            assert_eq!(typed(key, "", NONE, false), name, "{key}");
        }
        assert_eq!(typed("Tab", "Tab", SHIFT, false), "Shift+Tab");
    }
}
