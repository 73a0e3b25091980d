//! Structures of frames match their message definitions, field by field.

use ca_haptic::frame::{About, DeviceFrame, ForceFrame};
use core::mem::{align_of, offset_of, size_of};

/// Returns name and offset of every field by the text, and the total size: natural alignment, no padding.
fn laid_out(schema: &str) -> (Vec<(String, usize)>, usize) {
    let (mut at, mut fields) = (0, Vec::new());
    for line in schema.lines() {
        let (kind, name) = line.split_once(' ').unwrap();
        let (base, count) = match kind.split_once('[') {
            Some((base, n)) => (base, n.trim_end_matches(']').parse().unwrap()),
            None => (kind, 1),
        };
        let size = match base {
            "uint8" => 1,
            "uint16" => 2,
            "uint32" | "float32" => 4,
            "uint64" | "float64" => 8,
            other => panic!("`{other}` is no type of a frame"),
        };
        assert_eq!(at % size, 0, "`{name}` would need padding");
        fields.push((name.to_owned(), at));
        at += size * count;
    }
    (fields, at)
}

macro_rules! agree {
    ($t:ident, $bytes:literal, $($field:ident),*) => {{
        let (text, end) = laid_out($t::SCHEMA);
        let structure: Vec<_> = [$((stringify!($field).to_owned(), offset_of!($t, $field))),*].into();
        assert_eq!(text, structure);
        assert_eq!((end, size_of::<$t>()), ($bytes, $bytes));
        assert_eq!((end % 8, align_of::<$t>()), (0, 8), "no padding at the end");
        // naming every field makes this fail to compile when one is added
        let take = |f: $t| { let $t { $($field: _),* } = f; };
        let _ = take;
    }};
}

#[test]
fn texts_and_structures_agree() {
    agree!(
        DeviceFrame,
        792,
        magic,
        version,
        layout,
        device,
        session,
        seq,
        ack,
        t_device_ns,
        t_host_ns,
        calibration,
        tick,
        period_ns,
        status,
        cause,
        n,
        mask,
        vel_mask,
        buttons,
        pos,
        vel,
        force_measured,
        quat,
        aux,
        temperature,
        reserved
    );
    agree!(
        ForceFrame,
        240,
        magic,
        version,
        layout,
        device,
        session,
        seq,
        ack_session,
        ack,
        t_host_ns,
        tick,
        calibration,
        ttl_us,
        mode,
        cause,
        n,
        flags,
        inject,
        reserved,
        force
    );
    agree!(
        About,
        904,
        magic,
        version,
        layout,
        device,
        session,
        calibration,
        model,
        serial,
        firmware,
        rate,
        n,
        axes,
        low,
        high,
        force,
        continuous,
        stiffness,
        damping
    );
}

#[test]
fn a_layout_is_the_hash_of_its_text() {
    // reference values of FNV-1a
    assert_eq!(ca_haptic::frame::fnv(b""), 0xcbf2_9ce4_8422_2325);
    assert_eq!(ca_haptic::frame::fnv(b"a"), 0xaf63_dc4c_8601_ec8c);
    let layouts = [DeviceFrame::LAYOUT, ForceFrame::LAYOUT, About::LAYOUT];
    assert!(layouts[0] != layouts[1] && layouts[1] != layouts[2] && layouts[0] != layouts[2]);
    assert_eq!(DeviceFrame::LAYOUT, ca_haptic::frame::fnv(DeviceFrame::SCHEMA.as_bytes()));
}
