//! OBJ clouds: `v x y z`, `f` and `l`, with point numbers from 1, or from −1 backwards.
//!
//! This module reads these three keywords itself and ignores all others, because the libraries make arrays for a
//! renderer. tobj and obj-rs drop points that no face uses and sort the others by first use, so `bell[17]` would not be
//! point 17 of the drawing. obj keeps only 32 bits of a coordinate.

use super::Drawing;
use crate::error::{FileError, shown};

pub(super) fn read(bytes: &[u8]) -> Result<Drawing, FileError> {
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes));
    let mut d = Drawing::default();
    let mut lines = super::lines(&text).map(|l| l.split('#').next().unwrap_or("").trim_end()).enumerate();
    while let Some((i, mut line)) = lines.next() {
        let mut joined = String::new();
        // `\` at the end continues the line
        while let Some(begun) = line.strip_suffix('\\') {
            joined.extend([begun, " "]);
            line = lines.next().map_or("", |l| l.1);
        }
        joined.push_str(line);
        let mut words = joined.split_whitespace();
        let wrong = |what: String, fix: &str| Err(FileError::content(what).at(format!("line {}", i + 1)).fix(fix));
        let key = words.next();
        match key {
            Some("v") => {
                let mut p = [f64::NAN; 3];
                for p in &mut p {
                    let word = words.next().unwrap_or("");
                    *p = word.parse().unwrap_or(f64::NAN);
                    if !p.is_finite() {
                        let what = if word.is_empty() {
                            "a number is missing".into()
                        } else {
                            format!("`{}` is not a number", shown(word))
                        };
                        let comma = word.contains(',');
                        return wrong(what, if comma { super::POINT } else { "write a point as `v x y z`" });
                    }
                }
                d.points.push(p);
                super::not_too_many(d.points.len())?;
            }
            Some("f" | "l") => {
                let mut corners = Vec::new();
                for word in words {
                    // `3/1/2` is point 3 with a texture coordinate and a normal
                    let n: i64 = word.split('/').next().and_then(|w| w.parse().ok()).unwrap_or(0);
                    let at = if n < 0 { d.points.len() as i64 + n } else { n - 1 };
                    match u32::try_from(at) {
                        Ok(at) if (at as usize) < d.points.len() => corners.push(at),
                        _ => {
                            let what = format!("`{}` is not the number of a point", shown(word));
                            return wrong(what, "points are counted from 1 and defined before they are used");
                        }
                    }
                }
                if key == Some("f") { d.faces.push(corners) } else { d.lines.push(corners) }
            }
            _ => {}
        }
    }
    Ok(d)
}
