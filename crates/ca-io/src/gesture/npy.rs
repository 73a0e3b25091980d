//! NPY gestures: an array as `numpy.save` writes it.
//!
//! Decides where time comes from: an array with named fields (a structured dtype) may have a field `time`, in seconds,
//! and its other fields are the tracks; any other array, of shape `(frames,)` or `(frames, columns)`, is sampled at the
//! rate the caller gives, and its columns are `ch0`, `ch1`, …. Taking the first column of a plain array for time was
//! the alternative: it would play a recording as a clock, or a clock as a recording, without a word. Values are taken
//! as they are, integers too.
//!
//! The header is read here, because the crate for it (npyz, which the tests read and write with) multiplies the shape
//! without looking, and calls itself once per dimension of a field: a crafted file ends the process by either.

use super::{Gesture, Track, check_rate};
use crate::error::{FileError, FileErrorKind};
use ca_model::quantity::Plain;

/// More columns than this are a matrix the wrong way round.
const MAX_COLUMNS: usize = 1024;

/// One number of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Number {
    /// `f`, `i`, `u`; `V` for bytes that align the next field
    kind: u8,
    size: usize,
    big_endian: bool,
}

#[derive(Debug, Default)]
struct Header {
    /// named fields, or one without a name
    fields: Vec<(String, Number)>,
    structured: bool,
    fortran: bool,
    shape: Vec<usize>,
}

/// Reads an NPY gesture; `rate` \[Hz\] for arrays without a field `time`.
pub(super) fn read(bytes: &[u8], rate: Option<f64>) -> Result<Gesture, FileError> {
    let (text, data) = split(bytes)?;
    let head = Parser { text, at: 0 }.header()?;
    let (frames, per_row) = match (&head.shape[..], head.structured) {
        (&[n], _) => (n, 1),
        (&[n, k], false) => (n, k),
        (other, _) => {
            let want = if head.structured { "`(frames,)`" } else { "`(frames,)` or `(frames, columns)`" };
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
    let item: usize = head.fields.iter().map(|f| f.1.size).sum();
    let needed = frames.checked_mul(per_row).and_then(|n| n.checked_mul(item));
    if needed.is_none_or(|n| n > data.len()) {
        let what = format!("the file is cut short: {frames} frames announced, {} bytes of data", data.len());
        return Err(FileError::format(what));
    }
    // from here on frames × per_row × item ≤ data.len()
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    if head.structured {
        let mut offset = 0;
        for (name, number) in head.fields {
            if number.kind != b'V' {
                let values = (0..frames).map(|r| decode(number, &data[r * item + offset..][..number.size]));
                columns.push((name, values.collect()));
            }
            offset += number.size;
        }
    } else {
        let number = head.fields[0].1;
        for c in 0..per_row {
            let index = |r: usize| if head.fortran { c * frames + r } else { r * per_row + c };
            let values = (0..frames).map(|r| decode(number, &data[index(r) * item..][..item])).collect();
            columns.push((format!("ch{c}"), values));
        }
    }
    for (name, values) in &columns {
        if let Some(r) = values.iter().position(|v| !v.is_finite()) {
            return Err(
                FileError::content(format!("the value is {}", values[r])).at(format!("row {r}, column `{name}`"))
            );
        }
    }
    tracks(columns, rate)
}

/// Gives the columns their time.
fn tracks(mut columns: Vec<(String, Vec<f64>)>, rate: Option<f64>) -> Result<Gesture, FileError> {
    let time = columns.iter().position(|c| c.0 == "time").map(|i| columns.remove(i).1);
    if columns.is_empty() {
        return Err(FileError::content("there is no field but `time`").fix("add one named after the port it moves"));
    }
    let made: Result<Vec<Track>, FileError> = match (time, rate) {
        (Some(_), Some(_)) => {
            let e = FileError::usage("the array has its own `time`, and a rate is given as well");
            return Err(e.fix("leave out its rate (`--gesture-rate`)"));
        }
        (None, None) => {
            let e = FileError::usage("nothing says how fast the array is to be played");
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

/// The text of the header, and the data.
fn split(bytes: &[u8]) -> Result<(&[u8], &[u8]), FileError> {
    let short = || FileError::format("the file is cut short in its header");
    let Some(rest) = bytes.strip_prefix(b"\x93NUMPY") else {
        return Err(FileError::format("it is not an NPY file").fix("write it with `numpy.save(file, array)`"));
    };
    let (start, len) = match *rest {
        [1, _, a, b, ..] => (4, usize::from(u16::from_le_bytes([a, b]))),
        [2 | 3, _, a, b, c, d, ..] => (6, u32::from_le_bytes([a, b, c, d]) as usize),
        [v, ..] if !(1..=3).contains(&v) => {
            return Err(FileError::new(FileErrorKind::Unsupported, format!("version {v} of NPY is not read")));
        }
        _ => return Err(short()),
    };
    rest[start..].split_at_checked(len).ok_or_else(short)
}

/// Little more of Python than `{'descr': …, 'fortran_order': …, 'shape': …}`; nothing in it calls itself.
struct Parser<'a> {
    text: &'a [u8],
    at: usize,
}

impl Parser<'_> {
    fn header(mut self) -> Result<Header, FileError> {
        let mut h = Header::default();
        let (mut fortran, mut shape) = (None, None);
        self.expect(b'{')?;
        while !self.take(b'}') {
            let key = self.string()?;
            self.expect(b':')?;
            match key.as_str() {
                "descr" => self.descr(&mut h)?,
                "fortran_order" if self.word(b"False") => fortran = Some(false),
                "fortran_order" if self.word(b"True") => fortran = Some(true),
                "shape" => shape = Some(self.shape()?),
                _ => return Err(self.wrong("an entry of another kind")),
            }
            if !self.take(b',') {
                self.expect(b'}')?;
                break;
            }
        }
        match (fortran, shape) {
            (Some(fortran), Some(shape)) if !h.fields.is_empty() => Ok(Header { fortran, shape, ..h }),
            _ => Err(self.wrong("an entry missing")),
        }
    }

    fn descr(&mut self, h: &mut Header) -> Result<(), FileError> {
        h.fields.clear();
        h.structured = self.take(b'[');
        if !h.structured {
            let number = self.number(false)?;
            h.fields.push((String::new(), number));
            return Ok(());
        }
        while !self.take(b']') {
            self.expect(b'(')?;
            let name = self.string()?;
            self.expect(b',')?;
            let number = self.number(name.is_empty())?;
            self.take(b',');
            if !self.take(b')') {
                let e = FileError::new(FileErrorKind::Unsupported, format!("field `{name}` is an array in itself"));
                return Err(e.fix("save one number per field"));
            }
            h.fields.push((name, number));
            if h.fields.len() > MAX_COLUMNS {
                return Err(FileError::new(FileErrorKind::Unsupported, format!("it has over {MAX_COLUMNS} fields")));
            }
            if !self.take(b',') {
                self.expect(b']')?;
                break;
            }
        }
        Ok(())
    }

    /// A type such as `<f8`.
    fn number(&mut self, padding: bool) -> Result<Number, FileError> {
        let text = self.string()?;
        let (order, rest) = text.split_at_checked(1).unwrap_or((&text, ""));
        let kind = rest.bytes().next().unwrap_or(0);
        let size = rest.get(1..).and_then(|s| s.parse::<u32>().ok()).unwrap_or(0) as usize;
        let known = match kind {
            b'f' => matches!(size, 4 | 8),
            b'i' | b'u' => matches!(size, 1 | 2 | 4 | 8),
            b'V' => padding && (1..=1 << 16).contains(&size),
            _ => false,
        };
        if !known || !matches!(order, "<" | ">" | "|" | "=") {
            let e = FileError::new(FileErrorKind::Unsupported, format!("numbers of type `{}`", text.escape_debug()));
            return Err(e.fix("save it as `float64`, `float32` or integers: `a.astype(float)`"));
        }
        Ok(Number { kind, size, big_endian: order == ">" })
    }

    fn shape(&mut self) -> Result<Vec<usize>, FileError> {
        let mut shape = Vec::new();
        self.expect(b'(')?;
        while !self.take(b')') {
            self.skip_blanks();
            let digits = self.text[self.at..].iter().take_while(|b| b.is_ascii_digit()).count();
            let text = std::str::from_utf8(&self.text[self.at..self.at + digits]).unwrap_or("");
            shape.push(text.parse().map_err(|_| self.wrong("a shape of something else than whole numbers"))?);
            self.at += digits;
            if !self.take(b',') {
                self.expect(b')')?;
                break;
            }
        }
        Ok(shape)
    }

    fn string(&mut self) -> Result<String, FileError> {
        self.skip_blanks();
        let quote = self.text.get(self.at).copied().filter(|b| matches!(b, b'\'' | b'"'));
        let quote = quote.ok_or_else(|| self.wrong("no string where one belongs"))?;
        let start = self.at + 1;
        let len = self.text[start..].iter().position(|b| *b == quote || *b == b'\\');
        let end = start + len.unwrap_or(self.text.len() - start);
        if self.text.get(end) != Some(&quote) {
            return Err(self.wrong("a string without an end, or with a backslash"));
        }
        self.at = end + 1;
        // versions 1 and 2 are latin-1, version 3 is UTF-8; names of ports are read as UTF-8
        Ok(String::from_utf8_lossy(&self.text[start..end]).into_owned())
    }

    fn word(&mut self, word: &[u8]) -> bool {
        self.skip_blanks();
        let is = self.text[self.at..].starts_with(word);
        if is {
            self.at += word.len();
        }
        is
    }

    fn take(&mut self, b: u8) -> bool {
        self.word(&[b])
    }

    fn expect(&mut self, b: u8) -> Result<(), FileError> {
        if self.take(b) { Ok(()) } else { Err(self.wrong(&format!("no `{}` where one belongs", b as char))) }
    }

    fn skip_blanks(&mut self) {
        self.at += self.text[self.at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
    }

    fn wrong(&self, what: &str) -> FileError {
        let e = FileError::format(format!("its header has {what}")).at(format!("byte {} of the header", self.at));
        e.fix("write it with `numpy.save(file, array)`")
    }
}

/// One number from exactly `number.size` bytes.
fn decode(number: Number, bytes: &[u8]) -> f64 {
    let mut b = [0u8; 8];
    let n = bytes.len();
    b[..n].copy_from_slice(bytes);
    if number.big_endian {
        b[..n].reverse();
    }
    let bits = u64::from_le_bytes(b);
    let unused = 64 - 8 * n as u32;
    match (number.kind, n) {
        (b'f', 4) => f64::from(f32::from_bits(bits as u32)),
        (b'f', _) => f64::from_bits(bits),
        (b'i', _) => (((bits << unused) as i64) >> unused) as f64,
        _ => bits as f64,
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
        assert!(e.to_string().contains("its own `time`"), "{e}");
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
            (plain("<f8", "(18446744073709551615, 1024)", &two), "cut short"),
            (plain("<f8", "(99999999999999999999999,)", &two), "shape"),
            (plain("<f8", "()", &two), "shape is []"),
            (plain("<f8", "(1, 1, 1)", &two), "shape is [1, 1, 1]"),
            (plain("<f8", "(0,)", &two), "empty"),
            (plain("<f8", "(2, 48000)", &two), "a.T"),
            (plain("<c16", "(1,)", &two), "type `<c16`"),
            (plain("|O", "(1,)", &two), "type `|O`"),
            (plain("", "(1,)", &two), "type ``"),
            (plain("é", "(1,)", &two), "type `é`"),
            (plain("<f8", "(1,)", &f64::NAN.to_le_bytes()), "row 0, column `ch0`: the value is NaN"),
            (npy("{'descr': [('a', '<f8', (2,))]", &two), "array in itself"),
            (npy(&"[".repeat(60_000), &two), "no `{`"),
            (npy("{'descr': '<f8'}", &two), "missing"),
            (npy("{'descr': '<f8", &two), "without an end"),
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
