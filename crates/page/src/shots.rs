//! Pictures that become files in a later frame.

use render::{Offscreen, Reading};

/// Files that were saved under names of the program, by kind.
#[derive(Default)]
pub(crate) struct Counts {
    pub screenshots: u32,
    pub bundles: u32,
    pub tables: u32,
}

/// A picture that the device is drawing, and the file that it is for.
pub(crate) struct Shot {
    pub copy: Offscreen,
    pub reading: Reading,
    pub name: String,
    pub is_bundle: bool,
}
