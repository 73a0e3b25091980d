//! Tests the messages of the recorder.

use super::*;
use crate::engine::tests::{KEY, setup};
use crate::frame::ForceFrame;
use ca_compile::{Options, compile};
use ca_model::read::read;

#[test]
fn damping_that_gave_energy_is_reported_once_each_time() {
    let (model, _) = read(KEY, "key.ca.toml", &ca_model::catalog());
    let scene = Arc::new(compile(&model, &ca_model::catalog(), &Options::default()).expect("it compiles").scene);
    let (_engine, _gateway, ends) = crate::serve::rings(&scene, 1, 0);
    let port = Port::new(&scene, setup());
    let mut recorder = Recorder::new(ends, Arc::default(), scene, &[port], vec![]);
    let mut frame = ForceFrame::new("key", 1);
    for flags in [0, 0x100, 0x100, 0, 0, 0x100, 0x104] {
        frame.flags = flags;
        recorder.look(&Record::Force { port: 0, frame });
    }
    let texts: Vec<_> = recorder.notices.iter().map(|h| h.text.as_str()).collect();
    assert_eq!(texts, ["key: passivity damping gave energy to the hand; off for a while"; 2]);
}
