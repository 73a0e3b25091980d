//! CSV gestures: a header `time, name…`, then one line per moment.
//!
//! ```text
//! # recorded by hand
//! time, key, finger
//! 0,    0,   0.001
//! 0.1,  ,    0.002
//! 0.2,  -0.005,
//! ```
//!
//! Time \[s\] is a column, not a rate in the header: a hand-written key stroke needs three lines, not three thousand.
//! Time may repeat (a jump) but not decrease. A blank cell is interpolated between the neighbours in its column. Blank
//! lines are skipped, and a comma at the end of a line does not begin a column. Lines beginning with `#` are comments.
//! Only commas separate, and only points are decimal: guessing would turn `1,5` into two columns.

use super::track::too_long;
use super::{Gesture, LONGEST, Track};
use crate::error::{FileError, FileErrorKind, lower, shown};
use ::csv::{ByteRecord, ReaderBuilder, Trim};
use ca_core::internal::numeric::Plain;

pub(super) fn read(bytes: &[u8]) -> Result<Gesture, FileError> {
    let mut rows = Rows::new(bytes);
    let Some((line, head)) = rows.next()? else {
        return Err(FileError::content("the file is empty").fix("begin it with a header: `time,name…`"));
    };
    let names = header(line, &head)?;
    let mut columns: Vec<Vec<(f64, f64)>> = vec![Vec::new(); names.len()];
    let mut before = f64::NEG_INFINITY;
    while let Some((line, mut row)) = rows.next()? {
        if row.len() == names.len() + 2 && row.iter().next_back().is_some_and(<[u8]>::is_empty) {
            row.truncate(names.len() + 1);
        }
        if row.len() != names.len() + 1 {
            let e = FileError::content(format!(
                "the line has {}, but the header has {}",
                cells(row.len()),
                names.len() + 1
            ));
            return Err(e.at(format!("line {line}")).fix("leave a cell blank, between commas, to interpolate"));
        }
        let Some(time) = number(line, 0, "time", &row[0])? else {
            return Err(FileError::content("the time is blank").at(place(line, 0, "time")).fix("write it in seconds"));
        };
        if time.abs() > LONGEST {
            return Err(too_long(time).at(place(line, 0, "time")));
        }
        if time < before {
            let e = FileError::content(format!("time runs backwards, from {} s to {} s", Plain(before), Plain(time)));
            return Err(e.at(place(line, 0, "time")).fix("sort the lines by time"));
        }
        before = time;
        for (c, points) in columns.iter_mut().enumerate() {
            if let Some(value) = number(line, c + 1, &names[c], &row[c + 1])? {
                points.push((time, value));
            }
        }
    }
    if before == f64::NEG_INFINITY {
        return Err(FileError::content("no line follows the header").fix("write one line for each time"));
    }
    let tracks = names.into_iter().zip(columns).enumerate().map(|(c, (name, points))| {
        if points.is_empty() {
            let e = FileError::content("all cells are blank").at(format!("column {} (`{}`)", c + 2, shown(&name)));
            return Err(e.fix("give it a value or remove the column"));
        }
        Track::points(name, points)
    });
    Gesture::new(tracks.collect::<Result<_, _>>()?)
}

fn header(line: u64, head: &ByteRecord) -> Result<Vec<String>, FileError> {
    let mut names: Vec<String> = Vec::with_capacity(head.len());
    // a comma at the end does not begin a column
    let blank_end = head.len() > 1 && head.iter().next_back().is_some_and(<[u8]>::is_empty);
    for (c, cell) in head.iter().take(head.len() - usize::from(blank_end)).enumerate() {
        let at = format!("line {line}, column {}", c + 1);
        let name = std::str::from_utf8(cell)
            .map_err(|_| FileError::content("the name is not UTF-8").at(&at).fix("save the file as UTF-8"))?;
        if c == 0 && name != "time" {
            let e = FileError::content(format!("the first column is `{}`, not `time`", shown(name))).at(at);
            return Err(if name.starts_with("time") && name.contains([';', '\t']) {
                e.fix("separate columns by commas and write decimals with a point")
            } else if name.eq_ignore_ascii_case("time") {
                e.fix("write it in lower case")
            } else {
                e.fix("begin the file with a header `time,name…`, time in seconds")
            });
        }
        if name.is_empty() {
            return Err(FileError::content("the column has no name").at(at).fix("name it after the port it moves"));
        }
        if let Some(first) = names.iter().position(|n| n == name) {
            let e = FileError::content(format!("`{}` already names column {}", shown(name), first + 1)).at(at);
            return Err(e.fix("rename or remove one of the two"));
        }
        names.push(name.to_owned());
    }
    if names.len() < 2 {
        let e = FileError::content("`time` is the only column").at(format!("line {line}"));
        return Err(e.fix("add a column named after the port it moves"));
    }
    names.remove(0);
    Ok(names)
}

fn place(line: u64, column: usize, name: &str) -> String {
    format!("line {line}, column {} (`{}`)", column + 1, shown(name))
}

fn cells(n: usize) -> String {
    if n == 1 { "1 cell".to_owned() } else { format!("{n} cells") }
}

fn number(line: u64, column: usize, name: &str, cell: &[u8]) -> Result<Option<f64>, FileError> {
    if cell.is_empty() {
        return Ok(None);
    }
    let text = String::from_utf8_lossy(cell);
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(Some(v)),
        Ok(_) => {
            let e =
                FileError::content(format!("`{}` is not a finite number", shown(&text))).at(place(line, column, name));
            Err(e.fix("leave the cell blank to interpolate"))
        }
        Err(_) => {
            let e = FileError::content(format!("`{}` is not a number", shown(&text)));
            Err(e.at(place(line, column, name)).fix("write it like `-1.5e-3`, without a unit"))
        }
    }
}

/// Reads the lines that have a cell and are not comments, with their numbers.
pub(crate) struct Rows<'a> {
    reader: ::csv::Reader<&'a [u8]>,
    bytes: &'a [u8],
    row: ByteRecord,
    /// Byte and line up to which lines have been counted.
    counted: (usize, u64),
}

impl<'a> Rows<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Rows<'a> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut builder = ReaderBuilder::new();
        builder.has_headers(false).flexible(true).trim(Trim::All).comment(Some(b'#'));
        Rows { reader: builder.from_reader(bytes), bytes, row: ByteRecord::new(), counted: (0, 1) }
    }

    pub(crate) fn next(&mut self) -> Result<Option<(u64, ByteRecord)>, FileError> {
        loop {
            let more = self.reader.read_byte_record(&mut self.row);
            let no_csv = |e: ::csv::Error| format!("it is not CSV: {}", lower(&e.to_string()));
            if !more.map_err(|e| FileError::new(FileErrorKind::Format, no_csv(e)))? {
                return Ok(None);
            }
            if !self.row.iter().all(<[u8]>::is_empty) {
                break;
            }
        }
        let start = self.row.position().map_or(0, ::csv::Position::byte) as usize;
        Ok(Some((self.line_of(start), self.row.clone())))
    }

    /// Returns the line of the record that starts at byte `start`, where the parser has not yet skipped blank lines and
    /// comments.
    fn line_of(&mut self, start: usize) -> u64 {
        let (mut at, mut line) = self.counted;
        while at < self.bytes.len() {
            let end = self.bytes[at..].iter().position(|b| *b == b'\n').map_or(self.bytes.len(), |n| at + n + 1);
            let text = &self.bytes[at..end];
            let skipped = text.first() == Some(&b'#') || text.iter().all(|b| matches!(b, b'\r' | b'\n'));
            if at >= start && !skipped {
                break;
            }
            at = end;
            line += 1;
        }
        self.counted = (at, line);
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn says(text: &str, parts: &[&str]) {
        let e = read(text.as_bytes()).expect_err(text).to_string();
        for part in parts {
            assert!(e.contains(part), "{text:?} says {e:?}, without {part:?}");
        }
    }

    #[test]
    fn reads_columns_comments_and_blank_cells() {
        let text = "# by hand\n time , key,finger\n0,0,0.001\n\n0.1,,0.002\n# rest\n0.2,-0.005,\n";
        let g = read(text.as_bytes()).unwrap();
        assert_eq!(g.tracks().iter().map(Track::name).collect::<Vec<_>>(), ["key", "finger"]);
        let (key, finger) = (g.track("key").unwrap(), g.track("finger").unwrap());
        assert_eq!((key.n_points(), finger.n_points()), (2, 2));
        assert_eq!(key.at(0.1), -0.0025);
        assert_eq!(finger.at(0.2), 0.002);
        assert_eq!(g.duration(), 0.2);
        // other line ends, a byte order mark, quotes, a last line without an end, a jump
        let g = read(b"\xef\xbb\xbftime,\"the key\"\r\n0,1\r\n1,1\r\n1,\"2\"").unwrap();
        assert_eq!(g.track("the key").unwrap().at(1.0), 2.0);
        // commas at the end of all or some lines; lines of blanks and of commas
        for text in ["time,key,\n0,0,\n0.5,1,\n", "time,key\n0,0,\n0.5,1\n", " \ntime,key\n0,0\n \t \n,,\n0.5,1\n  "] {
            let g = read(text.as_bytes()).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            assert_eq!((g.tracks().len(), g.track("key").unwrap().at(0.25)), (1, 0.5), "{text:?}");
        }
    }

    #[test]
    fn says_where_and_what_to_do() {
        says("", &["empty", "header"]);
        says("# only\n\n", &["empty"]);
        says("time,key\n", &["no line follows the header"]);
        says("0,1\n2,3\n", &["line 1, column 1", "`0`, not `time`", "begin the file with a header"]);
        says("Time,key\n0,0\n", &["lower case"]);
        says("time;key\n0;0\n", &["separate columns by commas"]);
        says("time\n0\n", &["`time` is the only column"]);
        says("time,,b\n0,0,0\n", &["line 1, column 2", "no name"]);
        says("time,a,b,a\n0,0,0,0\n", &["line 1, column 4", "already names column 2"]);
        says("time,time\n0,0\n", &["already names column 1"]);
        says("time,key\n0,0\n# c\n\n0.1,abc\n", &["line 5, column 2 (`key`)", "`abc` is not a number"]);
        says("\n# c\ntime,key\r\n0,0\r\n\r\n0.1,nan\r\n", &["line 6, column 2", "not a finite number"]);
        says("time,key\n0,1e999\n", &["line 2", "not a finite number"]);
        says("time,key\ninf,0\n", &["line 2, column 1 (`time`)"]);
        says("time,key\n1e10,0\n", &["line 2, column 1 (`time`)"]);
        says("time,key\n0,0\n0.2,0\n0.1,0\n", &["line 4", "backwards", "from 0.2 s to 0.1 s"]);
        says("time,key\n0,0\n,1\n", &["line 3", "time is blank"]);
        says("time,key\n0,0\n1\n", &["line 3", "1 cell, but the header has 2"]);
        says("time,key\n0,0,7\n", &["line 2", "3 cells"]);
        says("time,key,,\n0,0,,\n", &["line 1, column 3", "no name"]);
        says("time,key\n  \n0,0,,\n", &["line 3", "4 cells"]);
        says("time,a,b\n0,1,\n1,2,\n", &["column 3 (`b`)", "all cells are blank"]);
        says("time,key\n0,1 mm\n", &["`1 mm`", "without a unit"]);
        says(&format!("\u{1b}[2J{}\n", "n".repeat(99)), &["`\\u{1b}[2Jnnn", "nnn…`, not `time`"]);
        let e = read(b"time,\xff\n0,0\n").unwrap_err();
        assert!(e.to_string().contains("UTF-8"), "{e}");
    }
}
