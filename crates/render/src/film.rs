//! Pictures one after the other, as an animated PNG.

use std::io;

use png::{BlendOp, Compression, Filter};

use crate::Image;

/// A moving picture in memory: the first picture, and what changes after it.
#[derive(Clone, Debug, Default)]
pub struct Film {
    shown: Option<Image>,
    changes: Vec<Change>,
    /// When the last picture begins, s.
    last_s: f64,
    /// How long the picture before it is shown, s.
    length_s: f64,
}

/// The rectangle of a picture in which it differs from the one before; pixels that stay are transparent.
#[derive(Clone, Debug)]
struct Change {
    at_s: f64,
    origin_px: [u32; 2],
    image: Image,
}

impl Film {
    /// Adds an opaque picture that begins `at_s` seconds after the start of some clock. Times ascend.
    ///
    /// # Errors
    /// If the picture has another size than the first one.
    pub fn add(&mut self, image: Image, at_s: f64) -> io::Result<()> {
        match &self.shown {
            Some(shown) if shown.size_px != image.size_px => {
                return Err(io::Error::other("a film has pictures of one size"));
            }
            Some(shown) => {
                self.length_s = at_s - self.last_s;
                self.changes.extend(change(shown, &image, at_s));
            }
            None => self.changes.push(Change { at_s, origin_px: [0; 2], image: image.clone() }),
        }
        self.last_s = at_s;
        self.shown = Some(image);
        Ok(())
    }

    /// An animated PNG that plays without end, with `text` as keyword and value pairs. Its last picture is shown as
    /// long as the one before it.
    ///
    /// # Errors
    /// If there is no picture, or a keyword cannot be one.
    pub fn png(&self, text: &[(&str, &str)]) -> io::Result<Vec<u8>> {
        let size_px = self.shown.as_ref().map_or([0; 2], |image| image.size_px);
        let mut bytes = Vec::new();
        let mut encoder = Image::encoder(&mut bytes, size_px, text)?;
        encoder.set_animated(u32::try_from(self.changes.len()).map_err(io::Error::other)?, 0)?;
        encoder.set_blend_op(BlendOp::Over)?;
        encoder.set_compression(Compression::High);
        // Differences to neighbors are larger than what they replace where most pixels are transparent.
        encoder.set_filter(Filter::NoFilter);
        let mut writer = encoder.write_header()?;
        let end_s = self.last_s + self.length_s;
        let ends_s = self.changes.iter().skip(1).map(|change| change.at_s).chain([end_s]);
        for (Change { at_s, origin_px: [x, y], image }, end_s) in self.changes.iter().zip(ends_s) {
            writer.set_frame_delay(milliseconds(*at_s, end_s), 1000)?;
            writer.reset_frame_position()?;
            writer.set_frame_dimension(image.size_px[0], image.size_px[1])?;
            writer.set_frame_position(*x, *y)?;
            writer.write_image_data(&image.rgba)?;
        }
        writer.finish()?;
        Ok(bytes)
    }
}

/// From one time to the other, at most 65,535 ms. Both are rounded, so that a long film keeps time.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rounded; casts saturate")]
fn milliseconds(from_s: f64, to_s: f64) -> u16 {
    ((to_s * 1000.0).round() - (from_s * 1000.0).round()) as u16
}

/// The smallest rectangle of `next` in which it differs from `shown`; none if they are equal.
fn change(shown: &Image, next: &Image, at_s: f64) -> Option<Change> {
    let [width, height] = next.size_px;
    let differs = |x: &u32, y: &u32| shown.pixel(*x, *y) != next.pixel(*x, *y);
    let (mut columns, mut rows) = ([width, 0], [height, 0]);
    for y in 0..height {
        for x in (0..width).filter(|x| differs(x, &y)) {
            columns = [columns[0].min(x), columns[1].max(x + 1)];
            rows = [rows[0].min(y), y + 1];
        }
    }
    let size_px = [columns[1].checked_sub(columns[0])?, rows[1].checked_sub(rows[0])?];
    let origin_px = [columns[0], rows[0]];
    let (mut image, before) = (next.crop(origin_px, size_px)?, shown.crop(origin_px, size_px)?);
    for (pixel, before) in image.rgba.chunks_exact_mut(4).zip(before.rgba.chunks_exact(4)) {
        if pixel == before {
            pixel.fill(0);
        }
    }
    Some(Change { at_s, origin_px, image })
}
