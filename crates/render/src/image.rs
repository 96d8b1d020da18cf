//! A picture in memory and as a PNG file.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Seek},
    path::Path,
};

/// A picture: rows from top to bottom, four bytes per pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Red, green, blue as displayed (sRGB) and alpha; drawn pictures are opaque (255).
    pub rgba: Vec<u8>,
}

impl Image {
    /// The four bytes at column `x` and row `y` from the top left; `None` outside of the picture.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        if x >= self.size_px[0] || y >= self.size_px[1] {
            return None;
        }
        let at = (y as usize * self.size_px[0] as usize + x as usize) * 4;
        self.rgba.get(at..at + 4)?.try_into().ok()
    }

    /// The part of `size_px` whose top left corner is `origin_px`; `None` if it is not wholly inside.
    pub fn crop(&self, origin_px: [u32; 2], size_px: [u32; 2]) -> Option<Self> {
        for axis in 0..2 {
            if origin_px[axis].checked_add(size_px[axis])? > self.size_px[axis] {
                return None;
            }
        }
        let stride = self.size_px[0] as usize * 4;
        let row_bytes = size_px[0] as usize * 4;
        let mut rgba = Vec::with_capacity(row_bytes * size_px[1] as usize);
        for row in 0..size_px[1] as usize {
            let start = (origin_px[1] as usize + row) * stride + origin_px[0] as usize * 4;
            rgba.extend_from_slice(self.rgba.get(start..start + row_bytes)?);
        }
        Some(Self { size_px, rgba })
    }

    /// A PNG with `text` as keyword and value pairs.
    ///
    /// # Errors
    /// If a keyword is not valid.
    pub fn png(&self, text: &[(&str, &str)]) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut writer = Self::encoder(&mut bytes, self.size_px, text)?.write_header()?;
        writer.write_image_data(&self.rgba)?;
        writer.finish()?;
        Ok(bytes)
    }

    /// Begins a PNG of pictures of that size.
    pub(crate) fn encoder<W: io::Write>(
        out: W,
        size_px: [u32; 2],
        text: &[(&str, &str)],
    ) -> io::Result<png::Encoder<'static, W>> {
        let mut encoder = png::Encoder::new(out, size_px[0], size_px[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        for (keyword, value) in text {
            encoder.add_itxt_chunk((*keyword).to_owned(), (*value).to_owned())?;
        }
        Ok(encoder)
    }

    /// Reads a PNG file of 8-bit gray, RGB or RGBA, or of a format that decodes to one of these.
    pub fn read_png(path: impl AsRef<Path>) -> io::Result<Self> {
        Self::decode_png(BufReader::new(File::open(path)?))
    }

    /// Decodes a PNG of 8-bit gray, RGB or RGBA, or of a format that decodes to one of these.
    pub fn decode_png(file: impl BufRead + Seek) -> io::Result<Self> {
        let mut decoder = png::Decoder::new(file);
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info()?;
        let mut bytes =
            vec![
                0;
                reader.output_buffer_size().ok_or_else(|| io::Error::other("picture too large"))?
            ];
        let info = reader.next_frame(&mut bytes)?;
        bytes.truncate(info.buffer_size());
        let rgba = match info.color_type {
            png::ColorType::Rgba => bytes,
            png::ColorType::Rgb => {
                bytes.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect()
            }
            png::ColorType::Grayscale => bytes.iter().flat_map(|&p| [p, p, p, 255]).collect(),
            png::ColorType::GrayscaleAlpha => {
                bytes.chunks_exact(2).flat_map(|p| [p[0], p[0], p[0], p[1]]).collect()
            }
            png::ColorType::Indexed => return Err(io::Error::other("a palette was not expanded")),
        };
        Ok(Self { size_px: [info.width, info.height], rgba })
    }

    /// The keyword and value pairs that [`Image::png`] put into a file.
    pub fn read_png_text(path: impl AsRef<Path>) -> io::Result<Vec<(String, String)>> {
        let reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
        let chunks = &reader.info().utf8_text;
        chunks.iter().map(|chunk| Ok((chunk.keyword.clone(), chunk.get_text()?))).collect()
    }
}
