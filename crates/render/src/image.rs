//! A picture in memory and as a PNG file.

use std::{
    fs::{self, File},
    io::{self, BufReader, BufWriter, Write as _},
    path::{Path, PathBuf},
};

/// A picture: rows from top to bottom, four bytes a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Red, green, blue as displayed (sRGB) and alpha; drawn pictures are opaque (255).
    pub rgba: Vec<u8>,
}

impl Image {
    /// The four bytes at column `x` and row `y` from the top left; none outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        if x >= self.size_px[0] || y >= self.size_px[1] {
            return None;
        }
        let at = (y as usize * self.size_px[0] as usize + x as usize) * 4;
        self.rgba.get(at..at + 4)?.try_into().ok()
    }

    /// The part of `size_px` whose top left corner is `origin_px`; none where it is not wholly inside.
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

    /// Writes a PNG with `text` as keyword and value pairs. The file appears whole or not at all: it is written
    /// beside its place and then renamed.
    pub fn write_png(&self, path: impl AsRef<Path>, text: &[(&str, &str)]) -> io::Result<()> {
        let path = path.as_ref();
        let beside = beside(path)?;
        let result = self.encode(&beside, text).and_then(|()| fs::rename(&beside, path));
        if result.is_err() {
            // The first failure is the one to report.
            let _ = fs::remove_file(&beside);
        }
        result
    }

    fn encode(&self, path: &Path, text: &[(&str, &str)]) -> io::Result<()> {
        let mut file = BufWriter::new(File::create(path)?);
        let mut encoder = png::Encoder::new(&mut file, self.size_px[0], self.size_px[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        for (keyword, value) in text {
            encoder.add_itxt_chunk((*keyword).to_owned(), (*value).to_owned())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgba)?;
        writer.finish()?;
        // Dropping the buffer would swallow the error of a full disk.
        file.flush()
    }

    /// Reads a PNG of 8-bit gray, RGB or RGBA, or what decodes to one.
    pub fn read_png(path: impl AsRef<Path>) -> io::Result<Self> {
        let mut decoder = png::Decoder::new(BufReader::new(File::open(path)?));
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info()?;
        let mut bytes =
            vec![0; reader.output_buffer_size().ok_or_else(|| io::Error::other("picture too large"))?];
        let info = reader.next_frame(&mut bytes)?;
        bytes.truncate(info.buffer_size());
        let rgba = match info.color_type {
            png::ColorType::Rgba => bytes,
            png::ColorType::Rgb => bytes.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect(),
            png::ColorType::Grayscale => bytes.iter().flat_map(|&p| [p, p, p, 255]).collect(),
            png::ColorType::GrayscaleAlpha => {
                bytes.chunks_exact(2).flat_map(|p| [p[0], p[0], p[0], p[1]]).collect()
            }
            png::ColorType::Indexed => return Err(io::Error::other("a palette was not expanded")),
        };
        Ok(Self { size_px: [info.width, info.height], rgba })
    }

    /// The keyword and value pairs that [`Image::write_png`] put into a file.
    pub fn read_png_text(path: impl AsRef<Path>) -> io::Result<Vec<(String, String)>> {
        let reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
        let chunks = &reader.info().utf8_text;
        chunks.iter().map(|chunk| Ok((chunk.keyword.clone(), chunk.get_text()?))).collect()
    }
}

/// A name in the same directory, because a rename across file systems is not possible.
fn beside(path: &Path) -> io::Result<PathBuf> {
    let name =
        path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "not a file name"))?;
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.part", std::process::id()));
    Ok(path.with_file_name(hidden))
}
