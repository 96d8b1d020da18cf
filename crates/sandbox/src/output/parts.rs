//! The file of a part of a study that several machines share.

use std::path::Path;

use lab::part::{FORMAT, Part};

use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{read_record, refuse_foreign_files, sealed, write};

/// File name of the part; it marks a folder as one that the program filled.
pub(crate) const PART: &str = "part.json";

/// Whether a part is written into a file of that name.
pub(crate) fn is_file(name: &str) -> bool {
    name == PART
}

/// The part in `folder`, if there is one.
pub(crate) fn part(folder: &Path) -> Result<Option<Part>, Failure> {
    let path = folder.join(PART);
    let cure = "run the shard again into another folder, or remove the file";
    let part: Option<Part> = read_record(&path, "part of a study", cure)?;
    if part.as_ref().is_some_and(|part| part.format != FORMAT) {
        let what = "this part was made by another version";
        return Err(Failure::Usage(format!("{}: {what}; {cure}", path.display())));
    }
    Ok(part)
}

/// Reads the earlier part in `folder`, into which `part` will be written. Refuses a part of another study.
pub(crate) fn earlier(
    part: &Part,
    folder: &Path,
    files: &CommandFiles,
) -> Result<Option<Part>, Failure> {
    files.refuse_names(folder, is_file, "the part in that folder; give another folder")?;
    let earlier = self::part(folder)?;
    refuse_foreign_files(folder, earlier.is_some(), is_file, "give another folder")?;
    if let Some(earlier) = &earlier {
        let other =
            part.differs(earlier).or((part.shard != earlier.shard).then_some("another shard"));
        if let Some(other) = other {
            let (path, cure) = (folder.join(PART), "give another folder, or remove it");
            return Err(Failure::Usage(format!(
                "{}: the part in this folder is of {other}; {cure}",
                path.display()
            )));
        }
    }
    Ok(earlier)
}

/// Writes a part into `folder`.
pub(crate) fn write_part(part: &Part, folder: &Path, files: &CommandFiles) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(part).expect("a part is plain data");
    write(&files.unread(&folder.join(PART))?, sealed(&text).as_bytes())
}
