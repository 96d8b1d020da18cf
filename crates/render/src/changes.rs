//! Finds the rectangle in which each picture of a film differs from the one before it.

use std::io;

use crate::Image;

/// The pictures of a film so far.
#[derive(Debug)]
pub(crate) struct Changes {
    shown: Option<Image>,
    /// When the last picture begins, s.
    last_s: f64,
    /// How long the picture before it is shown, s.
    length_s: f64,
}

impl Changes {
    /// Before the first picture.
    pub(crate) const NONE: Self = Self { shown: None, last_s: 0.0, length_s: 0.0 };

    /// The rectangle in which a picture that begins at `at_s` differs from the one before, and its position;
    /// unchanged pixels are transparent. The whole first picture; `None` if nothing changes.
    ///
    /// # Errors
    /// If the picture has another size than the one before.
    pub(crate) fn next(
        &mut self,
        image: Image,
        at_s: f64,
    ) -> io::Result<Option<([u32; 2], Image)>> {
        let change = match &self.shown {
            Some(shown) if shown.size_px != image.size_px => {
                return Err(io::Error::other("a film has pictures of one size"));
            }
            Some(shown) => {
                self.length_s = at_s - self.last_s;
                difference(shown, &image)
            }
            None => Some(([0; 2], image.clone())),
        };
        self.last_s = at_s;
        self.shown = Some(image);
        Ok(change)
    }

    /// The last picture.
    pub(crate) const fn shown(&self) -> Option<&Image> {
        self.shown.as_ref()
    }

    /// When the film ends, s: its last picture is shown as long as the one before it.
    pub(crate) const fn end_s(&self) -> f64 {
        self.last_s + self.length_s
    }
}

/// The smallest rectangle of `next` in which it differs from `shown`, and its position; `None` if the two are equal.
fn difference(shown: &Image, next: &Image) -> Option<([u32; 2], Image)> {
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
    Some((origin_px, image))
}
