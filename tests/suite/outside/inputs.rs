//! `tests/data/inputs`: small files as other programs write them. An older version refused or misread each of them.

use ca_io::cloud;
use ca_io::gesture::{Gesture, Track};
use std::path::PathBuf;

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/inputs").join(name)
}

fn samples(name: &str) -> Vec<f64> {
    let g = Gesture::open(path(name), &[], None).unwrap_or_else(|e| panic!("{e}"));
    let track: &Track = &g.tracks()[0];
    (0..track.n_points()).map(|i| track.at(i as f64 / 3000.0)).collect()
}

#[test]
fn sounds_are_those_that_libsndfile_reads() {
    let floats = [0.0, 0.001, 0.002, 0.003, 0.004].map(|x: f32| f64::from(x));
    for name in ["wav/w05_rf64.wav", "wav/w09_size_0_stream.wav", "wav/w09b_sox_7ffff000.wav"] {
        assert_eq!(samples(name), floats, "{name}");
    }
    let integers = |full: f64, all: &[i32]| all.iter().map(|v| f64::from(*v) / full).collect::<Vec<_>>();
    assert_eq!(samples("wav/w04_odd_24.wav"), integers(8_388_608.0, &[0, 1000, 2000, 3000, 4000]));
    let left = integers(2_147_483_648.0, &[0, 0x0041_8900, 0x0083_1200, 0x0083_1200]);
    assert_eq!(samples("wav/lj24in32.wav"), left);
}

#[test]
fn tables_of_other_programs_are_read() {
    for name in ["csv/c11_trailing_comma.csv", "csv/c26_space_blank.csv"] {
        let g = Gesture::open(path(name), &[], None).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((g.tracks().len(), g.track("key").expect("a key").at(0.25)), (1, 0.002), "{name}");
    }
    let g = Gesture::open(path("npy/n04_f16.npy"), &[], Some(3000.0)).unwrap_or_else(|e| panic!("{e}"));
    let half = |x: u16| f64::from(x & 0x3ff | 0x400) * f64::from(i32::from(x >> 10) - 25).exp2();
    let want = [0.0, half(0x151f), half(0x191f), half(0x1bae), half(0x1d1f)];
    assert_eq!((0..5).map(|i| g.tracks()[0].at(f64::from(i) / 3000.0)).collect::<Vec<_>>(), want);
}

#[test]
fn drawings_of_other_programs_are_read() {
    let square = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0]];
    let around: &[[u32; 2]] = &[[0, 1], [0, 3], [1, 2], [2, 3]];
    let near = |points: &[[f64; 3]], want: &[[f64; 3]]| {
        let same = |(a, b): (&f64, &f64)| *a == *b || *a == f64::from(*b as f32);
        points.len() == want.len() && points.as_flattened().iter().zip(want.as_flattened()).all(same)
    };
    for (name, points, edges) in [
        ("space/bom3.obj", 4, &[[0, 1], [0, 2], [1, 2]][..]),
        ("space/cr3.obj", 3, &[[0, 1], [0, 2], [1, 2]]),
        ("space/o06_continuation.obj", 4, around),
        ("space/p28_bom.ply", 4, around),
        ("space/p16_blank_line.ply", 4, around),
        ("space/p17b_comment_latin1.ply", 4, around),
        ("space/p19_tristrips.ply", 4, &[[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]),
    ] {
        let cloud = cloud::open(path(name)).unwrap_or_else(|e| panic!("{e}"));
        assert!(near(&cloud.points, &square[..points]), "{name}: {:?}", cloud.points);
        assert_eq!(cloud.edges, edges, "{name}");
    }
    let said = cloud::open(path("space/p23_scientific_comma.ply")).unwrap_err();
    assert_eq!((said.place.as_str(), said.what.as_str()), ("line 12", "`0,1` is not a number"));
    assert_eq!(said.fix, "write decimals with a point, as in `0.1`");
}
