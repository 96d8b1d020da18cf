//! The keyboard in the panels: which control has it, and how it moves.

use egui::accesskit::{Action, ActionRequest, TreeId};
use egui::{Event, Id, Popup};

use crate::app::focus::before;
use crate::app::ui::Ui;
use crate::input::Key;

/// Keys that move from control to control and press them.
const NAVIGATION: [&str; 7] = ["Tab", "Up", "Down", "Left", "Right", "Enter", "Space"];

/// Where the keyboard was in the last layout.
#[derive(Default)]
pub(super) struct Focus {
    /// The control that had the keyboard.
    last: Option<Id>,
    /// Whether a list was open.
    list: bool,
    /// The control that opened the list.
    opener: Option<Id>,
}

impl Ui {
    /// The control that has the keyboard.
    fn focused(&self) -> Option<Id> {
        self.context.memory(egui::Memory::focused).filter(|_| self.any_open())
    }

    /// Whether a text field has the keyboard.
    pub fn takes_text(&self) -> bool {
        self.shows(crate::panels::Panel::Finder)
            || (self.any_open() && self.context.text_edit_focused())
    }

    /// Whether `key` is for the control that has the keyboard: any key for a text field, else those that move on and press.
    pub fn takes_key(&self, key: &Key) -> bool {
        self.takes_text()
            || (self.focused().is_some() && !key.ctrl() && NAVIGATION.contains(&key.name()))
    }

    /// Takes the keyboard from the control that has it. Returns whether there was one.
    pub fn release_focus(&mut self) -> bool {
        let focused = self.focused();
        focused
            .inspect(|id| self.context.memory_mut(|memory| memory.surrender_focus(*id)))
            .is_some()
    }

    /// Gives the keyboard to the next part of the cockpit, after the last one to the scene. Windows alone are one part.
    pub fn focus_next_part(&mut self) {
        Popup::close_all(&self.context);
        let place = self
            .focused()
            .and_then(|id| self.context.read_response(id))
            .map(|control| control.rect);
        let had = self.release_focus();
        if self.cockpit.shown {
            let here = place.and_then(|place| self.cockpit.part_at(place.center()));
            self.cockpit.focuses =
                if had && here.is_none() { None } else { self.cockpit.part_after(here) };
        } else if !had {
            self.key(&"Tab".parse().expect("a key"), true);
        }
    }

    /// The event by which an arrow key moves the edge of the dock, if the edge has the keyboard: the one that assistive
    /// technology sends.
    pub(super) fn move_dock_edge(&self, key: &Key) -> Option<Event> {
        let edge = self.focused().and_then(|id| self.context.read_response(id))?;
        let is_edge =
            self.cockpit.dock_left().is_some_and(|left| edge.rect.x_range().contains(left));
        let action = match key.name() {
            "Left" => Action::Increment,
            "Right" => Action::Decrement,
            _ => return None,
        };
        let (target_tree, target_node) = (TreeId::ROOT, edge.id.accesskit_id());
        let request = ActionRequest { action, target_tree, target_node, data: None };
        is_edge.then_some(Event::AccessKitActionRequest(request))
    }

    /// Follows the keyboard after a layout.
    pub(super) fn follow_focus(&mut self) {
        let (context, Focus { last, list: was_list, opener }) = (&self.context, &mut self.focus);
        let mut list = Popup::is_any_open(context);
        let mut focused = context.memory(egui::Memory::focused);
        let (clicked, chosen) = context.input(|input| {
            (
                input.pointer.any_pressed(),
                [egui::Key::Enter, egui::Key::Space].iter().any(|key| input.key_pressed(*key)),
            )
        });
        if *was_list && chosen && focused != *opener {
            // egui closes a list only for a click.
            Popup::close_all(context);
            (list, focused) = (false, None);
        }
        if *was_list && !list && focused.is_none() && last.is_some() && !clicked {
            // The chosen line has closed with its list: its opener gets the keyboard back.
            focused =
                opener.inspect(|opener| context.memory_mut(|memory| memory.request_focus(*opener)));
        }
        if !list {
            *opener = focused;
        }
        *was_list = list;
        context.data_mut(|data| data.insert_temp(before(), *last));
        *last = focused;
    }
}
