//! Encodes pictures as an animated PNG.

use std::io::{self, Read, Seek, SeekFrom, Write};

use png::chunk::{ChunkType, IDAT, IEND, acTL, fcTL, fdAT};
use png::{Compression, Filter};

use crate::Image;
use crate::changes::Changes;

/// An animated PNG in progress. Each picture is encoded when it is added and stored in `spool`, because a PNG begins
/// with the number of its pictures; so memory does not grow with them.
#[derive(Debug)]
pub struct Film<S> {
    spool: S,
    changes: Changes,
    /// The last change, which has no end time yet.
    waiting: Option<Change>,
    /// Pictures in the spool.
    pictures: u32,
    /// Numbered chunks in the spool.
    numbered: u32,
}

/// The compressed rectangle in which a picture differs from the one before; unchanged pixels are transparent.
#[derive(Debug)]
struct Change {
    at_s: f64,
    origin_px: [u32; 2],
    size_px: [u32; 2],
    data: Vec<u8>,
}

impl Film<()> {
    /// The shortest and the longest time that a picture can be shown, s.
    pub const LENGTHS_S: [f64; 2] = [1e-3, u16::MAX as f64];

    /// Most memory of a film of pictures of that size, bytes, however many there are: two pictures, twice their
    /// difference, and the compressed difference, which may be larger than the raw one.
    #[must_use]
    pub fn bytes([width, height]: [u32; 2]) -> u64 {
        6 * 4 * u64::from(width) * u64::from(height)
    }
}

impl<S: Read + Write + Seek> Film<S> {
    /// Begins a film that is kept in `spool`, an empty file for example, until it is finished.
    pub const fn new(spool: S) -> Self {
        Self { spool, changes: Changes::NONE, waiting: None, pictures: 0, numbered: 0 }
    }

    /// Adds an opaque picture that begins `at_s` seconds after the start of some clock. Times ascend.
    ///
    /// # Errors
    /// If the picture has another size than the first one, or the spool cannot be written.
    pub fn add(&mut self, image: Image, at_s: f64) -> io::Result<()> {
        if let Some((origin_px, part)) = self.changes.next(image, at_s)? {
            self.end_waiting(at_s)?;
            let (size_px, data) = (part.size_px, compressed(&part)?);
            self.waiting = Some(Change { at_s, origin_px, size_px, data });
        }
        Ok(())
    }

    /// Writes the film into `out`: an animated PNG that plays without end, with `text` as keyword and value pairs. Its last picture
    /// is shown as long as the one before it.
    ///
    /// # Errors
    /// If there is no picture, a keyword cannot be one, or a file cannot be read or written.
    pub fn finish(mut self, mut out: impl Write, text: &[(&str, &str)]) -> io::Result<()> {
        let size_px = self.changes.shown().map_or([0; 2], |image| image.size_px);
        self.end_waiting(self.changes.end_s())?;
        let mut writer = Image::encoder(&mut out, size_px, text)?.write_header()?;
        let endless = 0_u32;
        writer.write_chunk(acTL, &[self.pictures.to_be_bytes(), endless.to_be_bytes()].concat())?;
        self.spool.seek(SeekFrom::Start(0))?;
        let mut spool = io::BufReader::new(self.spool);
        let mut data = Vec::new();
        while let Some(kind) = read_chunk(&mut spool, &mut data)? {
            writer.write_chunk(kind, &data)?;
        }
        writer.finish()?;
        out.flush()
    }

    /// Puts the waiting change into the spool, with the end time `end_s`.
    fn end_waiting(&mut self, end_s: f64) -> io::Result<()> {
        let Some(Change { at_s, origin_px: [x, y], size_px: [width, height], data }) =
            self.waiting.take()
        else {
            return Ok(());
        };
        let mut control = self.number();
        for number in [width, height, x, y] {
            control.extend(number.to_be_bytes());
        }
        control.extend(delay(at_s, end_s).map(u16::to_be_bytes).concat());
        // The picture stays on the canvas, and the next one is drawn over it.
        control.extend([0, 1]);
        write_chunk(&mut self.spool, fcTL, &control)?;
        if self.pictures == 0 {
            write_chunk(&mut self.spool, IDAT, &data)?;
        } else {
            let number = self.number();
            write_chunk(&mut self.spool, fdAT, &[number, data].concat())?;
        }
        self.pictures += 1;
        Ok(())
    }

    /// The number of the next numbered chunk.
    fn number(&mut self) -> Vec<u8> {
        self.numbered += 1;
        (self.numbered - 1).to_be_bytes().to_vec()
    }
}

/// The compressed rows of a picture.
fn compressed(image: &Image) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = Image::encoder(&mut bytes, image.size_px, &[])?;
    encoder.set_compression(Compression::High);
    // Where most pixels are transparent, differences between neighbors are larger than the pixels themselves.
    encoder.set_filter(Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&image.rgba)?;
    writer.finish()?;
    let (mut rest, mut rows, mut data) = (&bytes[SIGNATURE..], Vec::new(), Vec::new());
    while let Some(kind) = read_chunk(&mut rest, &mut data)? {
        if kind == IDAT {
            rows.append(&mut data);
        }
        rest = &rest[CHECKSUM..];
        if kind == IEND {
            break;
        }
    }
    Ok(rows)
}

/// Bytes before the first chunk of a PNG.
const SIGNATURE: usize = 8;
/// Bytes after the data of each chunk.
const CHECKSUM: usize = 4;

/// Writes a chunk of a PNG without its checksum.
fn write_chunk(spool: &mut impl Write, ChunkType(kind): ChunkType, data: &[u8]) -> io::Result<()> {
    let length = u32::try_from(data.len()).map_err(io::Error::other)?;
    [&length.to_be_bytes(), &kind, data].into_iter().try_for_each(|part| spool.write_all(part))
}

/// Reads a chunk into `data`, without its checksum, and returns its kind; `None` at the end.
fn read_chunk(spool: &mut impl Read, data: &mut Vec<u8>) -> io::Result<Option<ChunkType>> {
    let (mut length, mut kind) = ([0; 4], [0; 4]);
    match spool.read_exact(&mut length) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    spool.read_exact(&mut kind)?;
    data.resize(u32::from_be_bytes(length) as usize, 0);
    spool.read_exact(data)?;
    Ok(Some(ChunkType(kind)))
}

/// The time from `from_s` to `to_s` as a numerator and a denominator: milliseconds, or the finest unit with which the
/// numerator fits. Both times are rounded, not the difference, so that a long film keeps time.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded; casts saturate"
)]
fn delay(from_s: f64, to_s: f64) -> [u16; 2] {
    let parts = |per_second: u16| {
        let [from, to] = [from_s, to_s].map(|time| (time * f64::from(per_second)).round());
        (to - from, per_second)
    };
    let all = [1000, 100, 10, 1].map(parts);
    let (count, per_second) =
        all.into_iter().find(|(count, _)| *count <= f64::from(u16::MAX)).unwrap_or(all[3]);
    [count as u16, per_second]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_shown_for_as_long_as_it_was_up_to_eighteen_hours() {
        for (from, to, expected) in [
            (0.0, 0.05, [50, 1000]),
            (1.0 / 60.0, 2.0 / 60.0, [16, 1000]),
            (0.0, 65.535, [65_535, 1000]),
            (10.0, 80.0, [7_000, 100]),
            (0.0, 700.0, [7_000, 10]),
            (0.0, 7_000.0, [7_000, 1]),
            (0.0, 65_535.0, [65_535, 1]),
        ] {
            assert_eq!(delay(from, to), expected, "{from} to {to}");
        }
    }
}
