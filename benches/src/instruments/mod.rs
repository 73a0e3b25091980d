//! The proof table of the bundled instruments, `docs/instruments.md`: what each is measured to be, and what of its header is so.
//!
//! Decides that all that is claimed of an instrument stands as data beside the measure that supports it, in one file for each
//! family below, so that the page, the test of the workspace and the test with a simulated device cannot differ. A sentence
//! is an excerpt of the header of the model, word for word, line breaks aside.
//!
//! To add an instrument, add to the list of a family:
//!
//! ```ignore
//! Instrument {
//!     pitch: Some(Pitch { hertz: 110.0, cut: BUILT.at(3.5, 5.5) }),     // left out where no pitch is claimed
//!     soft: BUILT.at(0.1, 0.8),                                         // or BUILT.set(&["hammer.v=0.3 m/s"]).at(0.0, 1.0)
//!     loud: BUILT.at(3.3, 4.0),                                         // or BUILT.moved(&[("hand", &[[0.0, 0.0], …])])
//!     remark: "Louder is brighter; …",                                  // what the figures say of it, and what is weak
//!     ..Instrument::new("hammered_string")
//! }
//! ```
//!
//! and to its `claims`, for each sentence that can be measured:
//!
//! ```ignore
//! Claim {
//!     says: "five strokes, soft to loud",                               // stands in the header so
//!     shows: "strokes that touch the string: {}",                       // the figure stands in place of {}
//!     measure: |p| p.contacts("strike", BUILT) as f64,                  // `probes: &["strike"]` of the instrument
//!     keeps: [5.0, 5.0],                                                // least and most
//! },
//! ```
//!
//! `plays.rs` has what a measure may ask. A device plays each instrument with TGR in `crates/ca-cli/tests/loop/in_real_time/instruments.rs`, by
//! [`Stroke::DEFAULT`] unless `stroke` says otherwise. Then
//! `UPDATE=1 cargo bench -p ca-benches --bench instruments` writes the page, its pictures and its sounds;
//! `UPDATE=1 cargo test $ALL --test suite -- instruments` writes the figures alone.

mod bars;
mod figures;
mod keys;
pub mod page;
mod plates;
mod plays;
mod space;
mod strings;
mod stroke;
mod wind;

pub use figures::{Figures, figures};
pub use plays::{BUILT, Cut, Plays, Render, Take, numbers};
pub use stroke::Stroke;

use cordis_anima::Loaded;
use std::path::PathBuf;

/// A pitch that is claimed.
#[derive(Clone, Copy, Debug)]
pub struct Pitch {
    /// what is claimed \[Hz\]
    pub hertz: f64,
    /// where it is heard
    pub cut: Cut,
}

/// A sentence of a header with the figure that supports it.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// the sentence, or a part of it, as it stands in the header
    pub says: &'static str,
    /// what is measured, with `{}` in place of the figure
    pub shows: &'static str,
    /// the figure
    pub measure: fn(&Plays) -> f64,
    /// least and most that keep the claim
    pub keeps: [f64; 2],
}

/// A bundled instrument, and what is claimed of it.
#[derive(Clone, Copy, Debug)]
pub struct Instrument {
    /// its name, `models/NAME.ca.toml`
    pub model: &'static str,
    /// the pitch it claims
    pub pitch: Option<Pitch>,
    /// a soft stroke, for the centroid
    pub soft: Cut,
    /// a loud one
    pub loud: Cut,
    /// where the decay is measured, from the loudest moment on
    pub decay: Cut,
    /// what is probed for the claims
    pub probes: &'static [&'static str],
    /// how a simulated device plays it
    pub stroke: Stroke,
    /// what the figures say of the sound, and what of it is weak
    pub remark: &'static str,
    /// what its header says
    pub claims: &'static [Claim],
}

impl Instrument {
    /// An instrument without a pitch and without claims, whose built-in gesture is soft, loud and decays.
    pub const fn new(model: &'static str) -> Instrument {
        Instrument {
            model,
            pitch: None,
            soft: BUILT.slower(1.5).whole(),
            loud: BUILT.whole(),
            decay: BUILT.whole(),
            probes: &[],
            stroke: Stroke::DEFAULT,
            remark: "",
            claims: &[],
        }
    }

    /// Its model, as it is in `models/`.
    pub fn load(&self) -> Loaded {
        let path = folder().join(format!("{}.ca.toml", self.model));
        Loaded::open(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }
}

/// The folder of the bundled models.
pub fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../models")
}

/// All instruments, by name.
pub fn all() -> Vec<&'static Instrument> {
    let families = [bars::ALL, keys::ALL, plates::ALL, space::ALL, strings::ALL, wind::ALL];
    let mut all: Vec<&Instrument> = families.into_iter().flatten().collect();
    all.sort_by_key(|i| i.model);
    all
}

/// A text in which all gaps are one blank.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// `work` of each instrument, on all cores, in order.
pub fn on_all_cores<T: Send>(work: impl Fn(&'static Instrument) -> T + Sync) -> Vec<T> {
    use std::sync::{Mutex, atomic::AtomicUsize, atomic::Ordering::Relaxed};
    let (all, next) = (all(), AtomicUsize::new(0));
    let done: Mutex<Vec<(usize, T)>> = Mutex::new(Vec::new());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|s| {
        for _ in 0..cores {
            s.spawn(|| {
                while let Some((k, one)) = Some(next.fetch_add(1, Relaxed)).and_then(|k| Some((k, *all.get(k)?))) {
                    let made = work(one);
                    done.lock().expect("no thread fails").push((k, made));
                }
            });
        }
    });
    let mut done = done.into_inner().expect("no thread fails");
    done.sort_by_key(|d| d.0);
    done.into_iter().map(|d| d.1).collect()
}
