//! From bytes to a bundle and back. Whatever the bytes are: a bundle or one error, and no more memory than the
//! limits below. What is written keeps to them as well.

use std::io::{Cursor, Read, Write};

use serde::Serialize;
use xxhash_rust::xxh3::xxh3_64;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::{BadBundle, Bundle, EnergyState, Event, Manifest, State, UNDAMAGED};
use crate::lists::within;
use crate::snapshot::Snapshot;

/// A file of the archive, and the largest that it may be, bytes.
struct Member {
    name: &'static str,
    most: u64,
}

const SCENE: Member = Member { name: "scene.ron", most: scene::FILE_LIMIT };
const MANIFEST: Member = Member { name: "manifest.json", most: 16 << 20 };
const STATE: Member = Member { name: "state.cbor", most: 512 << 20 };
const PICTURE: Member = Member { name: "picture.png", most: 256 << 20 };

/// Most memory that the lists of a state, or of a manifest, take, bytes: four times what a timeline takes.
const MOST_MEMORY: usize = 256 << 20;

/// Hexadecimal digits of the checksum at the very end.
const DIGITS: usize = 16;

/// What every bundle, as every other ZIP archive, begins with.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

/// What every comment of a bundle begins with.
const COMMENT: &str = "sandbox bundle, XXH3-64 of all bytes before: ";

const SMALLER: &str = "make it of fewer bodies";

impl Bundle {
    /// The file's bytes, the same for the same bundle.
    ///
    /// # Errors
    /// What [`Bundle::read`] would refuse: what is too large, ticks that contradict each other, a law that is not of
    /// this program.
    pub fn write(&self) -> Result<Vec<u8>, BadBundle> {
        let Self { scene, manifest, snapshot, events, energy, picture } = self;
        manifest.check_format()?;
        manifest.check_ticks(snapshot.ticks())?;
        if snapshot.bytes() + events.iter().map(Event::bytes).sum::<usize>() > MOST_MEMORY {
            let what = format!("the state of the bundle takes more than {MOST_MEMORY} bytes of memory");
            return Err(BadBundle::new(what, SMALLER));
        }
        let energy_scale_j = energy.map(|energy| energy.largest_j);
        let state = cbor(&State { snapshot, events: events.clone(), energy_scale_j, energy: *energy })?;
        let manifest = serde_json::to_vec_pretty(manifest).map_err(|error| unwritten(&error, SMALLER))?;
        let mut files = vec![(&SCENE, scene.as_bytes()), (&MANIFEST, &manifest), (&STATE, &state)];
        files.extend(picture.as_ref().map(|picture| (&PICTURE, &picture[..])));
        let mut bytes = pack(&files)?;
        let end = bytes.len() - DIGITS;
        let checksum = checksum(&bytes[..end]);
        bytes[end..].copy_from_slice(checksum.as_bytes());
        Ok(bytes)
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// Bytes that are no bundle, or a damaged one; one of a newer format; one whose ticks contradict each other.
    pub fn read(bytes: &[u8]) -> Result<Self, BadBundle> {
        if !Self::begins_with(bytes) {
            return Err(BadBundle::new("this is not a bundle", "give a file that a black box has written"));
        }
        let intact = bytes.len().checked_sub(DIGITS).map(|end| bytes.split_at(end));
        if intact.is_none_or(|(before, digits)| checksum(before).as_bytes() != digits) {
            return Err(BadBundle::new("the bundle is damaged: its checksum does not match", UNDAMAGED));
        }
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| unreadable(&error))?;
        let manifest = file(&mut archive, &MANIFEST)?.ok_or_else(|| lacking(&MANIFEST))?;
        let manifest: Manifest =
            within(MOST_MEMORY, || serde_json::from_slice(&manifest)).map_err(|error| unreadable(&error))?;
        manifest.check_format()?;
        let scene = file(&mut archive, &SCENE)?.ok_or_else(|| lacking(&SCENE))?;
        let state = file(&mut archive, &STATE)?.ok_or_else(|| lacking(&STATE))?;
        let state: State<Snapshot> =
            within(MOST_MEMORY, || ciborium::from_reader(&state[..])).map_err(|error| unreadable(&error))?;
        manifest.check_ticks(state.snapshot.ticks())?;
        let tick = state.snapshot.ticks();
        Ok(Self {
            scene: String::from_utf8(scene).map_err(|error| unreadable(&error))?,
            manifest,
            snapshot: state.snapshot,
            events: state.events,
            energy: state.energy.or(state.energy_scale_j.map(|largest| EnergyState::at(tick, largest))),
            picture: file(&mut archive, &PICTURE)?,
        })
    }
}

/// An archive whose comment ends with room for the checksum.
fn pack(files: &[(&Member, &[u8])]) -> Result<Vec<u8>, BadBundle> {
    for (Member { name, most }, bytes) in files {
        if bytes.len() as u64 > *most {
            let what = format!("{name} in the bundle would be larger than {most} bytes");
            return Err(BadBundle::new(what, SMALLER));
        }
    }
    zipped(files).map_err(|error| unwritten(&error, SMALLER))
}

fn zipped(files: &[(&Member, &[u8])]) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (Member { name, .. }, bytes) in files {
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
    Member { name, most }: &Member,
) -> Result<Option<Vec<u8>>, BadBundle> {
    let found = match archive.by_name(name) {
        Err(zip::result::ZipError::FileNotFound) => return Ok(None),
        found => found.map_err(|error| unreadable(&error))?,
    };
    let mut bytes = Vec::new();
    // One byte past the limit tells a file that is too large; what the archive says of its size may be a lie.
    found.take(*most + 1).read_to_end(&mut bytes).map_err(|error| unreadable(&error))?;
    if bytes.len() as u64 > *most {
        return Err(BadBundle::new(format!("{name} in the bundle is larger than {most} bytes"), UNDAMAGED));
    }
    Ok(Some(bytes))
}

fn cbor(value: &impl Serialize) -> Result<Vec<u8>, BadBundle> {
    let mut bytes = Vec::new();
    let cure = "save runs of scene files alone, without laws of another program's";
    ciborium::into_writer(value, &mut bytes).map_err(|error| unwritten(&error, cure))?;
    Ok(bytes)
}

fn lacking(Member { name, .. }: &Member) -> BadBundle {
    BadBundle::new(format!("the bundle has no {name}"), UNDAMAGED)
}

fn unreadable(error: &dyn std::error::Error) -> BadBundle {
    BadBundle::new(format!("the bundle cannot be read: {error}"), UNDAMAGED)
}

fn unwritten(error: &dyn std::error::Error, cure: &'static str) -> BadBundle {
    BadBundle::new(format!("the bundle cannot be written: {error}"), cure)
}

#[cfg(test)]
mod tests;
