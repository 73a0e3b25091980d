//! Rows of a sweep as columns, in Parquet files.
//!
//! Data frames, databases and data-set libraries open Parquet. Files are not compressed, since a row has 200 bytes and
//! its sound has 100 000. Equal tables give equal files to the byte.

use ca_lab::Failure;
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::path::Path;
use std::sync::Arc;

/// Values of a column; `None` where a row has none.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Integers, present in every row.
    Whole(Vec<i64>),
    /// Numbers.
    Number(Vec<Option<f64>>),
    /// Texts.
    Text(Vec<Option<String>>),
}

/// Named columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunTable {
    /// Columns in order.
    pub columns: Vec<(String, Column)>,
}

impl Column {
    fn extend(&mut self, more: Column) -> bool {
        match (self, more) {
            (Column::Whole(a), Column::Whole(b)) => a.extend(b),
            (Column::Number(a), Column::Number(b)) => a.extend(b),
            (Column::Text(a), Column::Text(b)) => a.extend(b),
            _ => return false,
        }
        true
    }
}

fn levels<T>(values: &[Option<T>]) -> Vec<i16> {
    values.iter().map(|v| i16::from(v.is_some())).collect()
}

impl RunTable {
    /// Returns the column of this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|c| c.0 == name).map(|c| &c.1)
    }

    /// Appends the rows of another table.
    ///
    /// # Errors
    /// [`Failure::Failed`] where the columns differ.
    pub fn append(&mut self, other: RunTable) -> Result<(), Failure> {
        if self.columns.is_empty() {
            *self = other;
            return Ok(());
        }
        let names = |t: &RunTable| t.columns.iter().map(|c| c.0.clone()).collect::<Vec<_>>();
        let same = names(self) == names(&other);
        if !same || !self.columns.iter_mut().zip(other.columns).all(|(a, b)| a.1.extend(b.1)) {
            return Err(Failure::Failed("the tables have different columns".into()));
        }
        Ok(())
    }

    /// Moves the named columns into the first table, all others into the second.
    pub fn split(self, names: &[&str]) -> (RunTable, RunTable) {
        let (with, without) = self.columns.into_iter().partition(|c| names.contains(&c.0.as_str()));
        (RunTable { columns: with }, RunTable { columns: without })
    }

    /// Writes the table to a file, with `about` as metadata.
    ///
    /// # Errors
    /// [`Failure::Failed`] with the file's name.
    pub fn write(&self, path: &Path, about: &[(&str, String)]) -> Result<(), Failure> {
        let fail = |e: String| Failure::Failed(format!("`{}` cannot be written: {e}", path.display()));
        let bytes = self.bytes(about).map_err(|e| fail(e.to_string()))?;
        Ok(ca_io::atomic_file::write(path, &bytes)?)
    }

    fn bytes(&self, about: &[(&str, String)]) -> Result<Vec<u8>, ParquetError> {
        let field = |(name, column): &(String, Column)| {
            let (kind, means, repeats) = match column {
                Column::Whole(_) => (Physical::INT64, ConvertedType::NONE, Repetition::REQUIRED),
                Column::Number(_) => (Physical::DOUBLE, ConvertedType::NONE, Repetition::OPTIONAL),
                Column::Text(_) => (Physical::BYTE_ARRAY, ConvertedType::UTF8, Repetition::OPTIONAL),
            };
            let builder = Type::primitive_type_builder(name, kind);
            builder.with_converted_type(means).with_repetition(repeats).build().map(Arc::new)
        };
        let fields = self.columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
        let schema = Arc::new(Type::group_type_builder("rows").with_fields(fields).build()?);
        let about = about.iter().map(|(k, v)| KeyValue::new((*k).to_owned(), v.clone())).collect();
        let properties = WriterProperties::builder().set_key_value_metadata(Some(about)).build();
        let mut file = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
        let mut group = file.next_row_group()?;
        for (_, column) in &self.columns {
            let Some(mut to) = group.next_column()? else { break };
            match (to.untyped(), column) {
                (ColumnWriter::Int64ColumnWriter(w), Column::Whole(v)) => w.write_batch(v, None, None)?,
                (ColumnWriter::DoubleColumnWriter(w), Column::Number(v)) => {
                    let there: Vec<f64> = v.iter().flatten().copied().collect();
                    w.write_batch(&there, Some(&levels(v)), None)?
                }
                (ColumnWriter::ByteArrayColumnWriter(w), Column::Text(v)) => {
                    let there: Vec<ByteArray> = v.iter().flatten().map(|t| ByteArray::from(t.as_str())).collect();
                    w.write_batch(&there, Some(&levels(v)), None)?
                }
                _ => return Err(ParquetError::General("a column has another type".into())),
            };
            to.close()?;
        }
        group.close()?;
        file.into_inner()
    }

    /// Reads a file written by [`RunTable::write`].
    ///
    /// # Errors
    /// [`Failure::Failed`] where the file does not exist or is damaged.
    pub fn read(path: &Path) -> Result<RunTable, Failure> {
        let fail = |e: String| Failure::Failed(format!("`{}` cannot be read: {e}", path.display()));
        let file = std::fs::File::open(path).map_err(|e| fail(ca_lab::load::reason(&e)))?;
        RunTable::of(file).map_err(|e| fail(e.to_string()))
    }

    fn of(file: std::fs::File) -> Result<RunTable, ParquetError> {
        let reader = SerializedFileReader::new(file)?;
        let about = reader.metadata();
        let n = usize::try_from(about.file_metadata().num_rows()).unwrap_or(0);
        let mut columns = Vec::new();
        for (k, field) in about.file_metadata().schema_descr().columns().iter().enumerate() {
            let mut levels = Vec::new();
            let column = match reader.get_row_group(0)?.get_column_reader(k)? {
                ColumnReader::Int64ColumnReader(mut r) => {
                    let mut values = Vec::new();
                    r.read_records(n, None, None, &mut values)?;
                    Column::Whole(values)
                }
                ColumnReader::DoubleColumnReader(mut r) => {
                    let mut values = Vec::new();
                    r.read_records(n, Some(&mut levels), None, &mut values)?;
                    let mut there = values.into_iter();
                    Column::Number(levels.iter().map(|l| if *l > 0 { there.next() } else { None }).collect())
                }
                ColumnReader::ByteArrayColumnReader(mut r) => {
                    let mut values = Vec::new();
                    r.read_records(n, Some(&mut levels), None, &mut values)?;
                    let text = |b: ByteArray| b.as_utf8().map(str::to_owned);
                    let texts = values.into_iter().map(text).collect::<Result<Vec<_>, _>>()?;
                    let mut there = texts.into_iter();
                    Column::Text(levels.iter().map(|l| if *l > 0 { there.next() } else { None }).collect())
                }
                _ => return Err(ParquetError::General("a column has an unsupported type".into())),
            };
            columns.push((field.name().to_owned(), column));
        }
        Ok(RunTable { columns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(n: i64) -> RunTable {
        let number = |k: i64| (k % 3 != 0).then_some(k as f64 / 7.0);
        let text = |k: i64| (k % 2 == 0).then(|| format!("run {k} å"));
        RunTable {
            columns: vec![
                ("index".into(), Column::Whole((0..n).collect())),
                ("string.k".into(), Column::Number((0..n).map(number).collect())),
                ("none".into(), Column::Number(vec![None; n as usize])),
                ("message".into(), Column::Text((0..n).map(text).collect())),
            ],
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.parquet");
        for n in [0, 1, 5000] {
            table(n).write(&path, &[("version", "1".into())]).unwrap();
            let first = std::fs::read(&path).unwrap();
            assert_eq!(RunTable::read(&path).unwrap(), table(n));
            table(n).write(&path, &[("version", "1".into())]).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), first, "the same bytes");
        }
    }

    #[test]
    fn tables_are_put_together_and_taken_apart() {
        let mut all = table(3);
        let (a, b) = all.clone().split(&["message"]);
        assert_eq!((a.columns.len(), b.columns.len()), (1, 3));
        assert!(all.append(a).is_err());
        all.append(table(3)).unwrap();
        assert_eq!(all.column("index"), Some(&Column::Whole(vec![0, 1, 2, 0, 1, 2])));
    }

    #[test]
    fn what_is_no_table_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.parquet");
        assert!(matches!(RunTable::read(&path), Err(Failure::Failed(e)) if e.contains("t.parquet")));
        std::fs::write(&path, b"PAR1 nothing of the kind PAR1").unwrap();
        assert!(matches!(RunTable::read(&path), Err(Failure::Failed(_))));
        table(100).write(&path, &[]).unwrap();
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        assert!(RunTable::read(&path).is_err());
    }
}
