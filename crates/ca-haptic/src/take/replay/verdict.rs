//! Result of a replay, and comparisons of numbers and frames.

use crate::frame::ForceFrame;
use std::fmt;

/// The first difference, or the largest one where a tolerance is allowed.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Sound sample.
    pub tick: u64,
    /// Time \[s\].
    pub time: f64,
    /// Name of the thing: a field of a frame of a device, a sample, or a hash.
    pub what: String,
    /// Value in the take.
    pub was: String,
    /// Value in the replay.
    pub is: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Difference { tick, time, what, was, is } = self;
        write!(f, "{what} at {time:.6} s (tick {tick}): was {was}, is now {is}")
    }
}

/// Result of a replay.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReplayVerdict {
    /// Gesture frames computed.
    pub frames: u64,
    /// Device frames passed to the engine.
    pub taken: u64,
    /// Force frames compared.
    pub forces: u64,
    /// Sound samples compared, of all channels.
    pub samples: u64,
    /// Hashes of the state compared.
    pub hashes: u64,
    /// Versions of the model that played, including the first.
    pub versions: u32,
    /// Length \[s\].
    pub seconds: f64,
    /// Allowed difference of forces and sound as a part of their peak; 0 for bit-exact comparison.
    pub tolerance: f64,
    /// The difference, if any.
    pub difference: Option<Difference>,
    /// Time from which records are missing, so that nothing later was compared \[s\].
    pub hole: Option<f64>,
    /// Reason why the file ends early or is not used to its end.
    pub cut: Option<String>,
    /// True if that reason is corrupt bytes.
    pub damaged: bool,
}

impl ReplayVerdict {
    /// Returns true if something was compared, nothing differs beyond the tolerance, and nothing is missing before the
    /// end.
    pub fn is_identical(&self) -> bool {
        let compared = self.forces > 0 || self.samples > 0 || self.hashes > 0;
        compared && self.difference.is_none() && self.hole.is_none()
    }
}

#[derive(Default)]
pub(super) struct Deviation {
    peak: f64,
    /// Largest difference so far.
    worst: Option<(f64, Difference)>,
}

impl Deviation {
    pub(super) fn see(&mut self, was: f64, is: f64, difference: impl FnOnce() -> Difference) {
        self.peak = self.peak.max(was.abs());
        let apart = (is - was).abs();
        // NaN equals only the same NaN
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

    /// Returns the largest difference if it exceeds `part` of the peak.
    pub(super) fn beyond(self, part: f64) -> Option<Difference> {
        self.worst.filter(|(apart, _)| *apart > part * self.peak).map(|(_, d)| d)
    }
}

/// Returns the name and both values of the first field in which two force frames differ.
pub(super) fn which(was: &ForceFrame, is: &ForceFrame) -> (String, String, String) {
    if let Some(k) = (0..was.force.len()).find(|k| was.force[*k].to_bits() != is.force[*k].to_bits()) {
        return (
            format!("the force at degree of freedom {k}"),
            format!("{:e} N", was.force[k]),
            format!("{:e} N", is.force[k]),
        );
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
        || ("the header".into(), "other bytes".into(), "different bytes".into()),
        |(a, b)| (format!("`{}`", a.0), a.1.to_string(), b.1.to_string()),
    )
}
