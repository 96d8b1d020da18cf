//! The window and what draws into it.

use std::sync::Arc;

use egui_winit::accesskit_winit::Event;
use render::{Gpu, Image, Offscreen, Quality, Renderer, WindowTarget};
use winit::dpi::PhysicalSize;
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::window::Window;

use super::display;
use crate::failure::Failure;
use cockpit::app::session::Session;

/// The window and what draws into it.
pub(super) struct Screen {
    pub window: Arc<Window>,
    pub gpu: Gpu,
    pub target: WindowTarget,
    /// The clipboard, the input method, the screen reader and the shape of the pointer.
    pub platform: egui_winit::State,
    renderer: Renderer,
}

impl Screen {
    /// Opens a window and a device to draw into it.
    pub async fn open(
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
        let attributes = Window::default_attributes()
            .with_title("Inertia")
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
        let display = Box::new(event_loop.owned_display_handle());
        let (gpu, surface) = Gpu::for_window(Arc::clone(&window), display).await?;
        eprintln!("drawing with {}", gpu.info);
        let size = window.inner_size();
        let target = WindowTarget::new(surface, &gpu, [size.width, size.height])?;
        let renderer = Renderer::new(&gpu, target.format(), Quality::for_adapter(&gpu.info));
        Ok(Self { window, gpu, target, platform, renderer })
    }

    /// Draws the session. Returns `false` if there was nothing to draw on.
    pub fn draw(&mut self, session: &mut Session) -> Result<bool, Failure> {
        self.gpu.check()?;
        let Some(target) = self.target.acquire(&self.gpu) else {
            if self.target.lost() {
                let surface = self.gpu.surface(Arc::clone(&self.window))?;
                self.target.replace_surface(&self.gpu, surface);
            }
            return Ok(false);
        };
        let mut frame = session.picture();
        frame.size_px = target.size_px();
        self.renderer.draw(&self.gpu, &frame, target.view());
        self.window.pre_present_notify();
        target.present(&self.gpu);
        Ok(true)
    }

    /// Lets the system do what the panels ask for. `held`: whether the pointer is hidden and held.
    pub fn carry_out(&mut self, session: &mut Session, held: bool) {
        let Some(mut requests) = session.take_requests() else { return };
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
        let frame = session.picture();
        let copy = Offscreen::with_format(&self.gpu, frame.size_px, self.target.format())?;
        self.renderer.draw(&self.gpu, &frame, copy.view());
        Ok(copy.read(&self.gpu)?)
    }
}
