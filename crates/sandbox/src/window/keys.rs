//! Converts winit's keys to those of the program.

use winit::keyboard::{Key as Logical, KeyCode, ModifiersState, NamedKey, PhysicalKey};

use cockpit::input::Key;

/// The key that went down; `None` for keys that the program does not use, and for those of the system, with Alt or the logo key.
/// On a Mac Command is the control key. A letter that is not Latin is the key that a US keyboard has at its place. So is a mark at the
/// place of a letter, such as that of Q in Greek, if the last letter was not Latin: `latin` says whether it was.
#[expect(clippy::wildcard_enum_match_arm, reason = "keys without a name here")]
pub(super) fn named(
    logical: &Logical,
    physical: PhysicalKey,
    modifiers: ModifiersState,
    is_mac: bool,
    latin: &mut bool,
) -> Option<Key> {
    let command = is_mac && modifiers.super_key();
    let shortcut = modifiers.alt_key() || (modifiers.super_key() && !is_mac);
    let name = match logical {
        Logical::Character(text) if !shortcut => {
            let us = on_us_keyboard(physical);
            if text.chars().all(char::is_alphabetic) {
                *latin = text.chars().all(is_latin);
            }
            let is_mark = !*latin
                && us.is_some_and(char::is_alphabetic)
                && !text.chars().any(char::is_alphanumeric);
            let is_us = is_mark || !text.chars().all(is_latin);
            let one = if is_us { us } else { single(text) };
            let key = Key::character(one?).with_ctrl(modifiers.control_key() || command);
            return Some(key.with_shift(modifiers.shift_key()));
        }
        Logical::Named(NamedKey::Shift) => "Shift",
        Logical::Named(NamedKey::Alt) => "Alt",
        Logical::Named(NamedKey::Control) => "Ctrl",
        Logical::Named(NamedKey::Super) if is_mac => "Ctrl",
        Logical::Named(named) if !shortcut => match named {
            NamedKey::Space => "Space",
            NamedKey::ArrowUp => "Up",
            NamedKey::ArrowDown => "Down",
            NamedKey::ArrowLeft => "Left",
            NamedKey::ArrowRight => "Right",
            NamedKey::PageUp => "PageUp",
            NamedKey::PageDown => "PageDown",
            NamedKey::Home => "Home",
            NamedKey::End => "End",
            NamedKey::Tab => "Tab",
            NamedKey::Escape => "Escape",
            NamedKey::Enter => "Enter",
            NamedKey::Backspace => "Backspace",
            NamedKey::Delete => "Delete",
            NamedKey::F1 => "F1",
            NamedKey::F2 => "F2",
            NamedKey::F6 => "F6",
            NamedKey::F7 => "F7",
            NamedKey::F8 => "F8",
            NamedKey::F9 => "F9",
            NamedKey::F10 => "F10",
            NamedKey::F12 => "F12",
            _ => return None,
        },
        _ => return None,
    };
    let key: Key = name.parse().ok()?;
    Some(key.with_shift(modifiers.shift_key()))
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
#[expect(clippy::wildcard_enum_match_arm, reason = "keys that type no letter")]
fn on_us_keyboard(key: PhysicalKey) -> Option<char> {
    let PhysicalKey::Code(code) = key else { return None };
    let named = format!("{code:?}");
    named.strip_prefix("Key").or(named.strip_prefix("Digit")).and_then(single).or(match code {
        KeyCode::BracketLeft => Some('['),
        KeyCode::BracketRight => Some(']'),
        KeyCode::Comma => Some(','),
        KeyCode::Period => Some('.'),
        KeyCode::Minus => Some('-'),
        KeyCode::Equal => Some('='),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: ModifiersState = ModifiersState::empty();
    const CTRL: ModifiersState = ModifiersState::CONTROL;
    const SHIFT: ModifiersState = ModifiersState::SHIFT;
    const SUPER: ModifiersState = ModifiersState::SUPER;

    fn typed(text: &str, code: KeyCode, modifiers: ModifiersState, is_mac: bool) -> String {
        typed_after(&mut true, text, code, modifiers, is_mac)
    }

    fn typed_after(
        latin: &mut bool,
        text: &str,
        code: KeyCode,
        modifiers: ModifiersState,
        is_mac: bool,
    ) -> String {
        let logical = Logical::Character(text.into());
        let key = named(&logical, PhysicalKey::Code(code), modifiers, is_mac, latin);
        key.map_or_else(String::new, |key| key.to_string())
    }

    #[test]
    fn letters_of_every_layout_are_keys() {
        for (text, code, modifiers, key) in [
            // Russian, Greek, Hebrew, Arabic with two letters, and digits of Arabic.
            ("\u{43f}", KeyCode::KeyG, NONE, "G"),
            ("\u{42b}", KeyCode::KeyS, CTRL | SHIFT, "Ctrl+Shift+S"),
            ("\u{44e}", KeyCode::Period, NONE, "."),
            ("\u{445}", KeyCode::BracketLeft, NONE, "["),
            ("\u{3b6}", KeyCode::KeyZ, CTRL, "Ctrl+Z"),
            ("\u{5e2}", KeyCode::KeyG, NONE, "G"),
            ("\u{644}\u{627}", KeyCode::KeyB, NONE, "B"),
            ("\u{661}", KeyCode::Digit1, NONE, "1"),
            // French and German, as printed.
            ("q", KeyCode::KeyA, NONE, "Q"),
            (",", KeyCode::KeyM, NONE, ","),
            ("\u{e9}", KeyCode::Digit2, NONE, "\u{c9}"),
            ("z", KeyCode::KeyY, CTRL, "Ctrl+Z"),
            ("\u{2116}", KeyCode::Digit3, SHIFT, "\u{2116}"),
        ] {
            assert_eq!(typed(text, code, modifiers, false), key, "{text}");
        }
    }

    #[test]
    fn marks_at_the_places_of_letters_are_letters_after_a_letter_that_is_not_latin() {
        let latin = &mut true;
        let mut down = |text, code, modifiers| typed_after(latin, text, code, modifiers, false);
        // Dvorak.
        assert_eq!(down(";", KeyCode::KeyZ, CTRL), "Ctrl+;");
        // Greek, Hebrew.
        for letter in ["\u{3b6}", "\u{5e2}"] {
            down(letter, KeyCode::KeyZ, NONE);
            down("1", KeyCode::Digit1, NONE);
            assert_eq!(down(";", KeyCode::KeyQ, CTRL), "Ctrl+Q");
            assert_eq!(down(":", KeyCode::KeyQ, SHIFT), "Shift+Q");
            assert_eq!(down("'", KeyCode::KeyW, NONE), "W");
            assert_eq!(down(".", KeyCode::Period, NONE), ".");
        }
        down("a", KeyCode::KeyA, NONE);
        assert_eq!(down("'", KeyCode::KeyQ, NONE), "'");
    }

    #[test]
    fn keys_of_the_system_are_no_keys_and_command_is_ctrl() {
        for modifiers in [ModifiersState::ALT, SUPER, CTRL | ModifiersState::ALT] {
            assert_eq!(typed("g", KeyCode::KeyG, modifiers, false), "");
            let tab = Logical::Named(NamedKey::Tab);
            assert_eq!(
                named(&tab, PhysicalKey::Code(KeyCode::Tab), modifiers, false, &mut true),
                None
            );
        }
        assert_eq!(typed("s", KeyCode::KeyS, SUPER, true), "Ctrl+S");
        let down = |named_key, is_mac| {
            let key = PhysicalKey::Code(KeyCode::SuperLeft);
            named(&Logical::Named(named_key), key, SUPER, is_mac, &mut true)
                .map(|key| key.to_string())
        };
        assert_eq!(down(NamedKey::Super, true).as_deref(), Some("Ctrl"));
        assert_eq!(down(NamedKey::Super, false), None);
    }
}
