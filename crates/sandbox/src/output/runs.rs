//! The files of a sweep: a journal to which every run is added, and the table, the figure and the record that are made from it.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufReader, Write as _};
use std::path::{Path, PathBuf};

use csv::{ErrorKind, Reader, ReaderBuilder, StringRecord};
use lab::sweep::{Record, Row};
use lab::{Column, Shard, Value};
use report::Parquet;
use report::sweep::Figure;

use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{Output, read_record, write};

/// File name of the record; it marks a folder as one that the program filled.
pub(crate) const RECORD: &str = "sweep.json";
/// File name of the journal: the runs so far, in order.
const JOURNAL: &str = "runs.part.csv";
const TABLE: &str = "runs.csv";
const PARQUET: &str = "runs.parquet";
const FIGURE: &str = "sweep.svg";

/// Whether a sweep writes a file of that name.
pub(crate) fn is_file(name: &str) -> bool {
    [RECORD, JOURNAL, TABLE, PARQUET, FIGURE].contains(&name)
}

/// Whether all files of a complete sweep are in `folder`.
pub(crate) fn are_there(folder: &Path) -> bool {
    [TABLE, PARQUET, FIGURE].iter().all(|name| folder.join(name).exists())
}

/// The record in `folder`, if there is one.
pub(crate) fn record(folder: &Path) -> Result<Option<Record>, Failure> {
    read_record(&folder.join(RECORD), "record of a sweep")
}

/// Writes the record of a sweep into `folder`.
pub(crate) fn write_record(
    record: &Record,
    folder: &Path,
    files: &CommandFiles,
) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(record).expect("a record is plain data") + "\n";
    write(&files.unread(&folder.join(RECORD))?, text.as_bytes())
}

/// The runs of an unfinished sweep. A run that was added stays, whatever ends the program.
pub(crate) struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Starts the journal of a sweep in `folder`.
    pub fn begin(record: &Record, folder: &Path) -> Result<Self, Failure> {
        let path = folder.join(JOURNAL);
        let file = File::create(&path).and_then(|mut file| {
            file.write_all(report::sweep::header(&record.plan).as_bytes())?;
            Ok(file)
        });
        let file = file.map_err(|error| Failure::file("write", &path, &error))?;
        Ok(Self { path, file })
    }

    /// Opens the journal in `folder` again, and says how many runs are in it. Removes an incomplete last line.
    pub fn resume(record: &Record, folder: &Path) -> Result<(Self, u64), Failure> {
        let path = folder.join(JOURNAL);
        if !path.exists() {
            return Ok((Self::begin(record, folder)?, 0));
        }
        let failed = |error: &io::Error| Failure::file("read", &path, error);
        let text = fs::read(&path).map_err(|error| failed(&error))?;
        let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let file = OpenOptions::new().append(true).open(&path).map_err(|error| failed(&error))?;
        file.set_len(whole as u64).map_err(|error| Failure::file("write", &path, &error))?;
        let mut runs = Runs::open(record, path.clone())?;
        let mut done = 0;
        while runs.next()?.is_some() {
            done += 1;
        }
        Ok((Self { path, file }, done))
    }

    /// Adds a run.
    pub fn add(&mut self, row: &Row) -> Result<(), Failure> {
        let line = report::sweep::row(&row.values);
        self.file
            .write_all(line.as_bytes())
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
pub(crate) struct Runs {
    path: PathBuf,
    reader: Reader<BufReader<File>>,
    columns: Vec<Column>,
    shard: Shard,
    /// Number of runs that were read.
    place: u64,
    record: StringRecord,
}

impl Runs {
    /// The table of a finished sweep in `folder`.
    pub fn of_folder(record: &Record, folder: &Path) -> Result<Self, Failure> {
        Self::open(record, folder.join(TABLE))
    }

    fn open(record: &Record, path: PathBuf) -> Result<Self, Failure> {
        let file = File::open(&path).map_err(|error| Failure::file("read", &path, &error))?;
        let reader = ReaderBuilder::new().from_reader(BufReader::new(file));
        let (columns, shard) = (record.plan.columns(), record.shard);
        let mut runs = Self { path, reader, columns, shard, place: 0, record: StringRecord::new() };
        let header = runs.reader.headers().cloned();
        let names = runs.columns.iter().map(|column| &*column.name);
        if header.is_ok_and(|header| header.iter().eq(names)) {
            Ok(runs)
        } else {
            Err(runs.damaged("has other columns"))
        }
    }

    /// The next run with the values of its row.
    pub fn next(&mut self) -> Result<Option<(u64, Vec<Value>)>, Failure> {
        match self.reader.read_record(&mut self.record) {
            Ok(true) => {}
            Ok(false) => return Ok(None),
            Err(error) => match error.into_kind() {
                ErrorKind::Io(error) => return Err(Failure::file("read", &self.path, &error)),
                _ => self.record.clear(),
            },
        }
        let fields = self.columns.iter().zip(&self.record);
        let values: Option<Vec<Value>> =
            fields.map(|(column, field)| report::sweep::read(column, field)).collect();
        let run = self.shard.nth(self.place);
        match values {
            Some(values) if values.first() == Some(&Value::Count(run)) => {
                self.place += 1;
                Ok(Some((run, values)))
            }
            _ => Err(self.damaged(&format!("does not have run {run} in line {}", self.place + 2))),
        }
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
    mut sources: Vec<Runs>,
    folder: &Path,
    files: &CommandFiles,
) -> Result<(), Failure> {
    let paths = [TABLE, PARQUET, FIGURE].map(|name| folder.join(name));
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |error: io::Error| Failure::file("write", &path, &error)
    };
    let [table_path, parquet_path, figure_path] = &paths;
    let mut table = Output::create(&files.unread(table_path)?).map_err(failed(table_path))?;
    let parquet = Output::create(&files.unread(parquet_path)?).map_err(failed(parquet_path))?;
    let mut parquet =
        Parquet::new(parquet, "runs", &record.plan.columns()).map_err(failed(parquet_path))?;
    let mut figure = Figure::new(&record.scene, &record.plan);
    table.write_all(report::sweep::header(&record.plan).as_bytes()).map_err(failed(table_path))?;
    let mut heads = Vec::new();
    for source in &mut sources {
        heads.push(source.next()?);
    }
    let mut expected = record.shard.nth(0);
    loop {
        let first =
            (0..heads.len()).min_by_key(|at| heads[*at].as_ref().map_or(u64::MAX, |(run, _)| *run));
        let Some((at, (run, values))) = first.and_then(|at| Some((at, heads[at].take()?))) else {
            break;
        };
        debug_assert_eq!(run, expected, "shards that are all there have every run");
        expected = run + u64::from(record.shard.of());
        table.write_all(report::sweep::row(&values).as_bytes()).map_err(failed(table_path))?;
        figure.add(run, &values);
        parquet.add(values).map_err(failed(parquet_path))?;
        heads[at] = sources[at].next()?;
    }
    let runs: u64 = sources.iter().map(|source| source.place).sum();
    let all = record.shard.count(record.plan.runs().unwrap_or(u64::MAX));
    if runs != all {
        let what = format!("{runs} of {all} runs are in the tables");
        return Err(Failure::Usage(format!("{what}; run the sweep again in another folder")));
    }
    table.finish().map_err(failed(table_path))?;
    parquet.finish().and_then(Output::finish).map_err(failed(parquet_path))?;
    write(&files.unread(figure_path)?, figure.drawing().document().as_bytes())?;
    write_record(&Record { complete: true, ..record.clone() }, folder, files)
}
