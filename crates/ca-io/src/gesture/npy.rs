//! NPY gestures: arrays written by `numpy.save`.
//!
//! An array with named fields (a structured dtype) may have a field `time`, in seconds; its other fields are the
//! tracks. Any other array, of shape `(frames,)` or `(frames, columns)`, has the rate given by the caller and columns
//! `ch0`, `ch1`, …. The first column of a plain array is never taken as time, because that would silently confuse
//! recordings and times. Values are used unscaled, integers too.
//!
//! npyz reads the header and the numbers. This module checks the header first, because a crafted file would crash npyz:
//! it multiplies the shape without overflow checks, recurses for each bracket and each dimension of a field, and
//! allocates the header length given in the file.

use super::{Gesture, Track, check_rate};
use crate::error::{FileError, FileErrorKind, lower, shown};
use ca_core::internal::numeric::Plain;
use half::f16;
use npyz::{DType, Deserialize, NpyHeader, Order, TypeChar, TypeRead as _};

/// Largest number of columns; more are likely a transposed matrix.
const MAX_COLUMNS: usize = 1024;
/// Longest header \[bytes\].
const MAX_HEADER: usize = 1 << 17;
/// Nesting of brackets for a field in the list of fields in the dictionary.
const DEEP: usize = 3;

/// Reads an NPY gesture; `rate` \[Hz\] is for arrays without a field `time`.
pub(super) fn read(bytes: &[u8], rate: Option<f64>) -> Result<Gesture, FileError> {
    let (text, data) = split(bytes)?;
    check(&text)?;
    let head = header(&text)?;
    let (fields, structured) = match head.dtype() {
        DType::Record(fields) => (fields.into_iter().map(|f| (f.name, f.dtype)).collect(), true),
        plain => (vec![(String::new(), plain)], false),
    };
    if fields.len() > MAX_COLUMNS {
        return Err(FileError::new(FileErrorKind::Unsupported, format!("it has more than {MAX_COLUMNS} fields")));
    }
    let shape: Vec<usize> = head.shape().iter().map(|n| usize::try_from(*n).unwrap_or(usize::MAX)).collect();
    let (frames, per_row) = match (&shape[..], structured) {
        (&[n], _) => (n, 1),
        (&[n, k], false) => (n, k),
        (other, _) => {
            let want = if structured { "`(frames,)`" } else { "`(frames,)` or `(frames, columns)`" };
            let e = FileError::new(FileErrorKind::Unsupported, format!("its shape is {other:?}, not {want}"));
            return Err(e.fix("reshape it before saving"));
        }
    };
    if frames == 0 || per_row == 0 {
        return Err(FileError::content("the array is empty"));
    }
    if per_row > MAX_COLUMNS {
        let e = FileError::new(FileErrorKind::Unsupported, format!("it has {per_row} columns and {frames} frames"));
        return Err(e.fix("save it with one row per frame: `numpy.save(file, a.T)`"));
    }
    let sizes = fields.iter().map(|(name, ty)| size(ty, structured && name.is_empty()));
    let sizes = sizes.collect::<Result<Vec<usize>, _>>()?;
    let item = sizes.iter().fold(0, |sum: usize, n| sum.saturating_add(*n));
    let needed = frames.checked_mul(per_row).and_then(|n| n.checked_mul(item));
    if needed.is_none_or(|n| n > data.len()) {
        let what = format!(
            "the file is cut short: {frames} frames are announced, but it has only {} bytes of data",
            data.len()
        );
        return Err(FileError::format(what));
    }
    // from here on, frames × per_row × item ≤ data.len()
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    if structured {
        let mut offset = 0;
        for ((name, ty), size) in fields.into_iter().zip(sizes) {
            if !name.is_empty() {
                let values = column(&ty, (0..frames).map(|r| &data[r * item + offset..][..size]))?;
                columns.push((name, values));
            }
            offset += size;
        }
    } else {
        for c in 0..per_row {
            let index = |r: usize| if head.order() == Order::Fortran { c * frames + r } else { r * per_row + c };
            let values = column(&fields[0].1, (0..frames).map(|r| &data[index(r) * item..][..item]))?;
            columns.push((format!("ch{c}"), values));
        }
    }
    for (name, values) in &columns {
        if let Some(r) = values.iter().position(|v| !v.is_finite()) {
            return Err(FileError::content(format!("the value is {}, not a finite number", values[r]))
                .at(format!("row {r}, column `{name}`")));
        }
    }
    tracks(columns, rate)
}

fn tracks(mut columns: Vec<(String, Vec<f64>)>, rate: Option<f64>) -> Result<Gesture, FileError> {
    let time = columns.iter().position(|c| c.0 == "time").map(|i| columns.remove(i).1);
    if columns.is_empty() {
        return Err(FileError::content("`time` is the only field").fix("add a field named after the port it moves"));
    }
    let made: Result<Vec<Track>, FileError> = match (time, rate) {
        (Some(_), Some(_)) => {
            let e = FileError::usage("the array has a field `time`, but a rate is given too");
            return Err(e.fix("leave out the rate"));
        }
        (None, None) => {
            let e = FileError::usage("the rate of the array is not known");
            return Err(e.fix("give its rate (`--gesture-rate`, in Python `(file, rate)`), for example 3000 Hz, or save it with a field `time`"));
        }
        (None, Some(rate)) => {
            check_rate(rate)?;
            columns.into_iter().map(|(name, v)| Track::sampled(name, rate, v)).collect()
        }
        (Some(time), None) => {
            if let Some(r) = time.windows(2).position(|w| w[1] < w[0]) {
                let what = format!("time runs backwards, from {} s to {} s", Plain(time[r]), Plain(time[r + 1]));
                return Err(FileError::content(what).at(format!("row {}, column `time`", r + 1)).fix("sort the rows"));
            }
            columns.into_iter().map(|(name, v)| Track::points(name, time.iter().copied().zip(v).collect())).collect()
        }
    };
    Gesture::new(made?)
}

fn split(bytes: &[u8]) -> Result<(String, &[u8]), FileError> {
    let short = || FileError::format("the file is cut short in its header");
    let Some(rest) = bytes.strip_prefix(b"\x93NUMPY") else {
        return Err(FileError::format("it is not an NPY file").fix("write it with `numpy.save(file, array)`"));
    };
    let (start, len) = match *rest {
        [1, _, a, b, ..] => (4, usize::from(u16::from_le_bytes([a, b]))),
        [2 | 3, _, a, b, c, d, ..] => (6, u32::from_le_bytes([a, b, c, d]) as usize),
        [v, ..] if !(1..=3).contains(&v) => {
            return Err(FileError::new(FileErrorKind::Unsupported, format!("version {v} of NPY is not supported")));
        }
        _ => return Err(short()),
    };
    let (text, data) = rest[start..].split_at_checked(len).ok_or_else(short)?;
    if len > MAX_HEADER {
        return Err(FileError::unsupported(format!("its header is longer than {MAX_HEADER} bytes")));
    }
    // versions 1 and 2 are Latin-1, version 3 is UTF-8
    let latin = || text.iter().map(|b| char::from(*b)).collect();
    Ok((if rest[0] == 3 { String::from_utf8_lossy(text).into_owned() } else { latin() }, data))
}

fn wrong(what: &str) -> FileError {
    FileError::format(format!("its header has {what}")).fix("write it with `numpy.save(file, array)`")
}

/// Refuses a header that could crash npyz: allows only strings, whole numbers, truth values and few brackets.
fn check(text: &str) -> Result<(), FileError> {
    let (mut deep, mut numbers, mut rest) = (0_usize, 1_u64, text);
    while let Some(c) = rest.chars().next() {
        let mut n = c.len_utf8();
        match c {
            '\'' | '"' => {
                let end = rest[1..].find([c, '\\']).filter(|at| rest[1 + at..].starts_with(c));
                n = 2 + end.ok_or_else(|| wrong("an unterminated string, or a string with a backslash"))?;
            }
            '(' | '[' | '{' => deep += 1,
            ')' | ']' | '}' => deep = deep.saturating_sub(1),
            ',' | ':' | ' ' | '\t' | '\r' | '\n' => {}
            c if c.is_ascii_alphanumeric() => {
                n = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
                let word = &rest[..n];
                if !matches!(word, "True" | "False") {
                    let product = word.parse().ok().and_then(|v: u64| numbers.checked_mul(v.max(1)));
                    numbers = product.ok_or_else(|| wrong("a shape too large for any memory, or an unknown word"))?;
                }
            }
            c => return Err(wrong(&format!("a `{}` outside its strings", shown(&c.to_string())))),
        }
        if deep > DEEP {
            let e = FileError::new(FileErrorKind::Unsupported, "one of its fields is an array or a record");
            return Err(e.fix("save one number per field"));
        }
        rest = &rest[n..];
    }
    Ok(())
}

fn header(text: &str) -> Result<NpyHeader, FileError> {
    let text = text.trim_end();
    let bytes = [&b"\x93NUMPY\x03\0"[..], &(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    NpyHeader::from_reader(&bytes[..]).map_err(|e| {
        let why = e.to_string();
        // the rest of the message is from the parser
        let why = why.split_once(": ").map_or(why.as_str(), |w| if w.0.contains("Python") { w.0 } else { &why });
        let e = FileError::format(format!("its header cannot be read: {}", lower(&shown(why))));
        e.fix("write it with `numpy.save(file, array)`")
    })
}

/// Returns the size of a number of this type, or with `padding` of a gap that aligns the next field \[bytes\].
fn size(ty: &DType, padding: bool) -> Result<usize, FileError> {
    if let DType::Plain(t) = ty {
        let known = match t.type_char() {
            TypeChar::Float => matches!(t.size_field(), 2 | 4 | 8),
            TypeChar::Int | TypeChar::Uint => matches!(t.size_field(), 1 | 2 | 4 | 8),
            TypeChar::RawData => padding && t.size_field() <= 1 << 16,
            _ => false,
        };
        if known && padding == (t.type_char() == TypeChar::RawData) {
            return Ok(t.size_field() as usize);
        }
    }
    let e = FileError::new(
        FileErrorKind::Unsupported,
        format!("numbers of type {} are not supported", shown(&ty.descr()).replace('\'', "`")),
    );
    Err(e.fix("save it as `float64`, `float32`, `float16` or integers: `a.astype(float)`"))
}

/// Reads numbers of any type accepted by [`size`], each from its bytes.
fn column<'b>(ty: &DType, cells: impl Iterator<Item = &'b [u8]>) -> Result<Vec<f64>, FileError> {
    fn all<'b, T: Deserialize>(
        ty: &DType,
        cells: impl Iterator<Item = &'b [u8]>,
        value: fn(T) -> f64,
    ) -> Result<Vec<f64>, FileError> {
        let wrong = |e: &dyn std::fmt::Display| FileError::format(lower(&e.to_string()));
        let reader = T::reader(ty).map_err(|e| wrong(&e))?;
        cells.map(|c| reader.read_one(c).map(value).map_err(|e| wrong(&e))).collect()
    }
    let DType::Plain(t) = ty else { return Err(FileError::unsupported("one of its fields is not a number")) };
    match (t.type_char(), t.size_field()) {
        (TypeChar::Float, 2) => all::<f16>(ty, cells, f64::from),
        (TypeChar::Float, 4) => all::<f32>(ty, cells, f64::from),
        (TypeChar::Int, 1) => all::<i8>(ty, cells, f64::from),
        (TypeChar::Int, 2) => all::<i16>(ty, cells, f64::from),
        (TypeChar::Int, 4) => all::<i32>(ty, cells, f64::from),
        (TypeChar::Int, 8) => all::<i64>(ty, cells, |v| v as f64),
        (TypeChar::Uint, 1) => all::<u8>(ty, cells, f64::from),
        (TypeChar::Uint, 2) => all::<u16>(ty, cells, f64::from),
        (TypeChar::Uint, 4) => all::<u32>(ty, cells, f64::from),
        (TypeChar::Uint, 8) => all::<u64>(ty, cells, |v| v as f64),
        _ => all::<f64>(ty, cells, |v| v),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(header: &str, data: &[u8]) -> Vec<u8> {
        let mut b = b"\x93NUMPY\x01\x00".to_vec();
        b.extend((header.len() as u16).to_le_bytes());
        b.extend(header.as_bytes());
        b.extend(data);
        b
    }

    fn plain(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        npy(&format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}  \n"), data)
    }

    fn values(g: &Gesture, track: usize, n: usize) -> Vec<f64> {
        (0..n).map(|i| g.tracks()[track].at(i as f64)).collect()
    }

    #[test]
    fn reads_every_number_type() {
        for (descr, data, want) in [
            ("<f8", [1.5f64.to_le_bytes(), (-2.0f64).to_le_bytes()].concat(), [1.5, -2.0]),
            (">f8", [1.5f64.to_be_bytes(), (-2.0f64).to_be_bytes()].concat(), [1.5, -2.0]),
            ("<f4", [1.5f32.to_le_bytes(), (-2.0f32).to_le_bytes()].concat(), [1.5, -2.0]),
            (">i2", [300i16.to_be_bytes(), (-300i16).to_be_bytes()].concat(), [300.0, -300.0]),
            ("<i4", [70_000i32.to_le_bytes(), (-1i32).to_le_bytes()].concat(), [70_000.0, -1.0]),
            ("<i8", [i64::MIN.to_le_bytes(), 5i64.to_le_bytes()].concat(), [i64::MIN as f64, 5.0]),
            ("|i1", vec![127, 128], [127.0, -128.0]),
            ("|u1", vec![127, 255], [127.0, 255.0]),
            ("<u2", vec![0, 255, 1, 0], [65280.0, 1.0]),
            ("<f2", vec![0, 0x3e, 0, 0xc0], [1.5, -2.0]),
            (">f2", vec![0x3e, 0, 0xc0, 0], [1.5, -2.0]),
            ("<u8", [u64::MAX.to_le_bytes(), 5u64.to_le_bytes()].concat(), [u64::MAX as f64, 5.0]),
        ] {
            let g = read(&plain(descr, "(2,)", &data), Some(1.0)).unwrap();
            assert_eq!(values(&g, 0, 2), want, "{descr}");
            assert_eq!(g.tracks()[0].name(), "ch0");
        }
    }

    #[test]
    fn rows_and_columns_in_both_orders() {
        let c = plain("|i1", "(3, 2)", &[1, 2, 3, 4, 5, 6]);
        let g = read(&c, Some(1.0)).unwrap();
        assert_eq!((values(&g, 0, 3), values(&g, 1, 3)), (vec![1.0, 3.0, 5.0], vec![2.0, 4.0, 6.0]));
        let f = npy("{'descr': '|i1', 'fortran_order': True, 'shape': (3, 2)}", &[1, 3, 5, 2, 4, 6]);
        assert_eq!(read(&f, Some(1.0)).unwrap(), g);
    }

    #[test]
    fn fields_have_names_and_perhaps_a_time() {
        let rows: Vec<u8> = [(0.0f64, 1i16), (0.5, 3)]
            .iter()
            .flat_map(|(t, x)| [&t.to_le_bytes()[..], &x.to_le_bytes()[..], &[9, 9]].concat())
            .collect();
        let head = |t: &str| {
            format!(
                "{{'shape': (2,), \"fortran_order\": False, 'descr': [('{t}', '<f8'), ('key', '<i2'), ('', '|V2')]}}"
            )
        };
        let g = read(&npy(&head("time"), &rows), None).unwrap();
        assert_eq!(g.tracks().len(), 1);
        assert_eq!((g.track("key").unwrap().at(0.25), g.duration()), (2.0, 0.5));
        let g = read(&npy(&head("finger"), &rows), Some(2.0)).unwrap();
        assert_eq!((g.track("key").unwrap().at(0.5), g.track("finger").unwrap().at(0.5)), (3.0, 0.5));
        let e = read(&npy(&head("time"), &rows), Some(2.0)).unwrap_err();
        assert!(e.to_string().contains("a field `time`"), "{e}");
    }

    #[test]
    fn names_are_latin_1_before_version_3() {
        let head = "{'descr': [('k\u{e9}', '|i1')], 'fortran_order': False, 'shape': (1,)}";
        let mut new = b"\x93NUMPY\x03\x00".to_vec();
        new.extend((head.len() as u32).to_le_bytes());
        new.extend([head.as_bytes(), &[7]].concat());
        let latin: Vec<u8> = head.chars().map(|c| c as u8).collect();
        let mut old = b"\x93NUMPY\x01\x00".to_vec();
        old.extend((latin.len() as u16).to_le_bytes());
        old.extend([latin, vec![7]].concat());
        for file in [new, old] {
            assert_eq!(read(&file, Some(1.0)).unwrap().track("k\u{e9}").unwrap().at(0.0), 7.0);
        }
    }

    #[test]
    fn says_what_is_wrong() {
        let two = [0u8; 16];
        for (file, part) in [
            (b"PK\x03\x04".to_vec(), "not an NPY file"),
            (b"\x93NUMPY".to_vec(), "cut short"),
            (b"\x93NUMPY\x07\x00".to_vec(), "version 7"),
            (b"\x93NUMPY\x02\x00\xff\xff\xff\xff{".to_vec(), "cut short in its header"),
            (plain("<f8", "(3,)", &two), "cut short: 3 frames"),
            (plain("<f8", "(18446744073709551615, 1024)", &two), "a shape too large for any memory"),
            (plain("<f8", "(4611686018427387904, 2)", &two), "cut short"),
            (plain("<f8", "(0, 18446744073709551615, 1024)", &two), "a shape too large for any memory"),
            (plain("<f8", "(0xffffffffffffffff, 1024)", &two), "an unknown word"),
            (plain("<f8", "(-1,)", &two), "a `-` outside its strings"),
            (plain("<m8[s]", "(1,)", &two), "type `<m8[s]`"),
            (plain("<f8", "(99999999999999999999999,)", &two), "shape"),
            (plain("<f8", "()", &two), "shape is []"),
            (plain("<f8", "(1, 1, 1)", &two), "shape is [1, 1, 1]"),
            (plain("<f8", "(0,)", &two), "empty"),
            (plain("<f8", "(2, 48000)", &two), "a.T"),
            (plain("<c16", "(1,)", &two), "type `<c16`"),
            (plain("|O", "(1,)", &two), "type `|O`"),
            (plain("", "(1,)", &two), "invalid type string"),
            (plain("é", "(1,)", &two), "invalid type string"),
            (plain("<f8", "(1,)", &f64::NAN.to_le_bytes()), "row 0, column `ch0`: the value is NaN"),
            (npy("{'descr': [('a', '<f8', (2,))]", &two), "an array or a record"),
            (npy("{'descr': [('a', [('b', '<f8')])]", &two), "an array or a record"),
            (npy(&"[".repeat(60_000), &two), "an array or a record"),
            (npy("[1,", &two), "cannot be read: could not parse"),
            ([b"\x93NUMPY\x02\x00\0\0\x04\0".to_vec(), vec![b' '; 1 << 18]].concat(), "longer than"),
            (npy("{'descr': '<f8'}", &two), "missing"),
            (npy("{'descr': '<f8", &two), "unterminated"),
        ] {
            let e = read(&file, Some(1.0)).unwrap_err().to_string();
            assert!(e.contains(part), "{e:?} without {part:?}");
        }
        let e = read(&plain("<f8", "(2,)", &two), None).unwrap_err();
        assert_eq!(e.kind, FileErrorKind::Usage);
        assert!(e.fix.contains("--gesture-rate"));
        assert_eq!(read(&plain("<f8", "(2,)", &two), Some(-1.0)).unwrap_err().kind, FileErrorKind::Usage);
        let fields = "{'descr': [('time', '|i1'), ('x', '|i1')], 'fortran_order': False, 'shape': (2,)}";
        let e = read(&npy(fields, &[2, 0, 1, 0]), None).unwrap_err().to_string();
        assert!(e.contains("row 1, column `time`: time runs backwards, from 2 s to 1 s"), "{e}");
    }
}
