//! What a replay finds, and how two numbers or frames are compared.

use crate::frame::ForceFrame;
use std::fmt;

/// The first thing that is not as it was, or, to a tolerance, what is furthest from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// sound sample
    pub tick: u64,
    /// when \[s\]
    pub time: f64,
    /// what: which frame of which device and which of its fields, which sample, which hash
    pub what: String,
    /// as it was
    pub was: String,
    /// as it is
    pub is: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Difference { tick, time, what, was, is } = self;
        write!(f, "{what} at {time:.6} s (tick {tick}): it was {was}, it is {is}")
    }
}

/// What a replay found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReplayVerdict {
    /// gesture frames computed again
    pub frames: u64,
    /// device frames given to the engine
    pub taken: u64,
    /// force frames compared
    pub forces: u64,
    /// sound samples compared, of all channels
    pub samples: u64,
    /// hashes of the state compared
    pub hashes: u64,
    /// versions of the model that played, the first included
    pub versions: u32,
    /// length \[s\]
    pub seconds: f64,
    /// how far forces and sound may be from what they were, as a part of their peak; 0 where to the bit
    pub tolerance: f64,
    /// the first thing that is not as it was
    pub difference: Option<Difference>,
    /// where something is missing in the take, so that nothing after it was compared \[s\]
    pub hole: Option<f64>,
    /// why the file ends early, or is not used to its end, where that is so
    pub cut: Option<String>,
    /// true where that is because bytes in it are not as they were written
    pub damaged: bool,
}

impl ReplayVerdict {
    /// True where something was compared, all of it is as it was, to the tolerance, and nothing is missing up to the end of the
    /// file.
    pub fn is_identical(&self) -> bool {
        let compared = self.forces > 0 || self.samples > 0 || self.hashes > 0;
        compared && self.difference.is_none() && self.hole.is_none()
    }
}

/// Numbers of one kind, compared to a tolerance.
#[derive(Default)]
pub(super) struct Apart {
    peak: f64,
    /// the largest difference so far, and where it is
    worst: Option<(f64, Difference)>,
}

impl Apart {
    pub(super) fn see(&mut self, was: f64, is: f64, difference: impl FnOnce() -> Difference) {
        self.peak = self.peak.max(was.abs());
        let apart = (is - was).abs();
        // NaN agrees with NaN only
        let apart = if was.to_bits() == is.to_bits() {
            0.0
        } else if apart.is_nan() {
            f64::INFINITY
        } else {
            apart
        };
        if apart > self.worst.as_ref().map_or(0.0, |w| w.0) {
            self.worst = Some((apart, difference()));
        }
    }

    /// What is further off than `part` of the peak.
    pub(super) fn beyond(self, part: f64) -> Option<Difference> {
        self.worst.filter(|(apart, _)| *apart > part * self.peak).map(|(_, d)| d)
    }
}

/// The first field in which two force frames differ, with both values.
pub(super) fn which(was: &ForceFrame, is: &ForceFrame) -> (String, String, String) {
    if let Some(k) = (0..was.force.len()).find(|k| was.force[*k].to_bits() != is.force[*k].to_bits()) {
        return (format!("the force of degree {k}"), format!("{:e} N", was.force[k]), format!("{:e} N", is.force[k]));
    }
    let fields = |f: &ForceFrame| {
        [
            ("mode", u64::from(f.mode)),
            ("cause", u64::from(f.cause)),
            ("flags", u64::from(f.flags)),
            ("inject", u64::from(f.inject.to_bits())),
            ("seq", f.seq),
            ("session", f.session),
            ("ack", f.ack),
            ("ack_session", f.ack_session),
            ("tick", f.tick),
            ("calibration", f.calibration),
            ("ttl_us", u64::from(f.ttl_us)),
        ]
    };
    let differ = fields(was).into_iter().zip(fields(is)).find(|(a, b)| a.1 != b.1);
    differ.map_or_else(
        || ("the head".into(), "other bytes".into(), "others".into()),
        |(a, b)| (format!("`{}`", a.0), a.1.to_string(), b.1.to_string()),
    )
}
