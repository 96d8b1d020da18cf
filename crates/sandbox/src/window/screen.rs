//! The window and what draws into it.

use std::sync::Arc;

use egui_winit::accesskit_winit::Event;
use render::wgpu::{Instance, InstanceDescriptor};
use render::{Image, RenderError};
use winit::dpi::PhysicalSize;
use winit::event_loop::{ActiveEventLoop, EventLoopProxy, OwnedDisplayHandle};
use winit::window::{Icon, Window};

use super::display;
use crate::failure::Failure;
use cockpit::app::session::Session;
use cockpit::stage::notices::Topic;

/// The window and what draws into it.
pub(super) struct Screen {
    pub window: Arc<Window>,
    display: OwnedDisplayHandle,
    pub surface: render::Screen,
    /// The clipboard, the input method, the screen reader and the shape of the pointer.
    pub platform: egui_winit::State,
    /// What the window is titled.
    title: String,
    /// How often the device was lost.
    lost: u32,
}

/// How often a lost device is replaced: one that is lost again and again has a reason.
const MOST_LOST: u32 = 3;

impl Screen {
    /// Opens a window and a device to draw into it.
    pub fn open(
        event_loop: &ActiveEventLoop,
        [width, height]: [u32; 2],
        context: &egui::Context,
        proxy: EventLoopProxy<Event>,
    ) -> Result<Self, Failure> {
        let monitor =
            event_loop.primary_monitor().or_else(|| event_loop.available_monitors().next());
        let most =
            monitor.map(|monitor| monitor.size()).filter(|most| most.width > 0 && most.height > 0);
        let most = most.unwrap_or(PhysicalSize::new(width, height));
        let attributes = display::named(Window::default_attributes())
            .with_title("Inertia")
            .with_window_icon(icon())
            // Screen readers have to be connected before it is seen.
            .with_visible(false)
            .with_inner_size(PhysicalSize::new(width.min(most.width), height.min(most.height)));
        let window = event_loop.create_window(attributes).map_err(|error| {
            let error = display::without_place(&error.to_string());
            Failure::NoDisplay(format!("cannot open a window: {error}; `sandbox run` needs none"))
        })?;
        let root = egui::ViewportId::ROOT;
        let mut platform = egui_winit::State::new(context.clone(), root, &window, None, None, None);
        platform.init_accesskit(event_loop, &window, proxy);
        window.set_visible(true);
        let window = Arc::new(window);
        let display = event_loop.owned_display_handle();
        let screen = draw_into(&window, &display)?;
        eprintln!("drawing with {}", screen.gpu.info);
        Ok(Self { window, display, surface: screen, platform, title: String::new(), lost: 0 })
    }

    /// Draws the session. Returns `false` if there was nothing to draw on. Opens another device in place of one that is lost.
    pub fn draw(&mut self, session: &mut Session) -> Result<bool, Failure> {
        let Self { surface: screen, window, .. } = self;
        let drawn = match screen.draw(|| session.picture(), || window.pre_present_notify()) {
            Err(error @ RenderError::Lost { .. }) if self.lost < MOST_LOST => {
                self.lost += 1;
                let lost = std::mem::replace(screen, draw_into(window, &self.display)?);
                screen.replace(lost);
                session.stage.notices.say(Topic::Other, format!("{error}; opened it again"));
                false
            }
            drawn => drawn?,
        };
        if !drawn && screen.target.lost() {
            let surface = screen.gpu.surface(Arc::clone(window))?;
            screen.target.replace_surface(&screen.gpu, surface);
        }
        Ok(drawn)
    }

    /// Lets the system do what the panels ask for. `held`: whether the pointer is hidden and held.
    pub fn carry_out(&mut self, session: &mut Session, held: bool) {
        let Some(mut requests) = session.take_requests() else { return };
        let title = session.title();
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
        if held {
            requests.cursor_icon = egui::CursorIcon::None;
        }
        // Panels may have another size than the display asks for.
        let points = session.pixels_per_point()
            / egui_winit::pixels_per_point(self.platform.egui_ctx(), &self.window);
        if let Some(ime) = &mut requests.ime {
            ime.cursor_rect = ime.cursor_rect * points;
        }
        self.platform.handle_platform_output(&self.window, requests);
    }

    /// The picture of the session, as the window shows it.
    pub fn image(&mut self, session: &mut Session) -> Result<Image, Failure> {
        let copy = self.surface.copy(&session.picture())?;
        Ok(copy.read(&self.surface.gpu)?)
    }
}

/// The icon of the window, where systems show one.
fn icon() -> Option<Icon> {
    let png = include_bytes!("../../packaging/inertia.png");
    let image = Image::decode_png(std::io::Cursor::new(png)).ok()?;
    Icon::from_rgba(image.rgba, image.size_px[0], image.size_px[1]).ok()
}

/// Opens a device to draw into a window.
fn draw_into(
    window: &Arc<Window>,
    display: &OwnedDisplayHandle,
) -> Result<render::Screen, Failure> {
    let display = Box::new(display.clone());
    let instance = Instance::new(InstanceDescriptor::new_with_display_handle_from_env(display));
    let size = window.inner_size();
    let opened = render::Screen::open(instance, Arc::clone(window), [size.width, size.height]);
    Ok(pollster::block_on(opened)?)
}
