//! Bundles as files: written from a session, read, and opened as a session.

use std::fs;
use std::io::Read as _;
use std::path::Path;

use history::Bundle;
use render::Image;

use crate::failure::Failure;
use crate::output::files::{Output, OutputPath, output_file};
use crate::output::progress::progress_bar;
use cockpit::app::bundle::Repetition;
use cockpit::app::pictures::png;
use cockpit::app::session::Session;
use cockpit::stage::Stage;
use cockpit::stage::options::Options;

/// Largest file that is read, bytes.
const MOST_BYTES: u64 = 1 << 30;

/// Writes everything that `stage` has recorded, with a picture of it, into the file `path`.
pub(crate) fn write_bundle(
    path: &OutputPath,
    stage: &Stage,
    image: Option<&Image>,
) -> Result<(), Failure> {
    finish_bundle(path.as_ref(), output_file(path)?, stage, image)
}

/// Does the same as [`write_bundle`], into a file that was begun before.
pub(crate) fn finish_bundle(
    path: &Path,
    file: Output,
    stage: &Stage,
    image: Option<&Image>,
) -> Result<(), Failure> {
    let cannot = |error: &std::io::Error| Failure::file("write", path, error);
    let Some(bundle) = stage.bundle(image.map(|image| png(image, stage))) else {
        return Err(Failure::Usage("the recorded run cannot be reproduced".to_owned()));
    };
    let bytes =
        bundle.write().map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    file.finish_with(&bytes).map_err(|error| cannot(&error))
}

/// Reads the bundle at `path`.
pub(crate) fn read(path: &Path) -> Result<Bundle, Failure> {
    let cannot = |error: std::io::Error| Failure::file("read", path, &error);
    if path.is_dir() {
        return Err(cannot(std::io::ErrorKind::IsADirectory.into()));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)
        .and_then(|file| file.take(MOST_BYTES).read_to_end(&mut bytes))
        .map_err(cannot)?;
    Bundle::read(&bytes).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))
}

/// Reads the bundle in the file `path`; `None` if its first bytes are not those of a bundle.
pub(crate) fn named(path: &Path) -> Result<Option<Bundle>, Failure> {
    // Reading from a pipe would use it up.
    if !path.is_file() {
        return Ok(None);
    }
    let mut start = Vec::new();
    // Loading it as a scene says why it cannot be read.
    let read_start = fs::File::open(path).and_then(|file| file.take(4).read_to_end(&mut start));
    if read_start.is_err() || !Bundle::begins_with(&start) {
        return Ok(None);
    }
    read(path).map(Some)
}

/// Simulates `bundle`, read from the file `name`, again, with a progress bar on a terminal.
pub(crate) fn repeated(
    bundle: &Bundle,
    name: &str,
    options: Options,
) -> Result<(Session, Repetition), Failure> {
    let bar = progress_bar(Some(bundle.manifest.end_tick));
    let repeated = Session::of_bundle(bundle, name, options, &mut |tick| bar.set_position(tick));
    bar.finish_and_clear();
    Ok(repeated?)
}

/// Opens `bundle`, read from the file `name`, as a session that is paused at the last good tick before the fault, or at its end.
/// Tells the person what differs from the recording.
pub(crate) fn opened(bundle: &Bundle, name: &str, options: Options) -> Result<Session, Failure> {
    let (mut session, repetition) = repeated(bundle, name, options)?;
    session.show_repetition(name, &repetition, &bundle.manifest);
    Ok(session)
}
