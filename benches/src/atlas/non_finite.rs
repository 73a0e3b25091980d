//! Non-finite numbers at every entry point: parameters, ports, live changes, frames of a device.
//!
//! The scenes are the examples of the catalog, which contains every kind, so that a new kind is tested too.

use super::device::{self, Rig};
use crate::catalog;
use ca_compile::load::finish;
use ca_compile::{Options, compile};
use ca_core::{Controls, Scene, Type, tick};
use ca_haptic::frame::DeviceFrame;
use ca_model::read::read;

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

/// Results at an entry point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EntryPoint {
    /// Number of attempts.
    pub tried: usize,
    /// Attempts in which a non-finite number passed.
    pub through: Vec<String>,
}

impl EntryPoint {
    fn tries(&mut self, held: bool, what: impl FnOnce() -> String) {
        self.tried += 1;
        if !held {
            self.through.push(what());
        }
    }
}

/// Tests every number of every kind, in the example of the kind: an error names the value, and there is no scene.
pub fn parameters() -> EntryPoint {
    let (mut entry_point, catalog) = (EntryPoint::default(), catalog());
    let number = |ty: &Type| {
        matches!(
            ty,
            Type::Number { .. }
                | Type::PowerStiffness { .. }
                | Type::Count { .. }
                | Type::Numbers { .. }
                | Type::Position { .. }
                | Type::Counts { .. }
        )
    };
    for kind in catalog.iter() {
        let (example, found) = read(kind.example, "example.ca.toml", &catalog);
        for item in example.items.iter().filter(|i| i.kind == kind.code) {
            for param in kind.params.iter().filter(|p| number(&p.ty)) {
                for bad in BAD {
                    let mut model = example.clone();
                    let name = format!("{}.{}", item.name, param.name);
                    let set = model.set(&name, &bad.to_string());
                    let reported = finish(&model, found.clone(), &catalog, &Options::default()).err();
                    let refused = reported.is_some_and(|d| d.list.iter().any(|d| d.code == "E009" || d.code == "E006"));
                    entry_point.tries(set && refused, || format!("{name} = {bad} of {}", kind.code));
                }
            }
        }
    }
    entry_point
}

/// Returns the examples of the catalog that compile unchanged.
fn examples() -> Vec<(&'static str, Scene)> {
    let catalog = catalog();
    let scene = |kind: &'static ca_core::Kind| {
        let (model, _) = read(kind.example, "example.ca.toml", &catalog);
        compile(&model, &catalog, &Options::default()).ok().map(|compiled| (kind.code, compiled.scene))
    };
    catalog.iter().filter_map(scene).collect()
}

/// Tests every input of every example: all numbers stay finite, and refused values are counted.
pub fn ports() -> EntryPoint {
    let mut entry_point = EntryPoint::default();
    for (code, scene) in examples() {
        for (port, input) in scene.inputs.iter().enumerate() {
            for bad in BAD {
                let mut s = scene.state();
                (0..100).for_each(|_| tick(&scene, &mut s));
                let mut finite = true;
                for n in 0..200 {
                    s.input[port] = if n < 100 { bad } else { 1e-3 };
                    tick(&scene, &mut s);
                    let all: [&[f64]; 6] = [&s.x, &s.d, &s.f, &s.output, &s.links.tap, &s.links.mem];
                    finite &= all.iter().all(|v| v.iter().all(|v| v.is_finite()));
                }
                entry_point.tries(finite && s.ports.refused > 0, || format!("{bad} at {} of {code}", input.name));
            }
        }
    }
    entry_point
}

/// A bar with a live parameter.
const LIVE: &str = "[param]\nfelt = { value = 0, unit = \"N s/m\", live = true, min = 0, max = 1 }\n[SOL]\nframe = {}\n\
                    [MAS]\nbar = { m = \"1 g\", dx0 = \"1 mm\" }\n[REF]\nhold = { between = [\"frame\", \"bar\"], \
                    k = 1000, z = \"felt\" }\n[SOX]\nout = { from = \"bar\" }\n";

/// Tests changes during a play: refused by name, and by the state for a patch made by hand.
pub fn changes() -> EntryPoint {
    let mut entry_point = EntryPoint::default();
    let scene = crate::scene(LIVE);
    let mut controls = Controls::new(&scene.live, scene.rates.sample_dt);
    let good = controls.set("felt", 0.5).expect("a good value");
    for bad in BAD {
        entry_point.tries(controls.set("felt", bad).is_err(), || format!("felt = {bad}"));
        let (mut s, mut patch) = (scene.state(), good.clone());
        patch.set.iter_mut().for_each(|p| p.1 = bad);
        let before = s.clone();
        entry_point.tries(!s.apply(&patch, 16) && s == before, || format!("a patch of {bad}"));
    }
    entry_point
}

type Corruption = fn(&mut DeviceFrame, f64);

/// Tests frames of a device with forces on: all forces and samples are finite, and after a series of non-finite
/// positions there is no force.
pub fn frames() -> EntryPoint {
    let mut entry_point = EntryPoint::default();
    let spoils: [(&str, Corruption); 3] = [
        ("position", |f, bad| f.pos[0] = bad),
        ("speed", |f, bad| (f.vel_mask, f.vel[0]) = (1, bad)),
        ("measured force", |f, bad| f.force_measured[0] = bad as f32),
    ];
    for bad in BAD {
        for (what, spoil) in spoils {
            let mut rig = Rig::new(device::key("", 0.1), device::device(0.1));
            // away from rest, so that there is a force
            let before = (1..=100).map(|n| rig.go(0, |f| f.pos[0] = 1e-6 * f64::from(n)).force[0]).last();
            let (mut held, mut last) = (before.is_some_and(|f| f != 0.0), f32::NAN);
            for _ in 0..100 {
                let spoiled = |f: &mut DeviceFrame| {
                    f.pos[0] = 1e-4;
                    spoil(f, bad);
                };
                last = rig.go(0, spoiled).force[0];
                held &= last.is_finite() && rig.engine.state.output.iter().all(|v| v.is_finite());
            }
            held &= rig.engine.state.is_bounded(1e3) && (what != "position" || last == 0.0);
            entry_point.tries(held, || format!("{bad} as {what}"));
        }
    }
    entry_point
}
