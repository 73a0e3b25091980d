//! Header of a take: everything needed to build the same engine again.
//!
//! A take holds the model as its author wrote it and the changes from the command line, not a model merged from both:
//! `model::write` groups modules by kind, and another order of modules gives another order of sums and other bits. (The
//! resolved text is included for people.) Bodies from files are OBJ, profiles and calibrations are their files, so that
//! a take needs nothing outside and any program can read it.
//!
//! A take begins with the engine at tick 0, so its snapshot is the state at load. The header has a hash of that state,
//! to detect a model that compiles to other numbers, and the number of the arithmetic. Where another arithmetic rounds
//! a scene differently, the hash is not compared and a replay compares to a tolerance. A take older than this number
//! has arithmetic 0.

use super::couplings;
use super::next_version::NextModel;
use crate::calibration::Calibration;
use crate::engine::{self, Engine, Port, Setup};
use crate::equivalence::Gains;
use crate::profile::Profile;
use crate::version::ModelText;
use ca_compile::{Compiled, KernelClass, Options};
use ca_core::internal::kind::cloud::Clouds;
use ca_core::internal::scene::same_since;
use ca_core::{ARITHMETIC, Catalog, Scene};
use ca_io::cloud;
use ca_io::error::FileError;
use ca_model::Model;
use ca_model::diag::Diags;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Version of the format.
pub const FORMAT: u32 = 1;
/// Name of the metadata record of a take.
pub const META: &str = "ca.take";

/// Everything needed to build the same engine again, and information for people.
#[derive(Clone, Debug)]
pub struct Header {
    /// Title of the model.
    pub title: String,
    /// Name of the model's file, without the folder.
    pub file: String,
    /// Text of the model as its author wrote it.
    pub text: String,
    /// Changes from the command line, in order: name and value.
    pub changes: Vec<(String, String)>,
    /// Text of the model with these changes, for people.
    pub resolved: String,
    /// Files from which it takes parts, by their paths from its folder.
    pub parts: BTreeMap<String, String>,
    /// Compiler options.
    pub options: Options,
    /// Setups of the devices.
    pub setups: Vec<Setup>,
    /// Engine options.
    pub engine: engine::Options,
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Ticks per gesture frame.
    pub ratio: u32,
    /// Names of the sound channels.
    pub channels: Vec<String>,
    /// [`ca_core::State::bits`] at load.
    pub start: u64,
    /// [`ca_core::ARITHMETIC`] of the engine that played it.
    pub arithmetic: u32,
    /// Start time since 1970 \[ns\].
    pub began_ns: u64,
    /// Program and machine that wrote it: `ca`, `mcap`, `os`, `arch`, `cpus`.
    pub host: BTreeMap<String, String>,
}

pub(super) struct Attached {
    pub name: String,
    pub media: &'static str,
    pub data: String,
}

impl Header {
    /// Makes the header of a performance: `model` with `changes` applied, compiled to `scene` with `options`, and
    /// played with `setups` by an engine with these options.
    pub fn new(
        model: &Model,
        changes: Vec<(String, String)>,
        options: Options,
        scene: &Scene,
        setups: Vec<Setup>,
        engine: engine::Options,
    ) -> Header {
        let ModelText { file, text, changes, resolved, parts } = ModelText::of(model, changes);
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
        let cpus = std::thread::available_parallelism().map_or(0, std::num::NonZero::get);
        let host = [
            ("ca", env!("CARGO_PKG_VERSION").into()),
            ("mcap", mcap::VERSION.into()),
            ("os", std::env::consts::OS.into()),
            ("arch", std::env::consts::ARCH.into()),
            ("cpus", cpus.to_string()),
        ];
        Header {
            title: scene.about.title.clone(),
            file,
            text,
            changes,
            resolved,
            parts,
            options,
            setups,
            engine,
            rate: scene.rate,
            ratio: scene.rates.ratio,
            channels: scene.names.channel_names.clone(),
            start: scene.state().bits(),
            arithmetic: ARITHMETIC,
            began_ns: since.as_nanos() as u64,
            host: host.into_iter().map(|(k, v)| (k.to_owned(), v)).collect(),
        }
    }

    /// Returns the time of a tick since 1970 \[ns\].
    pub fn time(&self, tick: u64) -> u64 {
        self.began_ns.saturating_add((tick as f64 * 1e9 / self.rate) as u64)
    }

    /// Returns the model that was played, with its changes applied, and the findings of its reader.
    ///
    /// # Errors
    /// If a change names a parameter that the model lacks.
    pub fn model(&self, catalog: &Catalog) -> Result<(Model, Diags), FileError> {
        let (mut model, found) = match ca_import::of(&self.file) {
            Some(format) => (format.import)(&self.text, &self.file),
            None => self.text_of().read(catalog),
        };
        for (name, value) in &self.changes {
            if !model.set(name, value) {
                let what = format!("`{name}` was set to `{value}`, but the model of the take does not contain it");
                return Err(FileError::content(what));
            }
        }
        Ok((model, found))
    }

    fn text_of(&self) -> ModelText {
        let Header { file, text, changes, resolved, parts, .. } = self.clone();
        ModelText { file, text, changes, resolved, parts }
    }

    /// Compiles the scene that was played.
    ///
    /// # Errors
    /// If the model does not compile, or compiles to other numbers than when it was played.
    pub fn scene(&self, catalog: &Catalog) -> Result<Compiled, FileError> {
        let (model, found) = self.model(catalog)?;
        let options = Options { arithmetic: Some(self.arithmetic), ..self.options.clone() };
        let compiled = ca_compile::load::finish(&model, found, catalog, &options).map_err(|d| {
            let first = d.list.first().map_or("", |d| d.title.as_str());
            FileError::content(format!("the model of the take does not compile: {first}")).fix(self.other())
        })?;
        let scene = &compiled.scene;
        let others = self.is_exact(scene) && scene.state().bits() != self.start;
        if (scene.rate, scene.rates.ratio) != (self.rate, self.ratio) || others {
            let what = "the model of the take compiles to different numbers here";
            return Err(FileError::content(what).fix(self.other()));
        }
        Ok(compiled)
    }

    /// Returns the header of the same performance with another version of its model.
    #[must_use]
    pub fn version(&self, next: &NextModel) -> Header {
        let ModelText { file, text, changes, resolved, parts } = next.model.clone();
        let (clouds, couplings) = (next.clouds.clone(), next.couplings.clone());
        let options = Options { clouds, couplings, ..self.options.clone() };
        Header { file, text, changes, resolved, parts, options, start: next.start, ..self.clone() }
    }

    /// Returns true if `scene`, compiled from this header, gives the same bits with the present arithmetic.
    pub fn is_exact(&self, scene: &Scene) -> bool {
        (same_since(scene)..=ARITHMETIC).contains(&self.arithmetic)
    }

    /// Builds the engine that played the take, at rest.
    ///
    /// # Errors
    /// As for [`Header::scene`].
    pub fn engine(&self, catalog: &Catalog) -> Result<Engine, FileError> {
        let scene = Arc::new(self.scene(catalog)?.scene);
        let ports = self.setups.iter().map(|s| Port::new(&scene, s.clone())).collect();
        Ok(Engine::new(scene, ports, self.engine))
    }

    fn other(&self) -> String {
        let ca = self.host.get("ca").map_or("", String::as_str);
        format!("use `ca` {ca}, which wrote it; this is {}", env!("CARGO_PKG_VERSION"))
    }

    /// Returns the attachments of a take, and the metadata for the rest.
    pub(super) fn write(&self) -> (Vec<Attached>, BTreeMap<String, String>) {
        let toml = "application/toml";
        let mut files = Vec::new();
        let mut put = |name: String, media, data| files.push(Attached { name, media, data });
        put(format!("model/{}", self.file), toml, self.text.clone());
        put("resolved.ca.toml".into(), toml, self.resolved.clone());
        for (name, text) in &self.parts {
            put(format!("part/{name}"), toml, text.clone());
        }
        for s in &self.setups {
            put(format!("profile/{}.toml", s.device), toml, s.profile.write());
            put(format!("calibration/{}.toml", s.device), toml, s.calibration.write());
        }
        for (name, c) in &self.options.clouds {
            if let Ok(c) = c {
                put(format!("cloud/{name}.obj"), "model/obj", cloud::write_obj(c));
            }
        }
        put("layout/ca-foxglove.json".into(), "application/json", super::LAYOUT.into());
        let names: Vec<&str> = self.setups.iter().map(|s| s.device.as_str()).collect();
        let kernel = if self.options.kernel == KernelClass::Fast { "fast" } else { "reference" };
        let mut meta: BTreeMap<String, String> = [
            ("format", FORMAT.to_string()),
            ("title", self.title.clone()),
            ("file", self.file.clone()),
            ("changes", json(&self.changes)),
            ("devices", json(&names)),
            ("asked.rate", self.options.rate.map(exact).unwrap_or_default()),
            ("asked.energy", self.options.energy.to_string()),
            ("asked.probes", json(&self.options.probes)),
            ("asked.kernel", kernel.into()),
            ("asked.whole", self.options.whole.to_string()),
            ("asked.couplings", couplings::write(&self.options.couplings)),
            ("engine.session", self.engine.session.to_string()),
            ("engine.wild", exact(self.engine.diverged)),
            ("engine.fades", self.engine.fades.to_string()),
            ("sound.rate", exact(self.rate)),
            ("sound.channels", json(&self.channels)),
            ("gesture.ratio", self.ratio.to_string()),
            ("start.bits", format!("{:016x}", self.start)),
            ("arithmetic", self.arithmetic.to_string()),
            ("began_ns", self.began_ns.to_string()),
        ]
        .into_iter()
        .map(|(k, v)| (k.to_owned(), v))
        .collect();
        meta.extend(self.host.iter().map(|(k, v)| (format!("host.{k}"), v.clone())));
        for s in &self.setups {
            let gains = s.gains.iter().map(|g| format!("{} {}", exact(g.alpha), exact(g.beta)));
            meta.insert(format!("gains.{}", s.device), gains.collect::<Vec<_>>().join(", "));
        }
        (files, meta)
    }

    /// Reads what [`Header::write`] returns.
    pub(super) fn read(files: &[(String, String)], meta: &BTreeMap<String, String>) -> Result<Header, FileError> {
        let format: Option<u32> = meta.get("format").and_then(|f| f.parse().ok());
        if format != Some(FORMAT) {
            let by = meta.get("host.ca").map_or("?", String::as_str);
            let e = FileError::unsupported(format!("this take has another format, written by `ca` {by}"));
            return Err(e.fix(format!("use that version; this one is {}", env!("CARGO_PKG_VERSION"))));
        }
        let text = |key: &str| {
            let e = || {
                FileError::format(format!("the metadata does not contain `{key}`"))
                    .fix("`ca log recover` copies the intact part")
            };
            meta.get(key).cloned().ok_or_else(e)
        };
        let bad = |key: &str| FileError::format(format!("the metadata has an invalid `{key}`"));
        let file_of = |name: &str| {
            let e = || FileError::format(format!("the attachment `{name}` is missing"));
            files.iter().find(|f| f.0 == name).map(|f| f.1.clone()).ok_or_else(e)
        };
        let number = |key: &str| text(key)?.parse::<f64>().map_err(|_| bad(key));
        let whole = |key: &str| text(key)?.parse::<u64>().map_err(|_| bad(key));
        let list = |key: &str| serde_json::from_str::<Vec<String>>(&text(key)?).map_err(|_| bad(key));
        let mut setups = Vec::new();
        for device in list("devices")? {
            let (profile, calibration) = (format!("profile/{device}.toml"), format!("calibration/{device}.toml"));
            let key = format!("gains.{device}");
            let gains = text(&key)?.split(", ").filter(|g| !g.is_empty()).map(pair).collect::<Option<Vec<Gains>>>();
            setups.push(Setup {
                profile: Profile::read(&file_of(&profile)?, &profile)?,
                calibration: Calibration::read(&file_of(&calibration)?, &calibration)?,
                gains: gains.ok_or_else(|| bad(&key))?,
                device,
            });
        }
        let mut clouds = Clouds::new();
        for (name, data) in files {
            if let Some(own) = name.strip_prefix("cloud/").and_then(|n| n.strip_suffix(".obj")) {
                clouds.insert(own.into(), Ok(Arc::new(cloud::read_obj(data.as_bytes())?)));
            }
        }
        let parts = files.iter().filter_map(|(n, t)| Some((n.strip_prefix("part/")?.to_owned(), t.clone()))).collect();
        let asked = text("asked.rate")?;
        let rate = if asked.is_empty() { None } else { Some(number("asked.rate")?) };
        let kernel = if text("asked.kernel")? == "reference" { KernelClass::Reference } else { KernelClass::Fast };
        let file = text("file")?;
        let host = meta.iter().filter_map(|(k, v)| Some((k.strip_prefix("host.")?.to_owned(), v.clone())));
        let header = Header {
            title: text("title")?,
            text: file_of(&format!("model/{file}"))?,
            resolved: file_of("resolved.ca.toml")?,
            parts,
            file,
            changes: serde_json::from_str(&text("changes")?).map_err(|_| bad("changes"))?,
            options: Options {
                rate,
                energy: text("asked.energy")? == "true",
                probes: list("asked.probes")?,
                clouds,
                kernel,
                // older takes lack it
                whole: meta.get("asked.whole").is_some_and(|w| w == "true"),
                couplings: meta
                    .get("asked.couplings")
                    .map_or(Some(Vec::new()), |c| couplings::read(c))
                    .ok_or_else(|| bad("asked.couplings"))?,
                ..Options::default()
            },
            setups,
            engine: engine::Options {
                session: whole("engine.session")?,
                diverged: number("engine.wild")?,
                fades: meta.get("engine.fades").is_some_and(|f| f == "true"),
            },
            rate: number("sound.rate")?,
            ratio: u32::try_from(whole("gesture.ratio")?).map_err(|_| bad("gesture.ratio"))?,
            channels: list("sound.channels")?,
            arithmetic: meta.get("arithmetic").map_or(Ok(0), |_| whole("arithmetic"))? as u32,
            start: u64::from_str_radix(&text("start.bits")?, 16).map_err(|_| bad("start.bits"))?,
            began_ns: whole("began_ns")?,
            host: host.collect(),
        };
        if header.rate.is_finite() && header.rate > 0.0 && header.ratio > 0 {
            Ok(header)
        } else {
            Err(bad("sound.rate"))
        }
    }
}

/// Formats a number with the shortest digits that read back exactly.
fn exact(v: f64) -> String {
    format!("{v:?}")
}

fn json<T: serde::Serialize>(v: &T) -> String {
    serde_json::to_string(v).unwrap_or_default()
}

fn pair(text: &str) -> Option<Gains> {
    let (a, b) = text.split_once(' ')?;
    Some(Gains { alpha: a.parse().ok()?, beta: b.parse().ok()? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::Axis;
    use crate::profile::SHIPPED;
    use ca_core::internal::kind::cloud::Cloud;
    use ca_core::internal::scene::Coupling;
    use ca_model::read;

    #[test]
    fn everything_comes_back_to_the_bit() {
        let text = "[TGR]\nkey = { device = \"a b\", dof = 0 }\n[SOL]\nw = {}\n[RES]\nr = { between = [\"key\", \"w\"], k = 5 }\n[SOX]\nout = { from = \"b.m\" }\n[use]\nb = \"p/b.ca.toml\"\n";
        let (mut model, _) = read::read_with(text, "some/where/key.ca.toml", &ca_model::catalog(), &mut |name| {
            assert_eq!(name, "p/b.ca.toml");
            Ok("[MAS]\nm = { m = 1 }\n".into())
        });
        assert!(model.set("r.k", "7"));
        let points = vec![[0.1, -1.0 / 3.0, 1e-300], [1.0, 2.0, 3.0], [0.0, 0.5, 1e300]];
        let cloud = Cloud { points, edges: vec![[0, 2], [1, 2]], merged: 0, flat: 0 };
        let mut options =
            Options { rate: Some(44_100.0), energy: true, probes: vec!["r".into()], whole: true, ..Options::default() };
        options.couplings.push(Coupling {
            port: "key".into(),
            k: 0.1,
            z: 1.0 / 3.0,
            m: 1e-5,
            device_stiffness: 1e17 / 3.0,
        });
        options.clouds.insert("a/b c.ply".into(), Ok(Arc::new(cloud.clone())));
        let scene = ca_compile::compile(&model, &ca_model::catalog(), &options).expect("it compiles");
        for (name, _) in SHIPPED {
            let axis = Axis { scale: 0.1, offset: -1.0 / 3.0, force: 1e-7 };
            let setup = Setup {
                device: "a b".into(),
                profile: Profile::shipped(name).expect("shipped"),
                calibration: Calibration { device: "a b".into(), by: "me".into(), axis: vec![axis; 3] },
                gains: vec![Gains { alpha: 1.0 / 3.0, beta: 1e17 }, Gains::default()],
            };
            let engine = engine::Options { session: u64::MAX, diverged: 0.1, fades: true };
            let changes = vec![("r.k".to_owned(), "7".to_owned())];
            let h = Header::new(&model, changes, options.clone(), &scene, vec![setup], engine);
            let (files, meta) = h.write();
            let files: Vec<(String, String)> = files.into_iter().map(|f| (f.name, f.data)).collect();
            let back = Header::read(&files, &meta).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!((back.arithmetic, &back.setups), (ARITHMETIC, &h.setups));
            assert_eq!((back.engine, back.rate, back.start, back.began_ns), (h.engine, h.rate, h.start, h.began_ns));
            assert!(back.options.whole);
            assert_eq!(back.options.couplings, options.couplings);
            assert_eq!(back.options.clouds["a/b c.ply"], Ok(Arc::new(cloud.clone())));
            assert_eq!((back.file.as_str(), back.text.as_str()), ("key.ca.toml", text));
            assert!(back.resolved.contains("k = 7"));
            let again = back.scene(&ca_model::catalog()).expect("it compiles again");
            assert_eq!(again.state().bits(), scene.state().bits());
            assert_eq!(back.parts, h.parts);
            for key in meta.keys().filter(|k| !k.starts_with("host.")) {
                let mut less = meta.clone();
                less.remove(key);
                let read = Header::read(&files, &less);
                // older takes lack these
                let old = read.as_ref().is_ok_and(|h| match key.as_str() {
                    "arithmetic" => h.arithmetic == 0,
                    "asked.whole" => !h.options.whole,
                    "asked.couplings" => h.options.couplings.is_empty(),
                    "engine.fades" => !h.engine.fades,
                    _ => false,
                });
                assert!(read.is_err() || old, "without `{key}`");
            }
        }
    }

    /// Until arithmetic 4, friction at rest began as sliding. Takes from then keep that start and replay to the bit.
    #[test]
    fn a_take_of_before_friction_stuck_at_load_begins_as_it_did() {
        let text = "[h]\ngravity = 5\n[h.SOL]\nt = {}\n[h.MAS]\nb = { m = 0.01 }\n[BOW]\nr = { between = [\"h.b\", \"h.t\"], curve = \"coulomb\", f \
                    = 0.06, fd = 0.03, method = \"set-valued\" }\n[SOX]\no = { from = \"h.b\" }\n";
        let (model, _) = read::read(text, "block.ca.toml", &ca_model::catalog());
        let catalog = ca_model::catalog();
        let start = |arithmetic| {
            let options = Options { arithmetic, ..Options::default() };
            ca_compile::compile(&model, &catalog, &options).expect("it compiles").scene
        };
        let (now, old) = (start(None), start(Some(4)));
        assert_ne!(now.state().bits(), old.state().bits());
        let h = Header::new(&model, Vec::new(), Options::default(), &now, Vec::new(), engine::Options::default());
        assert_eq!(h.scene(&catalog).expect("it is the same").state().bits(), now.state().bits());
        let h = Header { arithmetic: 4, start: old.state().bits(), ..h };
        let again = h.scene(&catalog).expect("it is the old one").scene;
        assert!(h.is_exact(&again) && again.state().bits() == h.start);
    }
}
