//! Quantities: exact bits, units, errors with their place.

use ca_core::{Dim, Unit};
use ca_model::quantity::{Plain, Quantity, parse, show, unit_of};
use proptest::prelude::*;

fn value(text: &str, dim: Dim) -> f64 {
    let q = parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
    assert!(q.dim.same(dim), "{text}: {:?} is not {dim:?}", q.dim);
    q.value
}

#[test]
fn prefixes_move_the_point_and_lose_no_bit() {
    let cases = [
        ("20 g", Unit::KILOGRAM.dim, 0.02),
        ("0.5 mm", Unit::METRE.dim, 0.0005),
        ("8 kN/m", Unit::STIFFNESS.dim, 8000.0),
        ("110 Hz", Unit::HERTZ.dim, 110.0),
        ("0.2 N s/m", Unit::VISCOSITY.dim, 0.2),
        ("5 mN s/m", Unit::VISCOSITY.dim, 0.005),
        ("5 mN·s/m", Unit::VISCOSITY.dim, 0.005),
        ("5 mN*s/m", Unit::VISCOSITY.dim, 0.005),
        ("0.7 N/m s", Unit::VISCOSITY.dim, 0.7),
        ("48 kHz", Unit::HERTZ.dim, 48000.0),
        ("-5 mm", Unit::METRE.dim, -0.005),
        ("−5 mm", Unit::METRE.dim, -0.005),
        ("+.5 m", Unit::METRE.dim, 0.5),
        ("3 ms", Unit::SECOND.dim, 0.003),
        ("3 µs", Unit::SECOND.dim, 3e-6),
        ("3 μs", Unit::SECOND.dim, 3e-6),
        ("3 us", Unit::SECOND.dim, 3e-6),
        ("9.81 m/s^2", Unit::ACCELERATION.dim, 9.81),
        ("9.81 m/s²", Unit::ACCELERATION.dim, 9.81),
        ("1e8 N/m^1.5", Unit::power_stiffness(1.5).dim, 1e8),
        ("7 N/mm", Unit::STIFFNESS.dim, 7000.0),
        ("7 kg", Unit::KILOGRAM.dim, 7.0),
        ("7 mg", Unit::KILOGRAM.dim, 7e-6),
        ("7kg", Unit::KILOGRAM.dim, 7.0),
        ("2e3g", Unit::KILOGRAM.dim, 2.0),
        ("0.1 cm", Unit::METRE.dim, 0.001),
        ("50 %", Unit::NONE.dim, 0.5),
        ("1e-3", Unit::NONE.dim, 1e-3),
        ("5 /s", Unit::HERTZ.dim, 5.0),
        ("1.1 m^2/mm s", Dim::new(1.0, 0.0, 1.0), 1100.0),
    ];
    for (text, dim, expected) in cases {
        assert_eq!(value(text, dim).to_bits(), f64::to_bits(expected), "{text}");
    }
    // by multiplication, every third number would be off by one bit
    let naive = (1..1000).filter(|&i| f64::from(i) * 1e-3 != value(&format!("{i} g"), Unit::KILOGRAM.dim)).count();
    assert!(naive > 100, "multiplying by 1e-3 is exact too: {naive}");
    for i in 1..1000 {
        let text = format!("0.{i:03}");
        assert_eq!(value(&format!("{i} g"), Unit::KILOGRAM.dim), text.parse::<f64>().unwrap());
    }
}

#[test]
fn a_broken_power_of_a_prefix_is_near() {
    let v = value("1 N/mm^1.5", Unit::power_stiffness(1.5).dim);
    assert!((v / 10f64.powf(4.5) - 1.0).abs() < 1e-15, "{v}");
}

#[test]
fn whether_a_unit_is_written_is_known() {
    assert_eq!(parse("3").unwrap(), Quantity { value: 3.0, dim: Unit::NONE.dim, has_unit: false });
    assert!(parse("3 %").unwrap().has_unit);
}

#[test]
fn errors_say_what_where_and_what_instead() {
    let cases = [
        ("20 gr", 3, 5, "unknown unit: `gr`", Some("g")),
        ("8 KN/m", 2, 4, "unknown unit: `KN`", Some("kN")),
        ("8 kn/m", 2, 4, "unknown unit: `kn`", Some("kN")),
        ("110 hz", 4, 6, "unknown unit: `hz`", Some("Hz")),
        ("0.2 Ns/m", 4, 6, "unknown unit: `Ns`", Some("N s")),
        ("4 sec", 2, 5, "unknown unit: `sec`", Some("s")),
        ("4 parsecs", 2, 9, "unknown unit: `parsecs`", None),
        ("0,5 m", 1, 2, "the decimal sign is a dot", Some("0.5")),
        ("-", 0, 1, "a quantity starts with a number", None),
        ("", 0, 0, "a quantity starts with a number", None),
        ("hammer", 0, 0, "a quantity starts with a number", None),
        ("5 N/", 4, 4, "a unit is missing", None),
        ("5 m^", 4, 4, "`^` must be followed by a number, as in `m^1.5`", None),
        ("5 m^99", 4, 6, "the power of a unit must be between -9 and 9", None),
        ("5 m^3/2", 6, 7, "`2` is not a unit", None),
        ("5 m#", 3, 4, "`#` is not part of a unit", None),
        ("1.2.3", 3, 4, "`.` is one dot too many", None),
        ("1e999 m", 0, 5, "too large for a number", None),
        ("3 µq", 2, 5, "unknown unit: `µq`", None),
        ("3 k%", 2, 4, "unknown unit: `k%`", None),
    ];
    for (text, at, end, message, hint) in cases {
        let e = parse(text).expect_err(text);
        assert_eq!((e.message.as_str(), e.at, e.end, e.hint.as_deref()), (message, at, end, hint), "{text}");
    }
}

const SHOWN: &[Unit] = &[
    Unit::NONE,
    Unit::METRE,
    Unit::KILOGRAM,
    Unit::SECOND,
    Unit::HERTZ,
    Unit::SPEED,
    Unit::ACCELERATION,
    Unit::NEWTON,
    Unit::STIFFNESS,
    Unit::VISCOSITY,
    Unit::CUBIC,
];

#[test]
fn shown_as_people_write() {
    let cases = [
        (0.02, Unit::KILOGRAM, "20 g"),
        (2.5, Unit::KILOGRAM, "2.5 kg"),
        (1e-6, Unit::KILOGRAM, "1 mg"),
        (5000.0, Unit::KILOGRAM, "5000 kg"),
        (8000.0, Unit::STIFFNESS, "8 kN/m"),
        (0.005, Unit::METRE, "5 mm"),
        (-0.005, Unit::METRE, "-5 mm"),
        (0.5, Unit::METRE, "0.5 m"),
        (1200.0, Unit::METRE, "1200 m"),
        (1e-6, Unit::METRE, "1 µm"),
        (110.0, Unit::HERTZ, "110 Hz"),
        (44100.0, Unit::HERTZ, "44.1 kHz"),
        (48000.0, Unit::HERTZ, "48 kHz"),
        (0.5, Unit::HERTZ, "0.5 Hz"),
        (4.0, Unit::SECOND, "4 s"),
        (0.2, Unit::VISCOSITY, "0.2 N s/m"),
        (0.005, Unit::VISCOSITY, "5 mN s/m"),
        (9.81, Unit::ACCELERATION, "9.81 m/s^2"),
        (0.0, Unit::METRE, "0 m"),
        (0.25, Unit::NONE, "0.25"),
        (1e30, Unit::NEWTON, "1e30 N"),
        (f64::INFINITY, Unit::NEWTON, "inf"),
    ];
    for (v, unit, text) in cases {
        assert_eq!(show(v, unit), text);
    }
    assert_eq!(unit_of(Unit::power_stiffness(1.5).dim), "N/m^1.5");
    assert_eq!(unit_of(Dim::new(2.0, 0.0, 1.0)), "m^2 s");
    assert_eq!(unit_of(Unit::VISCOSITY.dim), "N s/m");
}

fn back(v: f64) {
    for &unit in SHOWN {
        let text = show(v, unit);
        let q = parse(&text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(q.value.to_bits(), v.to_bits(), "{text}");
        assert!(q.dim.same(unit.dim), "{text}");
    }
}

#[test]
fn plain_numbers_get_an_exponent_where_digits_cannot_be_counted() {
    for (v, text, three) in [
        (0.0, "0", "0.000"),
        (1e-4, "0.0001", "0.000"),
        (9.9e-5, "9.9e-5", "9.900e-5"),
        (-9_999_999.5, "-9999999.5", "-9999999.500"),
        (1e7, "1e7", "1.000e7"),
        (-1e99, "-1e99", "-1.000e99"),
        (f64::MAX, "1.7976931348623157e308", "1.798e308"),
        (f64::INFINITY, "inf", "inf"),
    ] {
        assert_eq!((format!("{}", Plain(v)).as_str(), format!("{:.3}", Plain(v)).as_str()), (text, three));
    }
}

#[test]
fn shown_reads_back_at_the_edges() {
    for v in [0.0, -0.0, f64::MIN_POSITIVE, 5e-324, f64::MAX, f64::MIN, 1e22, 1e23, 0.1 + 0.2, 123_456_789.123_456_7] {
        back(v);
    }
}

proptest! {
    #[test]
    fn shown_reads_back(bits in any::<u64>(), small in -1000.0..1000.0f64, e in -12i32..12) {
        let v = f64::from_bits(bits);
        if v.is_finite() {
            back(v);
        }
        back(small * 10f64.powi(e));
    }

    #[test]
    fn any_text_is_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..40)) {
        let text = String::from_utf8_lossy(&bytes);
        for t in [text.clone().into_owned(), format!("1{text}"), format!("-.5e{text}"), format!("3 N{text}")] {
            if let Err(e) = parse(&t) {
                prop_assert!(e.at <= e.end && t.is_char_boundary(e.at) && t.is_char_boundary(e.end), "{t:?} {e:?}");
            }
        }
    }

    #[test]
    fn near_quantities_are_read_or_refused(text in "[-+.]?[0-9]{0,3}[.,e]?[-+]?[0-9]{0,4} ?[kmuµGgNsHz%/·* ^²0-9.]{0,9}") {
        if let Ok(q) = parse(&text) {
            prop_assert!(q.value.is_finite());
        }
    }
}

#[test]
fn a_number_in_quotes_has_its_unit() {
    let found = |m: &str, x: &str| {
        let text = format!("[MAS]\nb = {{ m = {m}, x = {x} }}\n[SOX]\no = {{ from = \"b\", gain = \"3\" }}\n");
        let (model, result) =
            ca_compile::load(&text, "m.ca.toml", &ca_tests::catalog(), &ca_compile::Options::default());
        match result {
            Ok(_) => String::new(),
            Err(diags) => ca_model::render::text(&diags, &model, false),
        }
    };
    // a dimensionless number needs no unit, and zero needs none anywhere
    assert_eq!(found("\"20 g\"", "\"0\""), "");
    assert_eq!(found("0.02", "0.1"), "");
    let all = found("\"20\"", "0");
    assert!(all.contains("E008") && all.contains("`m` of `b` has no unit: `20`") && all.contains("\"20 kg\""), "{all}");
}
