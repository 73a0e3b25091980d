//! Messages for viewers: masses and links in space, joints, sound for listening, text.
//!
//! They are Foxglove messages (protobuf), made by the Foxglove library and known to Foxglove, Lichtblick, PlotJuggler
//! and Rerun. They are rounded, decimated and never read back. Modules on a line are drawn as a row, a centimetre
//! apart, with the position upwards.

use ca_core::internal::op::layout::Layout;
use ca_core::{InputRole, Location, Scene};
use foxglove::Encode;
use foxglove::messages::{
    Color, JointState, JointStates, LinePrimitive, Log, PackedElementField, Point3, PointCloud, RawAudio, SceneEntity,
    SceneUpdate, Timestamp, line_primitive, log, packed_element_field,
};

/// Distance of neighbours in a row \[m\].
const ROW: f64 = 0.01;
/// Largest number of links drawn.
const LINKS: usize = 4000;

/// Severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Information.
    Info,
    /// An unintended state.
    Warning,
    /// A fault.
    Error,
}

pub struct Picture {
    /// First place of each MAT, and whether it has three.
    mats: Vec<(usize, bool)>,
    rest: Vec<f64>,
    links: Vec<[u32; 2]>,
}

impl Picture {
    pub fn new(scene: &Scene) -> Picture {
        let layout: &Layout = scene;
        let mut mats: Vec<(usize, bool)> = scene
            .symbols
            .iter()
            .filter_map(|s| if let Location::Mat(at) = s.location { Some((at as usize, s.axes > 1)) } else { None })
            .collect();
        mats.sort_unstable();
        mats.dedup();
        let mut of = vec![u32::MAX; layout.counts.n_mat];
        for (n, (at, space)) in mats.iter().enumerate() {
            for place in of.iter_mut().skip(*at).take(if *space { 3 } else { 1 }) {
                *place = n as u32;
            }
        }
        let drawn = |e: &[u32; 2]| {
            let [a, b] = e.map(|p| of.get(p as usize).copied().unwrap_or(u32::MAX));
            (a != u32::MAX && b != u32::MAX && a != b).then_some([a, b])
        };
        let links = layout.links.ends.iter().filter_map(drawn).take(LINKS).collect();
        Picture { links, rest: layout.places.rest.clone(), mats }
    }

    /// Returns the position of each MAT \[m\], from the displacements of the state.
    fn points(&self, x: &[f64]) -> Vec<[f64; 3]> {
        let at = |place: usize| x.get(place).copied().unwrap_or(0.0) + self.rest.get(place).copied().unwrap_or(0.0);
        let point = |(n, (place, space)): (usize, &(usize, bool))| {
            if *space { [at(*place), at(place + 1), at(place + 2)] } else { [n as f64 * ROW, 0.0, at(*place)] }
        };
        self.mats.iter().enumerate().map(point).collect()
    }

    pub fn draw(&self, time: u64, x: &[f64]) -> (PointCloud, SceneUpdate) {
        let points = self.points(x);
        let field = |(i, name): (usize, &str)| PackedElementField {
            name: name.into(),
            offset: 4 * i as u32,
            r#type: packed_element_field::NumericType::Float32 as i32,
        };
        let data: Vec<u8> = points.iter().flatten().flat_map(|v| (*v as f32).to_le_bytes()).collect();
        let cloud = PointCloud {
            timestamp: Some(stamp(time)),
            frame_id: "scene".into(),
            pose: None,
            point_stride: 12,
            fields: ["x", "y", "z"].into_iter().enumerate().map(field).collect(),
            data: data.into(),
        };
        let corner = |n: u32| points.get(n as usize).map(|p| Point3 { x: p[0], y: p[1], z: p[2] });
        let lines = LinePrimitive {
            r#type: line_primitive::Type::LineList as i32,
            thickness: 1.0,
            scale_invariant: true,
            points: self.links.iter().flatten().filter_map(|n| corner(*n)).collect(),
            color: Some(Color { r: 0.9, g: 0.6, b: 0.2, a: 1.0 }),
            ..LinePrimitive::default()
        };
        let links = SceneEntity {
            timestamp: Some(stamp(time)),
            frame_id: "scene".into(),
            id: "links".into(),
            lines: vec![lines],
            ..SceneEntity::default()
        };
        (cloud, SceneUpdate { deletions: Vec::new(), entities: vec![links] })
    }
}

/// Converts a time since 1970 \[ns\].
fn stamp(time: u64) -> Timestamp {
    Timestamp::new((time / 1_000_000_000) as u32, (time % 1_000_000_000) as u32)
}

/// Returns the name of a degree of freedom: the port it moves, otherwise device and number.
pub fn joint(scene: &Scene, device: &str, dof: usize) -> String {
    let mine = |i: &&ca_core::Input| {
        i.role == InputRole::Device && i.device.as_ref().is_some_and(|d| d.0 == device && d.1 as usize == dof)
    };
    scene.inputs.iter().find(mine).map_or_else(|| format!("{device}.{dof}"), |i| i.name.clone())
}

/// Makes a message of joints: name, position \[m\] and force \[N\].
pub fn joints<'a>(time: u64, all: impl Iterator<Item = (&'a str, f64, f64)>) -> JointStates {
    let one = |(name, x, f): (&str, f64, f64)| JointState {
        name: name.into(),
        position: Some(x),
        velocity: None,
        acceleration: None,
        effort: Some(f),
    };
    JointStates { timestamp: Some(stamp(time)), joints: all.map(one).collect() }
}

/// Makes a message of sound: 16 bits, channels interleaved.
pub fn audio(time: u64, rate: u32, channels: u32, samples: &[f64]) -> RawAudio {
    let whole = |x: &f64| (x.clamp(-1.0, 1.0) * 32_768.0).round_ties_even().min(32_767.0) as i16;
    RawAudio {
        timestamp: Some(stamp(time)),
        data: samples.iter().flat_map(|x| whole(x).to_le_bytes()).collect::<Vec<u8>>().into(),
        format: "pcm-s16".into(),
        sample_rate: rate,
        number_of_channels: channels,
    }
}

pub fn words(time: u64, level: Level, name: &str, message: &str) -> Log {
    let level = match level {
        Level::Info => log::Level::Info,
        Level::Warning => log::Level::Warning,
        Level::Error => log::Level::Error,
    };
    Log {
        timestamp: Some(stamp(time)),
        level: level as i32,
        message: message.into(),
        name: name.into(),
        ..Log::default()
    }
}

pub fn schema<T: Encode>() -> (String, String, Vec<u8>) {
    T::get_schema().map(|s| (s.name, s.encoding, s.data.into_owned())).unwrap_or_default()
}

pub fn bytes<T: Encode>(out: &mut Vec<u8>, message: &T) {
    out.clear();
    // fails only if `out` cannot grow, and a vector can
    let _ = message.encode(out);
}
