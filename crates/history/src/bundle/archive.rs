//! Writes bundles to bytes and reads them back. Any bytes give a bundle or one error, and take no more memory than
//! the limits below. Written bundles keep to the same limits.

use std::io::{Cursor, Read, Write};

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::{BUNDLE_FORMAT, Bundle, EnergyState, Event, Manifest};
use crate::snapshot::Snapshot;
use scene::lists::{list, within};

/// A file of the archive: its name, and its size limit, bytes.
struct Member {
    name: &'static str,
    most: u64,
}

const SCENE: Member = Member { name: "scene.ron", most: scene::FILE_LIMIT };
const MANIFEST: Member = Member { name: "manifest.json", most: 16 << 20 };
const STATE: Member = Member { name: "state.cbor", most: 512 << 20 };
const PICTURE: Member = Member { name: "picture.png", most: 256 << 20 };

/// Memory limit of the lists of a state, or of a manifest, bytes: four times that of a timeline.
const MOST_MEMORY: usize = 256 << 20;

/// Hexadecimal digits of the checksum at the very end.
const DIGITS: usize = 16;

/// First bytes of every bundle: the signature of a ZIP archive.
const MAGIC: &[u8] = b"PK\x03\x04";

/// Start of the archive comment of every bundle.
const COMMENT: &str = "sandbox bundle, XXH3-64 of all bytes before: ";

const SMALLER: &str = "make it of fewer bodies";

/// Most ticks that a bundle may repeat. A timeline covers at most two minutes (one that it keeps, and up to another
/// before its oldest snapshot is dropped), so this many ticks would be more than eight million per second, which no
/// processor keeps up with.
const MOST_TICKS: u64 = 1_000_000_000;

/// Advice for a bundle that no program has written.
pub(crate) const UNDAMAGED: &str = "get an undamaged copy";

pub(crate) const CONTRADICTION: &str = "the ticks of the bundle contradict each other";

/// Why bytes are not a bundle, or a bundle cannot be simulated again.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}; {cure}")]
pub struct BadBundle {
    what: String,
    cure: &'static str,
}

impl BadBundle {
    pub(crate) fn new(what: impl Into<String>, cure: &'static str) -> Self {
        Self { what: what.into(), cure }
    }
}

/// The content of `state.cbor`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct State<S> {
    snapshot: S,
    #[serde(deserialize_with = "list")]
    events: Vec<Event>,
    /// The largest energy until the snapshot. Programs older than `energy` read and write only this key.
    energy_scale_j: Option<f64>,
    energy: Option<EnergyState>,
}

impl Bundle {
    /// Whether a file that begins with these bytes can be a bundle.
    #[must_use]
    pub fn begins_with(bytes: &[u8]) -> bool {
        bytes.starts_with(MAGIC)
    }

    /// The bytes of the bundle file. Equal bundles give equal bytes.
    ///
    /// # Errors
    /// If [`Bundle::read`] would refuse the bytes: a part is too large, ticks contradict each other, or a law is
    /// unknown to this program.
    pub fn write(&self) -> Result<Vec<u8>, BadBundle> {
        let Self { scene, manifest, snapshot, events, energy, picture } = self;
        manifest.check_format()?;
        manifest.check_text()?;
        manifest.check_ticks(snapshot.ticks())?;
        if snapshot.bytes() + events.iter().map(Event::bytes).sum::<usize>() > MOST_MEMORY {
            let what =
                format!("the state of the bundle takes more than {MOST_MEMORY} bytes of memory");
            return Err(BadBundle::new(what, SMALLER));
        }
        let energy_scale_j = energy.map(|energy| energy.largest_j);
        let state =
            cbor(&State { snapshot, events: events.clone(), energy_scale_j, energy: *energy })?;
        let manifest =
            serde_json::to_vec_pretty(manifest).map_err(|error| unwritten(&error, SMALLER))?;
        let mut files = vec![(&SCENE, scene.as_bytes()), (&MANIFEST, &manifest), (&STATE, &state)];
        files.extend(picture.as_ref().map(|picture| (&PICTURE, &picture[..])));
        let mut bytes = pack(&files)?;
        let end = bytes.len() - DIGITS;
        let checksum = checksum(&bytes[..end]);
        bytes[end..].copy_from_slice(checksum.as_bytes());
        Ok(bytes)
    }

    /// Reads a bundle from the bytes of a file.
    ///
    /// # Errors
    /// If the bytes are not a bundle, are damaged, have a newer format, or contain ticks that contradict each other.
    pub fn read(bytes: &[u8]) -> Result<Self, BadBundle> {
        if !Self::begins_with(bytes) {
            return Err(BadBundle::new(
                "this is not a bundle",
                "give a file that a black box has written",
            ));
        }
        let intact = bytes.len().checked_sub(DIGITS).map(|end| bytes.split_at(end));
        if intact.is_none_or(|(before, digits)| checksum(before).as_bytes() != digits) {
            return Err(BadBundle::new(
                "the bundle is damaged: its checksum does not match",
                UNDAMAGED,
            ));
        }
        let mut archive =
            ZipArchive::new(Cursor::new(bytes)).map_err(|error| unreadable(&error))?;
        let manifest = file(&mut archive, &MANIFEST)?.ok_or_else(|| lacking(&MANIFEST))?;
        let manifest: Manifest = within(MOST_MEMORY, || serde_json::from_slice(&manifest))
            .map_err(|error| unreadable(&error))?;
        manifest.check_format()?;
        manifest.check_text()?;
        let scene = file(&mut archive, &SCENE)?.ok_or_else(|| lacking(&SCENE))?;
        let state = file(&mut archive, &STATE)?.ok_or_else(|| lacking(&STATE))?;
        let state: State<Snapshot> = within(MOST_MEMORY, || ciborium::from_reader(&state[..]))
            .map_err(|error| unread_state(&error))?;
        manifest.check_ticks(state.snapshot.ticks())?;
        let tick = state.snapshot.ticks();
        Ok(Self {
            scene: String::from_utf8(scene).map_err(|error| unreadable(&error))?,
            manifest,
            snapshot: state.snapshot,
            events: state.events,
            energy: state
                .energy
                .or(state.energy_scale_j.map(|largest| EnergyState::at(tick, largest))),
            picture: file(&mut archive, &PICTURE)?,
        })
    }
}

impl Manifest {
    /// Fails if this program cannot read the format of the manifest.
    fn check_format(&self) -> Result<(), BadBundle> {
        match self.format {
            0 => Err(BadBundle::new("manifest.json in the bundle has no format", UNDAMAGED)),
            BUNDLE_FORMAT => Ok(()),
            newer => {
                let what = format!(
                    "format {newer} of the bundle is newer than this program, which reads format {BUNDLE_FORMAT}"
                );
                Err(BadBundle::new(what, "use a newer program"))
            }
        }
    }

    /// Fails if a text is not one line without control characters, as terminals show it.
    fn check_text(&self) -> Result<(), BadBundle> {
        let Self { program, scene, fault, .. } = self;
        let fault = fault.iter().flat_map(|fault| {
            [("fault.what", &fault.what)]
                .into_iter()
                .chain(fault.body.iter().map(|body| ("fault.body", body)))
        });
        let mut texts = [("program", program), ("scene", scene)].into_iter().chain(fault);
        match texts.find(|(_, text)| text.chars().any(char::is_control)) {
            Some((key, _)) => {
                let what = format!(
                    "`{key}` in manifest.json in the bundle is not one line of plain characters"
                );
                Err(BadBundle::new(what, UNDAMAGED))
            }
            None => Ok(()),
        }
    }

    /// Fails if the ticks of the manifest cannot be those of a run from a snapshot at tick `start`.
    fn check_ticks(&self, start: u64) -> Result<(), BadBundle> {
        let Self { snapshot_tick, end_tick, keyframes, .. } = self;
        let ascend = keyframes.is_sorted_by(|a, b| a.tick < b.tick);
        let begins = keyframes.first().is_none_or(|first| first.tick == start);
        let ends = keyframes.last().is_none_or(|last| last.tick <= *end_tick);
        if !(*snapshot_tick == start && *end_tick >= start && ascend && begins && ends) {
            return Err(BadBundle::new(CONTRADICTION, UNDAMAGED));
        }
        let ticks = end_tick - start;
        if ticks > MOST_TICKS {
            let what = format!("the bundle is of {ticks} ticks, which are more than {MOST_TICKS}");
            return Err(BadBundle::new(what, "save a run of fewer ticks per second"));
        }
        Ok(())
    }
}

/// Packs files into an archive whose comment ends with room for the checksum.
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

/// The bytes of a file of the archive; `None` if the archive does not have it.
fn file(
    archive: &mut ZipArchive<Cursor<&[u8]>>,
    Member { name, most }: &Member,
) -> Result<Option<Vec<u8>>, BadBundle> {
    let found = match archive.by_name(name) {
        Err(zip::result::ZipError::FileNotFound) => return Ok(None),
        found => found.map_err(|error| unreadable(&error))?,
    };
    let mut bytes = Vec::new();
    // Read one byte past the limit to detect a file that is too large: the size stated in the archive may be false.
    found.take(*most + 1).read_to_end(&mut bytes).map_err(|error| unreadable(&error))?;
    if bytes.len() as u64 > *most {
        return Err(BadBundle::new(
            format!("{name} in the bundle is larger than {most} bytes"),
            UNDAMAGED,
        ));
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

/// Describes an error in `state.cbor` in words, because ciborium has none.
fn unread_state(error: &ciborium::de::Error<std::io::Error>) -> BadBundle {
    use ciborium::de::Error;
    let what = match error {
        Error::Io(_) => "it ends too early".to_owned(),
        Error::Syntax(at) => format!("it is not CBOR from byte {at} on"),
        Error::Semantic(Some(at), what) => format!("{what}, at byte {at}"),
        Error::Semantic(None, what) => what.clone(),
        Error::RecursionLimitExceeded => "its lists are in one another too deeply".to_owned(),
    };
    BadBundle::new(format!("the bundle cannot be read: {}: {what}", STATE.name), UNDAMAGED)
}

fn unreadable(error: &dyn std::error::Error) -> BadBundle {
    BadBundle::new(format!("the bundle cannot be read: {error}"), UNDAMAGED)
}

fn unwritten(error: &dyn std::error::Error, cure: &'static str) -> BadBundle {
    BadBundle::new(format!("the bundle cannot be written: {error}"), cure)
}

#[cfg(test)]
mod tests;
