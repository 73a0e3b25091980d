//! Handing over to a take allocates nothing, also when the rings are full.

use super::calls;
use ca_core::{Options, compile, model::read};
use ca_haptic::calibration::Calibration;
use ca_haptic::engine::{self, Change, Setup, Spent};
use ca_haptic::frame::{DeviceFrame, ForceFrame};
use ca_haptic::profile::Profile;
use ca_haptic::record::Record;
use ca_haptic::take::{Header, Recorder, Rt};

const KEY: &str = r#"
[TGR]
key = { device = "key", dof = 0 }
[SOL]
wall = {}
[RES]
spring = { between = ["key", "wall"], k = 500 }
[SOX]
out = { from = "key" }
"#;

#[test]
fn handing_over_to_a_take_allocates_nothing() {
    let catalog = ca_tests::catalog();
    let (model, _) = read::read(KEY, "key.ca.toml", &catalog);
    let scene = compile(&model, &catalog, &Options::default()).expect("it compiles");
    let profile = Profile { dof: 1, ..Profile::shipped("tgr12").expect("shipped") };
    let setup = Setup { device: "key".into(), profile, calibration: Calibration::default(), gains: vec![] };
    let header = Header::new(&model, vec![], Options::default(), &scene, vec![setup], engine::Options::default());
    let dir = tempfile::tempdir().expect("a directory");
    let (recorder, mut rings) = Recorder::start(dir.path().join("a.mcap"), &header, &scene).expect("a take");
    let (device, force) = (DeviceFrame::new("key", 1), ForceFrame::new("key", 1));
    let (sound, x) = ([0.5; 16], vec![0.0; scene.n_mat]);
    let changes: Vec<Box<Change>> = (0..500).map(|_| Box::default()).collect();
    let n = calls(|| {
        // more at once than the rings hold
        for n in 0..20_000 {
            rings.record(Record::Device { port: 0, frame: device });
            rings.record(Record::Force { port: 0, frame: force });
            rings.sound(n * 16, &sound);
            rings.view(n * 16, &x);
            rings.stats(Rt::default());
        }
    });
    let lost = rings.lost();
    assert_eq!(n, 0);
    assert!(lost > 0, "nothing was too much");
    let mut changes = changes.into_iter();
    let n = calls(|| {
        for c in changes.by_ref() {
            rings.record(Record::Spent { tick: 0, spent: Spent::Change(c) });
        }
    });
    assert_eq!(n, 0, "boxes are freed elsewhere");
    drop(changes);
    recorder.finish().expect("finished");
}
