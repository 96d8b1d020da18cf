//! Errors between a frame and its pixels, in sentences that say what to do.

/// Why no picture could be drawn.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The machine offers no adapter at all, not even a software one.
    #[error(
        "no graphics adapter found; a GPU is not required: on Debian or Ubuntu install `mesa-vulkan-drivers` \
         (software rendering), or run without pictures ({detail})"
    )]
    NoAdapter {
        /// The message of wgpu.
        detail: String,
    },
    /// `WGPU_ADAPTER_NAME` names an adapter that the machine does not have.
    #[error(
        "WGPU_ADAPTER_NAME is `{wanted}`, but no usable adapter has that in its name; found: {found}"
    )]
    NoSuchAdapter {
        /// The value of the variable.
        wanted: String,
        /// The adapters of the machine, one after another.
        found: String,
    },
    /// The adapter refused to open.
    #[error("the graphics adapter {adapter} could not be opened: {detail}")]
    Device {
        /// The adapter, in one line.
        adapter: String,
        /// The message of wgpu.
        detail: String,
    },
    /// The device was lost while it was in use, or was given up.
    #[error(
        "the graphics adapter {adapter} was lost: {detail}; start again, with another adapter in WGPU_ADAPTER_NAME, or with less to draw"
    )]
    Lost {
        /// The adapter, in one line.
        adapter: String,
        /// The message of wgpu.
        detail: String,
    },
    /// The window cannot be drawn to.
    #[error(
        "cannot draw into the window: {detail}; WGPU_BACKEND=vulkan or WGPU_BACKEND=gl may help"
    )]
    Surface {
        /// The message of wgpu.
        detail: String,
    },
    /// A picture of this size cannot be drawn.
    #[error(
        "a picture of {width} x {height} pixels cannot be drawn: each side must be 1 to {max}, and all at most {max_area}"
    )]
    Size {
        /// Requested width, pixels.
        width: u32,
        /// Requested height, pixels.
        height: u32,
        /// The longest side this adapter can draw, in pixels.
        max: u32,
        /// The most pixels that can be read back.
        max_area: u64,
    },
    /// The pixels could not be copied back from the adapter.
    #[error("nothing could be read back from the graphics adapter: {detail}")]
    ReadBack {
        /// The message of wgpu.
        detail: String,
    },
}
