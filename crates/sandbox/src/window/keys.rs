//! Converts winit's keys to those of the program.

use winit::event::KeyEvent;
use winit::keyboard::{Key as Logical, ModifiersState, NamedKey};

use crate::input::Key;

/// The key that went down; `None` for keys that the program does not use.
pub(super) fn named(event: &KeyEvent, modifiers: ModifiersState) -> Option<Key> {
    let name = match &event.logical_key {
        Logical::Character(text) => {
            let mut characters = text.chars();
            let (Some(one), None) = (characters.next(), characters.next()) else { return None };
            let key = Key::character(one).with_ctrl(modifiers.control_key());
            return Some(key.with_shift(modifiers.shift_key()));
        }
        Logical::Named(named) => match named {
            NamedKey::Space => "Space",
            NamedKey::Shift => "Shift",
            NamedKey::Alt => "Alt",
            NamedKey::Control => "Ctrl",
            NamedKey::ArrowUp => "Up",
            NamedKey::ArrowDown => "Down",
            NamedKey::ArrowLeft => "Left",
            NamedKey::ArrowRight => "Right",
            NamedKey::PageUp => "PageUp",
            NamedKey::PageDown => "PageDown",
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
