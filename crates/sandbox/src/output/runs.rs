//! The files of a sweep: a journal to which every run is added, and the table, the figure and the record that are made from it.

use std::fs::{self, File};
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};

use csv::{ErrorKind, Reader, ReaderBuilder, StringRecord};
use lab::sweep::{Record, Row};
use lab::{Column, Value};
use report::sweep::Figure;
use xxhash_rust::xxh3::Xxh3;

use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{Output, read_record, sealed, write};

/// File name of the record; it marks a folder as one that the program filled.
pub(crate) const RECORD: &str = "sweep.json";
/// File name of the journal: the runs so far, in order.
const JOURNAL: &str = "runs.part.csv";
const TABLE: &str = "runs.csv";
const FIGURE: &str = "sweep.svg";

/// Whether a sweep writes a file of that name.
pub(crate) fn is_file(name: &str) -> bool {
    [RECORD, JOURNAL, TABLE, FIGURE].contains(&name)
}

/// Whether all files of the complete sweep of `record` are in `folder`, with its table unchanged.
pub(crate) fn are_there(record: &Record, folder: &Path) -> bool {
    folder.join(FIGURE).exists() && Runs::of_folder(record, folder).is_ok()
}

/// The record in `folder`, if there is one.
pub(crate) fn record(folder: &Path) -> Result<Option<Record>, Failure> {
    read_record(
        &folder.join(RECORD),
        "record of a sweep",
        "run the sweep again in another folder, or remove the file",
    )
}

/// Writes the record of a sweep into `folder`.
pub(crate) fn write_record(
    record: &Record,
    folder: &Path,
    files: &CommandFiles,
) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(record).expect("a record is plain data");
    write(&files.unread(&folder.join(RECORD))?, sealed(&text).as_bytes())
}

/// The hash of all bytes so far, 16 hexadecimal digits.
fn hex(hash: &Xxh3) -> String {
    format!("{:016x}", hash.digest())
}

/// A line of the journal: a row of the table, and the hash of all bytes before.
fn journal_line(hash: &mut Xxh3, row: &[u8]) -> Vec<u8> {
    hash.update(row);
    hash.update(b",");
    let end = hex(hash) + "\n";
    hash.update(end.as_bytes());
    [row, b",", end.as_bytes()].concat()
}

/// The runs of an unfinished sweep. A run that was added stays, whatever ends the program.
pub(crate) struct Journal {
    path: PathBuf,
    file: File,
    hash: Xxh3,
}

impl Journal {
    /// Starts the journal of a sweep in `folder`, with the runs of the earlier one if it `continues`. Also returns their number.
    pub fn begin(
        record: &Record,
        folder: &Path,
        files: &CommandFiles,
        continues: bool,
    ) -> Result<(Self, u64), Failure> {
        let path = folder.join(JOURNAL);
        let reading = |error: io::Error| Failure::file("read", &path, &error);
        let writing = |error: io::Error| Failure::file("write", &path, &error);
        let mut output = Output::create(&files.unread(&path)?).map_err(writing)?;
        let (mut hash, mut lines) = (Xxh3::new(), 0);
        if continues && path.exists() {
            let mut earlier = BufReader::new(File::open(&path).map_err(reading)?);
            let mut line = Vec::new();
            // An incomplete last line is left out, and its run is run again.
            while earlier.read_until(b'\n', &mut line).map_err(reading)? > 0
                && line.ends_with(b"\n")
            {
                lines += 1;
                let row = &line[..line.len().saturating_sub(18)];
                if journal_line(&mut hash, row) != line {
                    let what = format!("line {lines} was changed since it was written");
                    let cure = "remove it and all lines after it, and --resume runs them again";
                    return Err(Failure::Usage(format!("{}: {what}; {cure}", path.display())));
                }
                output.write_all(&line).map_err(writing)?;
                line.clear();
            }
        }
        if lines == 0 {
            let header = report::sweep::header(&record.plan);
            output
                .write_all(&journal_line(&mut hash, header.trim_end_matches('\n').as_bytes()))
                .map_err(writing)?;
        }
        let file = output.put_in_place().map_err(writing)?;
        let mut runs = Runs::open(record, path.clone())?;
        while runs.next()?.is_some() {}
        let done = runs.place;
        Ok((Self { path, file, hash }, done))
    }

    /// Adds a run.
    pub fn add(&mut self, row: &Row) -> Result<(), Failure> {
        let row = report::sweep::row(&row.values);
        self.file
            .write_all(&journal_line(&mut self.hash, row.trim_end_matches('\n').as_bytes()))
            .map_err(|error| Failure::file("write", &self.path, &error))
    }

    /// Makes the files of the sweep from the journal.
    pub fn finish(
        self,
        record: &Record,
        folder: &Path,
        files: &CommandFiles,
    ) -> Result<(), Failure> {
        write_tables(record, vec![Runs::open(record, self.path.clone())?], folder, files)?;
        fs::remove_file(&self.path).map_err(|error| Failure::file("remove", &self.path, &error))
    }
}

/// The runs of a table or journal, read one by one.
pub(crate) struct Runs<'r> {
    path: PathBuf,
    reader: Reader<BufReader<File>>,
    record: &'r Record,
    columns: Vec<Column>,
    /// Number of runs that were read.
    place: u64,
    row: StringRecord,
}

impl<'r> Runs<'r> {
    /// The table of a finished sweep in `folder`.
    pub fn of_folder(record: &'r Record, folder: &Path) -> Result<Self, Failure> {
        let runs = Self::open(record, folder.join(TABLE))?;
        let mut hash = Xxh3::new();
        File::open(&runs.path)
            .and_then(|mut file| io::copy(&mut file, &mut hash))
            .map_err(|error| Failure::file("read", &runs.path, &error))?;
        if record.table_hash.as_ref() == Some(&hex(&hash)) {
            Ok(runs)
        } else {
            Err(runs.damaged("does not have the checksum of its record"))
        }
    }

    fn open(record: &'r Record, path: PathBuf) -> Result<Self, Failure> {
        let file = File::open(&path).map_err(|error| Failure::file("read", &path, &error))?;
        let reader = ReaderBuilder::new().from_reader(BufReader::new(file));
        let columns = record.plan.columns();
        let mut runs = Self { path, reader, record, columns, place: 0, row: StringRecord::new() };
        let header = runs.reader.headers().cloned().unwrap_or_default();
        let names = runs.columns.iter().map(|column| &*column.name);
        // A journal has one column more.
        if names.eq(header.iter().take(runs.columns.len())) {
            Ok(runs)
        } else {
            Err(runs.damaged("has other columns"))
        }
    }

    /// The next run with the values of its row, and its line of the table.
    #[expect(clippy::wildcard_enum_match_arm, reason = "errors of `csv`")]
    pub fn next(&mut self) -> Result<Option<(u64, Vec<Value>, String)>, Failure> {
        match self.reader.read_record(&mut self.row) {
            Ok(true) => {}
            Ok(false) => return Ok(None),
            Err(error) => match error.into_kind() {
                ErrorKind::Io(error) => return Err(Failure::file("read", &self.path, &error)),
                _ => self.row.clear(),
            },
        }
        let run = self.record.shard.nth(self.place);
        let read = |(column, field)| report::sweep::read(column, field);
        let values: Option<Vec<Value>> = self.columns.iter().zip(&self.row).map(read).collect();
        let planned = self.record.plan.values(run);
        let planned = self.columns[1..].iter().zip(planned).map(read);
        let planned: Option<Vec<Value>> =
            std::iter::once(Some(Value::Count(run))).chain(planned).collect();
        if let (Some(values), Some(planned)) = (values, planned)
            && values.len() == self.columns.len()
        {
            // As they are written: a text that a spreadsheet would compute has an apostrophe.
            let [line, start] = [&values, &planned].map(|values| report::sweep::row(values));
            let rest = line.strip_prefix(start.trim_end_matches('\n'));
            if rest.is_some_and(|rest| rest.starts_with(',')) {
                self.place += 1;
                return Ok(Some((run, values, line)));
            }
        }
        let line = self.place + 2;
        Err(self.damaged(&format!("does not have run {run} with its values in line {line}")))
    }

    fn damaged(&self, what: &str) -> Failure {
        let cure = "it was changed since it was written: run the sweep again in another folder";
        Failure::Usage(format!("{}: this table {what}; {cure}", self.path.display()))
    }
}

/// Writes table, figure and record of the runs of all `sources`, whose numbers ascend in each of them, into `folder`. The memory
/// that this takes does not grow with the number of runs.
pub(crate) fn write_tables(
    record: &Record,
    mut sources: Vec<Runs<'_>>,
    folder: &Path,
    files: &CommandFiles,
) -> Result<(), Failure> {
    let [table_path, figure_path] = &[TABLE, FIGURE].map(|name| folder.join(name));
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |error: io::Error| Failure::file("write", &path, &error)
    };
    let mut table = Output::create(&files.unread(table_path)?).map_err(failed(table_path))?;
    let mut figure = Figure::new(&record.scene, &record.plan);
    let mut hash = Xxh3::new();
    let mut write_line = |line: String| {
        hash.update(line.as_bytes());
        table.write_all(line.as_bytes()).map_err(failed(table_path))
    };
    write_line(report::sweep::header(&record.plan))?;
    let mut heads = Vec::new();
    for source in &mut sources {
        heads.push(source.next()?);
    }
    loop {
        let first = (0..heads.len())
            .min_by_key(|at| heads[*at].as_ref().map_or(u64::MAX, |(run, ..)| *run));
        let Some((at, (run, values, line))) = first.and_then(|at| Some((at, heads[at].take()?)))
        else {
            break;
        };
        write_line(line)?;
        figure.add(run, &values);
        heads[at] = sources[at].next()?;
    }
    let runs: u64 = sources.iter().map(|source| source.place).sum();
    let all = record.shard.count(record.plan.runs().unwrap_or(u64::MAX));
    if runs != all {
        let what = format!("{runs} of {all} runs are in the tables");
        return Err(Failure::Usage(format!("{what}; run the sweep again in another folder")));
    }
    // First, because the record marks the folder as one that the program filled.
    write_record(record, folder, files)?;
    table.finish().map_err(failed(table_path))?;
    write(&files.unread(figure_path)?, figure.drawing().document().as_bytes())?;
    let table_hash = Some(hex(&hash));
    write_record(&Record { complete: true, table_hash, ..record.clone() }, folder, files)
}

#[expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
#[cfg(test)]
mod tests {
    use lab::Shard;
    use lab::sweep::{Axis, FORMAT, Measure, Plan, Sweep};
    use tempfile::TempDir;

    use super::*;

    /// A sweep of eight runs, and the bytes of the journal after five of them.
    fn interrupted() -> (Sweep, Record, Vec<u8>) {
        let axes = ["method=runge_kutta_2_heun,explicit_euler", "step_hz=20,30,40,50"];
        let axes = axes.map(|axis| Axis::parse(axis).unwrap()).to_vec();
        let measures = vec![Measure::Drift, Measure::StateHash];
        let plan = Plan { axes, seconds: 0.1, measures };
        let sweep = Sweep::new(&CommandFiles::default().scene("oscillator").unwrap(), plan.clone())
            .unwrap();
        let record = Record {
            format: FORMAT,
            version: String::new(),
            scene: "oscillator".to_owned(),
            scene_hash: String::new(),
            plan,
            shard: Shard::WHOLE,
            processors: Vec::new(),
            complete: false,
            table_hash: None,
        };
        let folder = TempDir::new().unwrap();
        let files = CommandFiles::default();
        let (mut journal, _) = Journal::begin(&record, folder.path(), &files, false).unwrap();
        (0..5).for_each(|run| journal.add(&sweep.row(run)).unwrap());
        (sweep, record, fs::read(folder.path().join(JOURNAL)).unwrap())
    }

    /// The table after a sweep has continued from that journal. A refused one stays as it is.
    fn continued((sweep, record): (&Sweep, &Record), bytes: &[u8]) -> Result<Vec<u8>, Failure> {
        let folder = TempDir::new().unwrap();
        let (files, path) = (CommandFiles::default(), folder.path().join(JOURNAL));
        fs::write(&path, bytes).unwrap();
        let begun = Journal::begin(record, folder.path(), &files, true);
        let (mut journal, done) = begun.inspect_err(|_| {
            assert_eq!(fs::read(&path).unwrap(), bytes);
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        })?;
        (done..8).for_each(|run| journal.add(&sweep.row(run)).unwrap());
        journal.finish(record, folder.path(), &files).unwrap();
        Ok(fs::read(folder.path().join(TABLE)).unwrap())
    }

    #[test]
    fn a_journal_that_was_cut_is_continued_and_one_with_a_flipped_bit_changes_no_table() {
        let (sweep, record, bytes) = interrupted();
        let whole = continued((&sweep, &record), &[]).unwrap();
        for length in (0..=bytes.len()).step_by(3) {
            assert!(continued((&sweep, &record), &bytes[..length]).unwrap() == whole, "{length}");
        }
        let mut refused = 0;
        for bit in (0..bytes.len() * 8).step_by(11) {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            match continued((&sweep, &record), &damaged) {
                Ok(table) => assert!(table == whole, "bit {bit}"),
                Err(failure) => {
                    refused += 1;
                    let cure = "remove it and all lines after it, and --resume runs them again";
                    assert!(failure.to_string().ends_with(cure), "{failure}");
                }
            }
        }
        // All but those of the last line break.
        assert!(refused + 1 >= (bytes.len() * 8).div_ceil(11), "{refused}");
    }

    #[test]
    fn values_that_are_not_those_of_the_plan_are_refused() {
        let (sweep, mut other, bytes) = interrupted();
        other.plan.axes[0].values[0] = "velocity_verlet".to_owned();
        let said = continued((&sweep, &other), &bytes).map_err(|failure| failure.to_string());
        assert!(said.is_err_and(|said| said.contains("does not have run 0 with its values")));
    }

    #[test]
    #[cfg(unix)]
    fn a_journal_that_is_a_link_to_the_scene_leaves_the_scene_as_it_is() {
        let (_, record, _) = interrupted();
        for continues in [false, true] {
            let folder = TempDir::new().unwrap();
            let (scene, journal) = (folder.path().join("own.ron"), folder.path().join(JOURNAL));
            fs::write(&scene, "(version: 1)").unwrap();
            let mut files = CommandFiles::default();
            files.read("the scene", &scene).unwrap();
            fs::hard_link(&scene, &journal).unwrap();
            let begun = Journal::begin(&record, folder.path(), &files, continues);
            assert!(begun.is_ok());
            fs::remove_file(&journal).unwrap();
            std::os::unix::fs::symlink(&scene, &journal).unwrap();
            let begun = Journal::begin(&record, folder.path(), &files, continues).map(|_| ());
            assert!(begun.is_err_and(|failure| failure.to_string().contains("this is the scene")));
            assert_eq!(fs::read_to_string(&scene).unwrap(), "(version: 1)");
        }
    }
}
