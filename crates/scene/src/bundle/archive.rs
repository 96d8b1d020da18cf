//! From bytes to a bundle and back. Whatever the bytes are: a bundle or one error, and no more memory than the
//! limits below.

use std::io::{Cursor, Read, Write};

use serde::Serialize;
use serde::de::DeserializeOwned;
use xxhash_rust::xxh3::xxh3_64;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::{BUNDLE_FORMAT, BadBundle, Bundle, Manifest, State};

const SCENE: &str = "scene.ron";
const MANIFEST: &str = "manifest.json";
const STATE: &str = "state.cbor";
const PICTURE: &str = "picture.png";

/// Largest size of each file in the archive, bytes: of the state, that of a million bodies.
const MOST_SCENE: u64 = crate::FILE_LIMIT;
const MOST_MANIFEST: u64 = 16 << 20;
const MOST_STATE: u64 = 512 << 20;
const MOST_PICTURE: u64 = 256 << 20;

/// Hexadecimal digits of the checksum at the very end.
const DIGITS: usize = 16;

/// What every bundle, as every other ZIP archive, begins with.
pub(crate) const MAGIC: &[u8] = b"PK\x03\x04";

/// What every comment of a bundle begins with.
const COMMENT: &str = "sandbox bundle, XXH3-64 of all bytes before: ";

const CURE: &str = "get an undamaged copy";

impl Bundle {
    /// The file's bytes, the same for the same bundle.
    ///
    /// # Errors
    /// What cannot be written because it is too large.
    pub fn write(&self) -> Result<Vec<u8>, BadBundle> {
        let state = State {
            snapshot: self.snapshot.clone(),
            events: self.events.iter().cloned().map(Into::into).collect(),
            energy_scale_j: self.energy_scale_j,
        };
        let mut files = vec![
            (SCENE, self.scene.clone().into_bytes()),
            (MANIFEST, json(&self.manifest)?),
            (STATE, cbor(&state)?),
        ];
        files.extend(self.picture.clone().map(|picture| (PICTURE, picture)));
        let mut bytes = pack(&files).map_err(|error| unwritten(&error))?;
        let end = bytes.len() - DIGITS;
        let checksum = checksum(&bytes[..end]);
        bytes[end..].copy_from_slice(checksum.as_bytes());
        Ok(bytes)
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// Bytes that are no bundle, or a damaged one; one of a newer format.
    pub fn read(bytes: &[u8]) -> Result<Self, BadBundle> {
        if !Self::begins_with(bytes) {
            return Err(BadBundle::new("this is no bundle", "give a file that a black box has written"));
        }
        let intact = bytes.len().checked_sub(DIGITS).map(|end| bytes.split_at(end));
        if intact.is_none_or(|(before, digits)| checksum(before).as_bytes() != digits) {
            return Err(BadBundle::new("the bundle is damaged: its checksum does not match", CURE));
        }
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| unreadable(&error))?;
        let manifest = file(&mut archive, MANIFEST, MOST_MANIFEST)?.ok_or_else(|| lacking(MANIFEST))?;
        let manifest: Manifest = serde_json::from_slice(&manifest).map_err(|error| unreadable(&error))?;
        if manifest.format > BUNDLE_FORMAT {
            let what = format!(
                "format {} of the bundle is newer than this program, which reads format {BUNDLE_FORMAT}",
                manifest.format
            );
            return Err(BadBundle::new(what, "use a newer program"));
        }
        let scene = file(&mut archive, SCENE, MOST_SCENE)?.ok_or_else(|| lacking(SCENE))?;
        let state = file(&mut archive, STATE, MOST_STATE)?.ok_or_else(|| lacking(STATE))?;
        let state: State = parse_cbor(&state)?;
        Ok(Self {
            scene: String::from_utf8(scene).map_err(|error| unreadable(&error))?,
            manifest,
            snapshot: state.snapshot,
            events: state.events.into_iter().map(Into::into).collect(),
            energy_scale_j: state.energy_scale_j,
            picture: file(&mut archive, PICTURE, MOST_PICTURE)?,
        })
    }
}

/// An archive whose comment ends with room for the checksum.
fn pack(files: &[(&str, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, bytes) in files {
        archive.start_file(*name, options)?;
        archive.write_all(bytes)?;
    }
    archive.set_comment(format!("{COMMENT}{}", "0".repeat(DIGITS)))?;
    Ok(archive.finish()?.into_inner())
}

fn checksum(bytes: &[u8]) -> String {
    format!("{:016x}", xxh3_64(bytes))
}

/// The bytes of a file of the archive, if it is there.
fn file(
    archive: &mut ZipArchive<Cursor<&[u8]>>,
    name: &str,
    most: u64,
) -> Result<Option<Vec<u8>>, BadBundle> {
    let found = match archive.by_name(name) {
        Err(zip::result::ZipError::FileNotFound) => return Ok(None),
        found => found.map_err(|error| unreadable(&error))?,
    };
    let mut bytes = Vec::new();
    // One byte past the limit tells a file that is too large; what the archive says of its size may be a lie.
    found.take(most + 1).read_to_end(&mut bytes).map_err(|error| unreadable(&error))?;
    if bytes.len() as u64 > most {
        return Err(BadBundle::new(format!("{name} in the bundle is larger than {most} bytes"), CURE));
    }
    Ok(Some(bytes))
}

fn json(value: &impl Serialize) -> Result<Vec<u8>, BadBundle> {
    serde_json::to_vec_pretty(value).map_err(|error| unwritten(&error))
}

fn cbor(value: &impl Serialize) -> Result<Vec<u8>, BadBundle> {
    let mut bytes = Vec::new();
    ciborium::into_writer(value, &mut bytes).map_err(|error| unwritten(&error))?;
    Ok(bytes)
}

fn parse_cbor<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, BadBundle> {
    ciborium::from_reader(bytes).map_err(|error| unreadable(&error))
}

fn lacking(name: &str) -> BadBundle {
    BadBundle::new(format!("the bundle has no {name}"), CURE)
}

fn unreadable(error: &dyn std::error::Error) -> BadBundle {
    BadBundle::new(format!("the bundle cannot be read: {error}"), CURE)
}

fn unwritten(error: &dyn std::error::Error) -> BadBundle {
    BadBundle::new(format!("the bundle cannot be written: {error}"), "make it of fewer bodies")
}

#[cfg(test)]
mod tests;
