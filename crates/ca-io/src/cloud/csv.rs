//! CSV clouds: a point in each row, `x,y,z`, after a header or without one.
//!
//! Decides that a first row which is not three numbers is a header, and that a header may hold other columns beside
//! `x`, `y` and `z`. Lines beginning with `#` are comments. There are no edges: a model joins what is near by `reach`.

use super::Drawing;
use crate::error::{FileError, lower, shown};
use ::csv::{ByteRecord, ReaderBuilder, Trim};

/// Reads a CSV cloud.
pub(super) fn read(bytes: &[u8]) -> Result<Drawing, FileError> {
    let mut rows = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes));
    let (mut d, mut columns, mut row) = (Drawing::default(), None, ByteRecord::new());
    loop {
        let more = rows.read_byte_record(&mut row);
        if !more.map_err(|e| FileError::format(lower(&e.to_string())))? {
            return Ok(d);
        }
        let line = row.position().map_or(0, ::csv::Position::line);
        let [x, y, z] = if let Some(known) = columns {
            known
        } else {
            let (found, named) = header(&row, line)?;
            columns = Some(found);
            if named {
                continue;
            }
            found
        };
        d.points.push([number(&row, x, line)?, number(&row, y, line)?, number(&row, z, line)?]);
        super::not_too_many(d.points.len())?;
    }
}

/// The columns of x, y and z, and whether this row named them.
fn header(row: &ByteRecord, line: u64) -> Result<([usize; 3], bool), FileError> {
    if row.len() == 3 && (0..3).all(|c| number(row, c, line).is_ok()) {
        return Ok(([0, 1, 2], false));
    }
    let find = |name: &str| row.iter().position(|c| c.eq_ignore_ascii_case(name.as_bytes()));
    if let (Some(x), Some(y), Some(z)) = (find("x"), find("y"), find("z")) {
        return Ok(([x, y, z], true));
    }
    let e = FileError::content("the first row is neither three numbers nor a header with `x`, `y` and `z`");
    Err(e.at(format!("line {line}")).fix("separate columns by commas and write decimals with a point"))
}

fn number(row: &ByteRecord, column: usize, line: u64) -> Result<f64, FileError> {
    let text = row.get(column).map(|c| String::from_utf8_lossy(c).into_owned()).unwrap_or_default();
    let wrong = |what: String| {
        let e = FileError::content(what).at(format!("line {line}, column {}", column + 1));
        e.fix("write it like `-1.5e-3`, without a unit")
    };
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ if text.is_empty() => Err(wrong("there is no number".into())),
        _ => Err(wrong(format!("`{}` is not a number", shown(&text)))),
    }
}
