//! Encodes pictures as an animated GIF with 256 colors per picture, for programs that show no other format.

use std::io::{self, Write};

use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};

use crate::Image;
use crate::changes::Changes;

/// Time units of a GIF per second: it counts hundredths of a second.
const PER_SECOND: f64 = 100.0;

/// How coarsely colors are chosen, from 1 (finest) to 30.
const SPEED: i32 = 10;

/// An animated GIF that plays without end. Each picture is written when the next one determines how long it is shown.
pub struct Gif<W: Write> {
    encoder: Encoder<W>,
    changes: Changes,
    /// The next frame, and the time at which it begins, s.
    waiting: Option<(Frame<'static>, f64)>,
}

impl Gif<Vec<u8>> {
    /// The shortest and the longest time that a picture can be shown, s: browsers show one of 10 ms for 100 ms.
    pub const LENGTHS_S: [f64; 2] = [0.02, u16::MAX as f64 / PER_SECOND];
}

impl<W: Write> Gif<W> {
    /// Begins a GIF in `out`, of pictures of that size.
    ///
    /// # Errors
    /// If a side is longer than 65,535 pixels, or `out` cannot be written.
    pub fn new(out: W, [width, height]: [u32; 2]) -> io::Result<Self> {
        let side = |side| u16::try_from(side).map_err(io::Error::other);
        let mut encoder = Encoder::new(out, side(width)?, side(height)?, &[]).map_err(io_error)?;
        encoder.set_repeat(Repeat::Infinite).map_err(io_error)?;
        Ok(Self { encoder, changes: Changes::NONE, waiting: None })
    }

    /// Adds an opaque picture that begins `at_s` seconds after the start of some clock. Times ascend.
    ///
    /// # Errors
    /// If the picture has another size than the first one, or `out` cannot be written.
    pub fn add(&mut self, image: Image, at_s: f64) -> io::Result<()> {
        if let Some((origin_px, part)) = self.changes.next(image, at_s)? {
            self.end_waiting(at_s)?;
            self.waiting = Some((frame(origin_px, part)?, at_s));
        }
        Ok(())
    }

    /// Writes the end. The last picture is shown as long as the one before it.
    ///
    /// # Errors
    /// If `out` cannot be written.
    pub fn finish(mut self) -> io::Result<W> {
        self.end_waiting(self.changes.end_s())?;
        self.encoder.into_inner().map_err(io_error)
    }

    fn end_waiting(&mut self, end_s: f64) -> io::Result<()> {
        let Some((mut frame, at_s)) = self.waiting.take() else { return Ok(()) };
        // Both times are rounded, not the difference, so that a long film keeps time.
        let [from, to] = [at_s, end_s].map(|time| (time * PER_SECOND).round());
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "rounded; casts saturate"
        )]
        let delay = (to - from) as u16;
        frame.delay = delay;
        self.encoder.write_frame(&frame).map_err(io_error)
    }
}

/// A frame that draws `part` at `origin_px` over the earlier pictures.
fn frame(origin_px: [u32; 2], mut part: Image) -> io::Result<Frame<'static>> {
    let ([left, top], [width, height]) = (origin_px, part.size_px);
    let pixels = |number| u16::try_from(number).map_err(io::Error::other);
    let frame = Frame::from_rgba_speed(pixels(width)?, pixels(height)?, &mut part.rgba, SPEED);
    Ok(Frame { left: pixels(left)?, top: pixels(top)?, dispose: DisposalMethod::Keep, ..frame })
}

#[expect(clippy::wildcard_enum_match_arm, reason = "errors of `gif`")]
fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::Io(error) => error,
        error => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_has_its_pictures_for_their_times() {
        let of = |color: [u8; 4]| Image { size_px: [3, 2], rgba: color.repeat(6) };
        let mut moved = of([9, 9, 9, 255]);
        moved.rgba[4..8].copy_from_slice(&[200, 0, 0, 255]);
        let mut film = Gif::new(Vec::new(), [3, 2]).expect("a memory");
        for (image, at_s) in [
            (of([9, 9, 9, 255]), 0.0),
            (moved.clone(), 0.5),
            (moved, 0.75),
            (of([0, 0, 200, 255]), 1.0),
        ] {
            film.add(image, at_s).expect("a memory");
        }
        let wider = Image { size_px: [4, 2], rgba: vec![255; 32] };
        assert!(film.add(wider, 2.0).is_err(), "a film has pictures of one size");
        let bytes = film.finish().expect("a memory");
        let mut decoder = gif::DecodeOptions::new();
        decoder.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = decoder.read_info(&bytes[..]).expect("a GIF");
        let mut frames = Vec::new();
        while let Some(frame) = decoder.read_next_frame().expect("a GIF") {
            frames.push((
                frame.delay,
                [frame.left, frame.top, frame.width, frame.height],
                frame.buffer.to_vec(),
            ));
        }
        let delays: Vec<_> = frames.iter().map(|(delay, ..)| *delay).collect();
        // A picture without changes extends the one before it; the last picture is shown as long as the one before
        // it.
        assert_eq!(delays, [50, 50, 25]);
        assert_eq!(frames[1].1, [1, 0, 1, 1], "only what differs");
        assert_eq!(frames[1].2, [200, 0, 0, 255]);
        assert_eq!(frames[2].2[..4], [0, 0, 200, 255]);
    }
}
