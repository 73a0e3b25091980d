//! OBJ clouds: `v x y z`, `f` and `l` with numbers of points from 1, or from −1 backwards.
//!
//! Decides to read these three words itself and to pass over all others. The libraries there are (tobj, obj-rs) make
//! arrays for a renderer: they drop points no face uses and put the others in the order of their use, so that `bell[17]`
//! would not be the point 17 of the drawing.

use super::Drawing;
use crate::error::FileError;

/// Reads an OBJ cloud.
pub(super) fn read(bytes: &[u8]) -> Result<Drawing, FileError> {
    let text = String::from_utf8_lossy(bytes);
    let mut d = Drawing::default();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("");
        let mut words = line.split_whitespace();
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
                            format!("`{word}` is not a number")
                        };
                        return wrong(what, "a point is `v x y z`");
                    }
                }
                d.points.push(p);
                super::not_too_many(d.points.len())?;
            }
            Some("f" | "l") => {
                let mut corners = Vec::new();
                for word in words {
                    // `3/1/2` is point 3 with a place in a picture and a normal
                    let n: i64 = word.split('/').next().and_then(|w| w.parse().ok()).unwrap_or(0);
                    let at = if n < 0 { d.points.len() as i64 + n } else { n - 1 };
                    match u32::try_from(at) {
                        Ok(at) if (at as usize) < d.points.len() => corners.push(at),
                        _ => return wrong(format!("`{word}` is no point"), "points count from 1, and stand above"),
                    }
                }
                if key == Some("f") { d.faces.push(corners) } else { d.lines.push(corners) }
            }
            _ => {}
        }
    }
    Ok(d)
}
