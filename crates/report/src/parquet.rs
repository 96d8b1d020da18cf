//! Tables as Apache Parquet: columns of doubles, 64-bit integers, booleans and texts, any value of which may be absent.

use std::io::{self, Write};
use std::sync::Arc;

use lab::{Column, Kind, Value};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

/// Rows that are collected and written together.
const GROUP: usize = 1 << 14;

/// Writes a table row by row, in memory that does not grow with its length.
pub struct Parquet<W: Write + Send> {
    file: SerializedFileWriter<W>,
    kinds: Vec<Kind>,
    rows: Vec<Vec<Value>>,
}

impl<W: Write + Send> Parquet<W> {
    /// Begins a table with these columns; `name` is that of its schema.
    ///
    /// # Errors
    /// If `to` cannot be written.
    pub fn new(to: W, name: &str, columns: &[Column]) -> io::Result<Self> {
        let fields = columns.iter().map(|column| {
            let physical = match column.kind {
                Kind::Number => Physical::DOUBLE,
                Kind::Count => Physical::INT64,
                Kind::Flag => Physical::BOOLEAN,
                Kind::Text => Physical::BYTE_ARRAY,
            };
            let text = (column.kind == Kind::Text).then_some(LogicalType::String);
            let field = Type::primitive_type_builder(&column.name, physical);
            field
                .with_repetition(Repetition::OPTIONAL)
                .with_logical_type(text)
                .build()
                .map(Arc::new)
        });
        let fields: Vec<_> = fields.collect::<Result<_, _>>().map_err(written)?;
        let schema = Type::group_type_builder(name).with_fields(fields).build().map_err(written)?;
        let properties =
            Arc::new(WriterProperties::builder().set_created_by("sandbox".to_owned()).build());
        let file = SerializedFileWriter::new(to, Arc::new(schema), properties).map_err(written)?;
        Ok(Self {
            file,
            kinds: columns.iter().map(|column| column.kind).collect(),
            rows: Vec::new(),
        })
    }

    /// Adds a row with a value for each column.
    ///
    /// # Errors
    /// If the rows cannot be written.
    pub fn add(&mut self, row: Vec<Value>) -> io::Result<()> {
        self.rows.push(row);
        if self.rows.len() >= GROUP { self.write() } else { Ok(()) }
    }

    /// Writes the remaining rows and returns the writer given to [`Self::new`].
    ///
    /// # Errors
    /// If the rows cannot be written.
    pub fn finish(mut self) -> io::Result<W> {
        if !self.rows.is_empty() {
            self.write()?;
        }
        self.file.into_inner().map_err(written)
    }

    fn write(&mut self) -> io::Result<()> {
        let rows = std::mem::take(&mut self.rows);
        let mut group = self.file.next_row_group().map_err(written)?;
        for (at, kind) in self.kinds.iter().enumerate() {
            let values = rows.iter().map(|row| &row[at]);
            let done = match kind {
                Kind::Number => column::<DoubleType, _>(&mut group, values, |value| match value {
                    Value::Number(number) if number.is_finite() => Some(*number),
                    _ => None,
                }),
                Kind::Count => column::<Int64Type, _>(&mut group, values, |value| match value {
                    Value::Count(count) => i64::try_from(*count).ok(),
                    _ => None,
                }),
                Kind::Flag => column::<BoolType, _>(&mut group, values, |value| match value {
                    Value::Flag(flag) => Some(*flag),
                    _ => None,
                }),
                Kind::Text => column::<ByteArrayType, _>(&mut group, values, |value| match value {
                    Value::Text(text) => Some(ByteArray::from(&**text)),
                    _ => None,
                }),
            };
            done.map_err(written)?;
        }
        group.close().map(drop).map_err(written)
    }
}

/// Writes the next column of a group of rows: the values that are present, and which of all values these are.
fn column<'v, T: DataType<T = V>, V>(
    group: &mut SerializedRowGroupWriter<'_, impl Write + Send>,
    values: impl Iterator<Item = &'v Value>,
    pick: impl Fn(&Value) -> Option<V>,
) -> Result<(), ParquetError> {
    let (mut present, mut levels) = (Vec::new(), Vec::new());
    for value in values.map(pick) {
        levels.push(i16::from(value.is_some()));
        present.extend(value);
    }
    let mut writer = group
        .next_column()?
        .ok_or_else(|| ParquetError::General("a column too many".to_owned()))?;
    writer.typed::<T>().write_batch(&present, Some(&levels), None)?;
    writer.close()
}

/// The I/O error that caused an error of the table, if there is one.
fn written(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(other) => io::Error::other(other),
        },
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader as _, SerializedFileReader};
    use parquet::record::RowAccessor as _;

    use super::*;

    #[test]
    fn a_reader_of_parquet_finds_every_value() {
        let columns = [
            ("run", Kind::Count),
            ("method", Kind::Text),
            ("survives", Kind::Flag),
            ("never", Kind::Number),
            ("speed_m_s", Kind::Number),
        ];
        let columns = columns.map(|(name, kind)| Column::new(name, kind));
        let mut table = Parquet::new(Vec::new(), "runs", &columns).unwrap();
        let row = |run: u64| {
            let speed =
                if run.is_multiple_of(3) { Value::Absent } else { Value::Number(run as f64 / 3.0) };
            let (method, survives) =
                (Value::Text(format!("m{}", run % 9)), Value::Flag(run.is_multiple_of(2)));
            vec![Value::Count(run), method, survives, Value::Absent, speed]
        };
        // More than one group.
        let rows = GROUP as u64 + 1000;
        (0..rows).for_each(|run| table.add(row(run)).unwrap());
        let bytes = table.finish().unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        assert_eq!(reader.metadata().num_row_groups(), 2);
        let mut found = 0;
        for (run, read) in (0_u64..).zip(reader.get_row_iter(None).unwrap()) {
            let read = read.unwrap();
            assert_eq!(u64::try_from(read.get_long(0).unwrap()), Ok(run));
            assert_eq!(read.get_string(1).unwrap(), &format!("m{}", run % 9));
            assert_eq!(read.get_bool(2).unwrap(), run.is_multiple_of(2));
            assert!(read.get_double(3).is_err());
            assert_eq!(
                read.get_double(4).ok(),
                (!run.is_multiple_of(3)).then_some(run as f64 / 3.0)
            );
            found += 1;
        }
        assert_eq!(found, rows);
    }
}
