//! The engine end to end, without a process: a key on a spring.

use super::{Act, Engine, Options, Port, Setup};
use crate::calibration::Calibration;
use crate::frame::{DeviceFrame, Mode};
use crate::guard::Order;
use crate::profile::Profile;
use ca_core::{Catalog, load};
use std::sync::Arc;

/// A key on a spring of 500 N/m, and nothing else.
pub(crate) const KEY: &str = r#"
[TGR]
key = { device = "key", dof = 0 }
[SOL]
wall = {}
[RES]
spring = { between = ["key", "wall"], k = 500 }
[SOX]
out = { from = "key" }
"#;

/// A device of one key.
pub(crate) fn setup() -> Setup {
    let profile = Profile { dof: 1, ..Profile::shipped("tgr12").expect("shipped") };
    Setup { device: "key".into(), profile, calibration: Calibration::default(), gains: vec![] }
}

fn engine() -> Engine {
    let (_, scene) = load(KEY, "key.ca.toml", &Catalog::core(), &ca_core::Options::default());
    let scene = Arc::new(scene.expect("it compiles"));
    let port = Port::new(&scene, setup());
    Engine::new(scene, vec![port], Options::default())
}

#[test]
fn a_spring_is_felt_once_armed_and_clear() {
    let mut e = engine();
    let mut f = DeviceFrame::new("key", 1);
    f.session = 7;
    let mut force = [0.0; 2];
    e.act(Act::Order(None, Order::Arm));
    for n in 0..6000_u64 {
        f.seq += 1;
        f.t_device_ns = n * 333_333;
        f.pos[0] = if n < 400 { 0.0 } else { (0.000_01 * (n - 400) as f64).min(0.005) };
        e.take(0, &mut f);
        let out = *e.answer().next().expect("one device");
        force = [f64::from(out.force[0]), f64::from(out.mode)];
        e.finish();
    }
    assert_eq!(force[1], f64::from(Mode::On as u32));
    assert!((force[0] + 500.0 * 0.005).abs() < 1e-6, "{force:?}");
}
