//! Drawings as PNG, by the rasterizer and in the fonts that the window's panels have.

use epaint_default_fonts::{HACK_REGULAR, UBUNTU_LIGHT};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::DrawSettings;
use skrifa::outline::pen::SvgPen;
use skrifa::{FontRef, MetadataProvider};
use vello_cpu::color::{AlphaColor, Srgb};
use vello_cpu::kurbo::{self, Affine, BezPath};
use vello_cpu::{Pixmap, RenderContext, Resources};

use super::drawing::{Anchor, Drawing, Outline, PAPER, Rgb, Shape, WIDTH};

/// Pixels of the picture per pixel of the drawing: sharp on screens of twice the usual density.
const SCALE: u32 = 2;

impl Drawing {
    /// The picture, the same on every machine.
    pub(crate) fn png(&self) -> Vec<u8> {
        let size = |pixels: u32| u16::try_from(SCALE * pixels).expect("a figure is small");
        let (width, height) = (size(WIDTH), size(self.height));
        let mut context = RenderContext::new(width, height);
        let paper = [0.0, 0.0, WIDTH.into(), self.height.into()];
        draw(&mut context, &Shape::rectangles([paper]).fill(PAPER));
        self.shapes.iter().for_each(|shape| draw(&mut context, shape));
        context.flush();
        let mut pixels = Pixmap::new(width, height);
        context.render(&mut pixels, &mut Resources::new());
        encoded(&pixels)
    }
}

fn draw(context: &mut RenderContext, shape: &Shape) {
    let (path, angle) = match &shape.outline {
        Outline::Path(path) => (BezPath::from_svg(path).expect("a figure is well-formed"), 0.0),
        Outline::Words { text, size, anchor, upward } => {
            (letters(text, *size, *anchor), if *upward { -90.0_f64 } else { 0.0 })
        }
    };
    let place = Affine::translate(shape.at) * Affine::rotate(angle.to_radians());
    context.set_transform(Affine::scale(SCALE.into()) * place);
    if let Some(color) = shape.fill {
        context.set_paint(paint(color, 1.0));
        context.fill_path(&path);
    }
    if let Some(stroke) = shape.stroke {
        context.set_paint(paint(stroke.color, stroke.opacity));
        let line = kurbo::Stroke::new(stroke.width).with_caps(kurbo::Cap::Butt).with_join(kurbo::Join::Round);
        context.set_stroke(line.with_dashes(0.0, stroke.dash));
        context.stroke_path(&path);
    }
}

fn paint([r, g, b]: Rgb, opacity: f32) -> AlphaColor<Srgb> {
    AlphaColor::from_rgb8(r, g, b).with_alpha(opacity)
}

/// The outlines of words, from the foot of the first letter.
fn letters(text: &str, size: f64, anchor: Anchor) -> BezPath {
    let size = Size::new(size as f32);
    // The second one has the signs that the first one lacks.
    let fonts =
        [UBUNTU_LIGHT, HACK_REGULAR].map(|font| FontRef::new(font).expect("a font that the program brings"));
    let (mut path, mut x) = (BezPath::new(), 0.0);
    for letter in text.chars() {
        let found = fonts.iter().find_map(|font| Some((font, font.charmap().map(letter)?)));
        let Some((font, glyph)) = found else { continue };
        let mut pen = SvgPen::new();
        if let Some(outline) = font.outline_glyphs().get(glyph) {
            // A glyph that cannot be drawn is left out.
            let _ = outline.draw(DrawSettings::unhinted(size, LocationRef::default()), &mut pen);
        }
        let outline = BezPath::from_svg(&pen).unwrap_or_default();
        path.extend(Affine::new([1.0, 0.0, 0.0, -1.0, x, 0.0]) * outline);
        let advance = font.glyph_metrics(size, LocationRef::default()).advance_width(glyph);
        x += f64::from(advance.unwrap_or_default());
    }
    let before = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => 0.5 * x,
        Anchor::End => x,
    };
    Affine::translate((-before, 0.0)) * path
}

fn encoded(pixels: &Pixmap) -> Vec<u8> {
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, pixels.width().into(), pixels.height().into());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    // Paper is opaque: premultiplied or not is the same.
    let written =
        encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels.data_as_u8_slice()));
    written.expect("a picture in memory can be encoded");
    png
}
