//! Figures as PNG, with the fonts that the program brings.

use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

/// Pixels of the picture for one of the figure: sharp on screens of twice the usual density.
const SCALE: f32 = 2.0;

/// Fonts to draw text with; the same on every machine.
pub(crate) struct Fonts(Arc<fontdb::Database>);

impl Fonts {
    pub(crate) fn new() -> Self {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
        // For the signs that the first one lacks.
        fonts.load_font_data(epaint_default_fonts::HACK_REGULAR.to_vec());
        fonts.set_sans_serif_family("Ubuntu");
        Self(Arc::new(fonts))
    }

    /// The picture of an SVG document of this module's making.
    pub(crate) fn png(&self, svg: &str) -> Vec<u8> {
        let options = Options { fontdb: Arc::clone(&self.0), ..Options::default() };
        let tree = Tree::from_str(svg, &options).expect("a figure is well-formed");
        let size = tree.size().to_int_size().scale_by(SCALE).expect("a figure has a size");
        let mut picture = Pixmap::new(size.width(), size.height()).expect("a figure has a size");
        resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut picture.as_mut());
        picture.encode_png().expect("a picture in memory can be encoded")
    }
}
