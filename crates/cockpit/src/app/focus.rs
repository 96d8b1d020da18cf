//! Scrolls to and frames the control that has the keyboard, and the control that a lesson points at.

use egui::style::ScrollAnimation;
use egui::{Context, Id, LayerId, Order, Rect, Response, Stroke, StrokeKind};

use crate::panels::{PANELS, Tab};
use crate::tools::learn::pointed_at;
use crate::view::marks::POINTER;

/// Width of the frame around the control that has the keyboard, points.
const FRAME: f32 = 2.0;

/// Key in egui's memory of the control that had the keyboard before the last layout.
pub(super) fn before() -> Id {
    Id::unique("focus before the last layout")
}

/// Scrolls to the control that has the keyboard, if it is in `ui` and got the keyboard in the last layout.
pub(super) fn reveal_focus(ui: &egui::Ui) {
    let focused = ui.memory(egui::Memory::focused);
    if focused == ui.data(|data| data.get_temp(before())).flatten() {
        return;
    }
    let control = focused.and_then(|id| ui.ctx().read_response(id));
    if let Some(control) = control.filter(|control| ui.min_rect().contains(control.rect.center())) {
        ui.scroll_to_rect_animation(control.rect, None, ScrollAnimation::none());
    }
}

/// Frames the control that has the keyboard.
pub(super) fn show_focus(context: &Context) {
    let focused = context.memory(egui::Memory::focused).and_then(|id| context.read_response(id));
    let Some(place) = focused.map(|control| control.interact_rect).filter(Rect::is_positive) else {
        return;
    };
    let painter = context.layer_painter(LayerId::new(Order::Tooltip, Id::unique("focus")));
    let color = context.global_style().visuals.selection.stroke.color;
    painter.rect_stroke(place, 3.0, Stroke::new(FRAME, color), StrokeKind::Outside);
}

/// Names of the controls at which lessons can point: those of the toolbar, the tabs and panels of the dock, and the button that
/// follows bodies that left the view.
pub fn pointable() -> impl Iterator<Item = &'static str> {
    const OTHERS: [&str; 18] = [
        "Scenes", "Learn", "Play", "Pause", "Back", "Step", "Reset", "method", "Gravity",
        "Velocity", "Forces", "Springs", "Trails", "Frame", "Fly", "Tools", "Help", "Follow",
    ];
    let tabs = Tab::ALL.into_iter().map(|tab| tab.words()[1]);
    let panels = PANELS.iter().filter(|(panel, _)| panel.tab().is_some()).map(|(_, row)| row.title);
    OTHERS.into_iter().chain(tabs).chain(panels)
}

/// Frames `control` if the open lesson points at `name`. Scrolls to it, once, if it is out of sight.
pub(super) fn frame_if_lesson_names(ui: &egui::Ui, name: &str, control: &Response) {
    if pointed_at(ui.ctx()).is_none_or(|pointed| pointed != name) {
        return;
    }
    let id = Id::unique("what a lesson pointed at before");
    let before = ui.data_mut(|data| {
        std::mem::replace(data.get_temp_mut_or_default::<String>(id), name.to_owned())
    });
    if !ui.clip_rect().contains_rect(control.rect) && before != name {
        ui.scroll_to_rect_animation(control.rect, None, ScrollAnimation::none());
    }
    if ui.is_rect_visible(control.rect) {
        let painter = ui.ctx().layer_painter(LayerId::new(Order::Tooltip, Id::unique("lesson")));
        painter.rect_stroke(control.rect, 3.0, Stroke::new(FRAME, POINTER), StrokeKind::Outside);
    }
}
