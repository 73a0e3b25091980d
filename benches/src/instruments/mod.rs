//! Measured properties of the bundled instruments, and the claims of their headers that are confirmed:
//! `docs/instruments.md`.
//!
//! Every claim about an instrument is data beside the measure that supports it, in one file for each family below. The
//! page, the test of the workspace and the test with a simulated device use this data, so they cannot differ. A
//! sentence of a claim is an excerpt of the header of the model, word for word, except for line breaks.
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
//! `plays.rs` has the measures. A device plays each instrument with TGR in
//! `crates/ca-cli/tests/loop/in_real_time/instruments.rs`, by [`Stroke::DEFAULT`] unless `stroke` says otherwise. Then
//! `UPDATE=1 cargo bench -p ca-benches --bench instruments` writes the page, its pictures and its sounds; `UPDATE=1
//! cargo test $ALL --test suite -- instruments` writes the figures alone.

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

/// A claimed pitch.
#[derive(Clone, Copy, Debug)]
pub struct Pitch {
    /// Claimed frequency \[Hz\].
    pub hertz: f64,
    /// Part of a take where it is measured.
    pub cut: Cut,
}

/// A sentence of a header with the figure that supports it.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// Sentence, or a part of it, as in the header.
    pub sentence: &'static str,
    /// Description of the figure, with `{}` in its place.
    pub shows: &'static str,
    /// Returns the figure.
    pub measure: fn(&Plays) -> f64,
    /// Least and largest figure that support the claim.
    pub range: [f64; 2],
}

/// A bundled instrument with its claims.
#[derive(Clone, Copy, Debug)]
pub struct Instrument {
    /// Name, as in `models/NAME.ca.toml`.
    pub model: &'static str,
    /// Claimed pitch.
    pub pitch: Option<Pitch>,
    /// Soft stroke, for the centroid.
    pub soft: Cut,
    /// Loud stroke.
    pub loud: Cut,
    /// Part in which the decay is measured, from its loudest moment on.
    pub decay: Cut,
    /// Probes for the claims.
    pub probes: &'static [&'static str],
    /// Stroke of a simulated device.
    pub stroke: Stroke,
    /// Summary of the figures, and weaknesses of the sound.
    pub remark: &'static str,
    /// Claims of its header.
    pub claims: &'static [Claim],
}

impl Instrument {
    /// Makes an instrument without a pitch and claims, whose built-in gesture serves as soft, loud and decaying.
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

    /// Loads its model from `models/`.
    pub fn load(&self) -> Loaded {
        let path = folder().join(format!("{}.ca.toml", self.model));
        Loaded::open(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }
}

/// Returns the folder of the bundled models.
pub fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../models")
}

/// Returns all instruments, by name.
pub fn all() -> Vec<&'static Instrument> {
    let families = [bars::ALL, keys::ALL, plates::ALL, space::ALL, strings::ALL, wind::ALL];
    let mut all: Vec<&Instrument> = families.into_iter().flatten().collect();
    all.sort_by_key(|i| i.model);
    all
}

/// Returns a text with every gap replaced by one blank.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs `work` for each instrument, on all cores; returns the results in order.
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
