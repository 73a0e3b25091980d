//! CSV clouds: one point `x,y,z` in each row, with or without a header.
//!
//! A first row that is not three numbers is a header; it may name other columns beside `x`, `y` and `z`. Each row must
//! have as many cells as the first, so `0,1,0,0` for three numbers with decimal commas is refused. A comma at the end
//! of a row and blank lines are ignored. Lines beginning with `#` are comments. There are no edges: a model joins near
//! points by `reach`.

use super::Drawing;
use crate::error::{FileError, shown};
use crate::gesture::csv::Rows;
use ::csv::ByteRecord;

const COLUMNS: &str = "separate columns by commas and write decimals with a point";

pub(super) fn read(bytes: &[u8]) -> Result<Drawing, FileError> {
    let mut rows = Rows::new(bytes);
    let (mut d, mut columns, mut width) = (Drawing::default(), None, 0);
    while let Some((line, mut row)) = rows.next()? {
        // a comma at the end does not begin a column
        if row.iter().next_back().is_some_and(<[u8]>::is_empty) && (columns.is_none() || row.len() == width + 1) {
            row.truncate(row.len() - 1);
        }
        if columns.is_some() && row.len() > width {
            let e = FileError::content(format!("the row has {} cells, but the first row has {width}", row.len()));
            return Err(e.at(format!("line {line}")).fix(COLUMNS));
        }
        let [x, y, z] = if let Some(known) = columns {
            known
        } else {
            let (found, named) = header(&row, line)?;
            (columns, width) = (Some(found), row.len());
            if named {
                continue;
            }
            found
        };
        d.points.push([number(&row, x, line)?, number(&row, y, line)?, number(&row, z, line)?]);
        super::not_too_many(d.points.len())?;
    }
    Ok(d)
}

/// Returns the columns of x, y and z, and whether this row named them.
fn header(row: &ByteRecord, line: u64) -> Result<([usize; 3], bool), FileError> {
    if row.len() == 3 && (0..3).all(|c| number(row, c, line).is_ok()) {
        return Ok(([0, 1, 2], false));
    }
    let find = |name: &str| row.iter().position(|c| c.eq_ignore_ascii_case(name.as_bytes()));
    if let (Some(x), Some(y), Some(z)) = (find("x"), find("y"), find("z")) {
        return Ok(([x, y, z], true));
    }
    let e = FileError::content("the first row is neither three numbers nor a header with `x`, `y` and `z`");
    Err(e.at(format!("line {line}")).fix(COLUMNS))
}

fn number(row: &ByteRecord, column: usize, line: u64) -> Result<f64, FileError> {
    let text = row.get(column).map(|c| String::from_utf8_lossy(c).into_owned()).unwrap_or_default();
    let wrong = |what: String| {
        let e = FileError::content(what).at(format!("line {line}, column {}", column + 1));
        e.fix("write it like `-1.5e-3`, without a unit")
    };
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ if text.is_empty() => Err(wrong("the number is missing".into())),
        _ => Err(wrong(format!("`{}` is not a number", shown(&text)))),
    }
}
