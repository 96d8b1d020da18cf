//! Finds a graphics adapter, real or software, and opens it.

use std::fmt;
use std::pin::pin;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, Waker};

use wgpu::{
    Backends, Instance, InstanceDescriptor, PowerPreference, RequestAdapterOptions, Surface,
};

use crate::RenderError;

/// An open graphics device and how it was reached.
pub struct Gpu {
    /// Makes surfaces.
    pub instance: Instance,
    /// What the machine offers.
    pub adapter: wgpu::Adapter,
    /// Makes resources.
    pub device: wgpu::Device,
    /// Takes work.
    pub queue: wgpu::Queue,
    /// The adapter in words.
    pub info: AdapterSummary,
    /// Why the device is no longer usable; empty while it is.
    lost: Arc<OnceLock<String>>,
}

/// An adapter in words; displays as one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterSummary {
    /// Name of the adapter, as the driver reports it.
    pub name: String,
    /// `vulkan`, `gl`, `metal` or `dx12`.
    pub backend: String,
    /// Name of the driver, possibly empty.
    pub driver: String,
    /// Version of the driver, possibly empty.
    pub driver_info: String,
    /// Whether the processor does the drawing.
    pub software: bool,
}

impl AdapterSummary {
    fn of(adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        Self {
            name: info.name,
            backend: info.backend.to_string(),
            driver: info.driver,
            driver_info: info.driver_info,
            software: info.device_type == wgpu::DeviceType::Cpu,
        }
    }
}

impl fmt::Display for AdapterSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}", self.name, self.backend)?;
        for detail in [&self.driver, &self.driver_info] {
            if !detail.is_empty() {
                write!(f, ", {detail}")?;
            }
        }
        f.write_str(if self.software { " (software)" } else { "" })
    }
}

impl Gpu {
    /// Opens an adapter for pictures without a window. `WGPU_BACKEND` (`vulkan`, `gl`, ...) and `WGPU_ADAPTER_NAME`
    /// (part of a name, upper and lower case alike) narrow the choice.
    pub fn headless() -> Result<Self, RenderError> {
        let instance = Instance::new(InstanceDescriptor::new_without_display_handle_from_env());
        pollster::block_on(async {
            let adapter = chosen_adapter(&instance, None).await?;
            Self::open(instance, adapter).await
        })
    }

    /// Opens an adapter of `instance` that can draw into `window`, and the window's surface. On a desktop, `instance` needs the
    /// window system's own handle (winit: `Box::new(event_loop.owned_display_handle())`), without which OpenGL finds no surface.
    pub async fn for_window(
        instance: Instance,
        window: impl Into<wgpu::SurfaceTarget<'static>>,
    ) -> Result<(Self, Surface<'static>), RenderError> {
        let surface = match instance.create_surface(window) {
            Ok(surface) => surface,
            // Without any adapter, creating the surface fails first, and its message would mislead the reader.
            Err(error) => {
                chosen_adapter(&instance, None).await?;
                return Err(RenderError::Surface { detail: error.to_string() });
            }
        };
        let adapter = chosen_adapter(&instance, Some(&surface)).await?;
        Ok((Self::open(instance, adapter).await?, surface))
    }

    /// A new surface for a window whose old one was lost, to be given to [`crate::WindowTarget::replace_surface`].
    pub fn surface(
        &self,
        window: impl Into<wgpu::SurfaceTarget<'static>>,
    ) -> Result<Surface<'static>, RenderError> {
        self.instance
            .create_surface(window)
            .map_err(|error| RenderError::Surface { detail: error.to_string() })
    }

    /// The longest side of a picture, pixels.
    pub fn max_side_px(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// Whether the device still works.
    ///
    /// # Errors
    /// If it was lost, for example because its driver was restarted or the adapter was unplugged, or if it was
    /// [given up](Self::give_up).
    pub fn check(&self) -> Result<(), RenderError> {
        // Callbacks are called while the device is polled.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.lost.get().map_or(Ok(()), |why| {
            Err(RenderError::Lost { adapter: self.info.to_string(), detail: why.clone() })
        })
    }

    /// Lets [`Gpu::check`] fail from now on, for example because the device has too little memory.
    pub fn give_up(&self, why: String) {
        // Only the first reason counts.
        let _ = self.lost.set(why);
    }

    /// Copies out the bytes of a buffer that can be mapped. Waits for all submitted work.
    ///
    /// # Errors
    /// If it cannot be read; the error is wgpu's message.
    pub fn read_buffer(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, String> {
        let reading = self.begin_reading(buffer)?;
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
        reading.bytes().ok_or("the device did not come to an end")?
    }

    /// Begins to copy out the bytes of a buffer that can be mapped, once all submitted work is done.
    ///
    /// # Errors
    /// As [`Gpu::read_buffer`].
    pub fn begin_reading(&self, buffer: &wgpu::Buffer) -> Result<Reading, String> {
        let (sender, mapped) = std::sync::mpsc::channel();
        // A buffer of a lost device is invalid.
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone only if nothing waits for the bytes any more.
            let _ = sender.send(result);
        });
        match caught(scope) {
            Some(error) => Err(error.to_string()),
            None => Ok(Reading { buffer: buffer.clone(), mapped }),
        }
    }

    async fn open(instance: Instance, adapter: wgpu::Adapter) -> Result<Self, RenderError> {
        let info = AdapterSummary::of(&adapter);
        let can = adapter.get_downlevel_capabilities().flags;
        let least = if can.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
            wgpu::Limits::downlevel_defaults()
        } else {
            wgpu::Limits::downlevel_webgl2_defaults()
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("render"),
            required_limits: least.using_resolution(adapter.limits()),
            ..Default::default()
        };
        let opened = adapter.request_device(&descriptor).await;
        let (device, queue) = opened.map_err(|error| RenderError::Device {
            adapter: info.to_string(),
            detail: error.to_string(),
        })?;
        let lost = Arc::new(OnceLock::new());
        let notes = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, why| {
            // Only the first loss counts.
            let _ = notes.set(why);
        });
        Ok(Self { instance, adapter, device, queue, info, lost })
    }
}

/// A buffer whose bytes are being copied out.
pub struct Reading {
    buffer: wgpu::Buffer,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Reading {
    /// The bytes, once; `None` before they are there, for which [`Gpu::check`] has to be called.
    pub fn bytes(&self) -> Option<Result<Vec<u8>, String>> {
        let mapped = self.mapped.try_recv().ok()?.map_err(|error| error.to_string());
        Some(mapped.and_then(|()| {
            let view = self.buffer.get_mapped_range(..).map_err(|error| error.to_string())?;
            let bytes = view.to_vec();
            // A buffer must not be unmapped while it is looked at.
            drop(view);
            self.buffer.unmap();
            Ok(bytes)
        }))
    }
}

/// Chooses an adapter, by `WGPU_ADAPTER_NAME` if it is set: wgpu's own look-up panics if no adapter has the name.
async fn chosen_adapter(
    instance: &Instance,
    surface: Option<&Surface<'_>>,
) -> Result<wgpu::Adapter, RenderError> {
    if let Some(wanted) = std::env::var("WGPU_ADAPTER_NAME").ok().filter(|name| !name.is_empty()) {
        let adapters = instance.enumerate_adapters(Backends::all()).await;
        let found: Vec<String> =
            adapters.iter().map(|adapter| AdapterSummary::of(adapter).to_string()).collect();
        if !found.is_empty() {
            let usable = |adapter: &wgpu::Adapter| {
                surface.is_none_or(|surface| adapter.is_surface_supported(surface))
                    && adapter.get_info().name.to_lowercase().contains(&wanted.to_lowercase())
            };
            return adapters
                .into_iter()
                .find(usable)
                .ok_or_else(|| RenderError::NoSuchAdapter { wanted, found: found.join("; ") });
        }
    }
    let options = RequestAdapterOptions {
        power_preference: PowerPreference::from_env().unwrap_or(PowerPreference::HighPerformance),
        compatible_surface: surface,
        ..Default::default()
    };
    let chosen = instance.request_adapter(&options).await;
    chosen.map_err(|error| RenderError::NoAdapter { detail: error.to_string() })
}

/// The error that a scope of errors has caught. It is there at once, except that WebGPU in a page tells later, when no caller can
/// wait for it.
pub fn caught(scope: wgpu::ErrorScopeGuard) -> Option<wgpu::Error> {
    match pin!(scope.pop()).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(error) => error,
        Poll::Pending => None,
    }
}
