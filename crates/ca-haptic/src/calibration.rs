//! Calibration: from what a device says to metres, and from newtons to what it takes.
//!
//! Decides to keep it apart from every modelling choice (GENESIS paper, 6.4): a file per device, made once by
//! `ca device calibrate`, valid for every model until the hardware changes. A device process that speaks metres and
//! newtons by itself needs none; gains here are then what is left to correct.

use crate::frame::{DOF, fnv};
use ca_io::error::{FileError, FileErrorKind};
use serde::{Deserialize, Serialize};

/// Largest number of an axis: beyond it a force of a newton is none that the wire holds.
const LARGEST: f64 = 1e9;

/// One degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Axis {
    /// metres per unit of what the device says
    pub scale: f64,
    /// position \[m\] where the device says 0
    pub offset: f64,
    /// what the device takes per newton
    pub force: f64,
}

impl Default for Axis {
    fn default() -> Axis {
        Axis { scale: 1.0, offset: 0.0, force: 1.0 }
    }
}

/// The calibration of a device; empty is none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// name of the device
    #[serde(default)]
    pub device: String,
    /// who did it, and with what
    #[serde(default)]
    pub by: String,
    /// its degrees of freedom, from the first; those beyond have no correction
    #[serde(default)]
    pub axis: Vec<Axis>,
}

impl Calibration {
    /// Reads a calibration. `file` is named in errors.
    ///
    /// # Errors
    /// With the line, where the text is no calibration or a number is out of bounds.
    pub fn read(text: &str, file: &str) -> Result<Calibration, FileError> {
        let bad = |what: String| FileError::new(FileErrorKind::Content, format!("{file}: {what}"));
        let c: Calibration = toml::from_str(text).map_err(|e| bad(e.to_string().trim_end().into()))?;
        if c.axis.len() > DOF {
            return Err(bad(format!("at most {DOF} axes")));
        }
        for (k, a) in c.axis.iter().enumerate() {
            let numbers =
                [("scale", a.scale, 1.0 / LARGEST), ("force", a.force, 1.0 / LARGEST), ("offset", a.offset, 0.0)];
            for (name, v, least) in numbers {
                if !(v.abs() >= least && v.abs() <= LARGEST) {
                    let from = if least > 0.0 { "of a size from 1e-9 to 1e9" } else { "from -1e9 to 1e9" };
                    return Err(bad(format!("axis {k}: `{name}` must be {from}, it is {v}")));
                }
            }
        }
        Ok(c)
    }

    /// Text of this calibration, as [`Calibration::read`] takes it.
    pub fn write(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Its id on the wire: a hash of its numbers; 0 where it corrects nothing.
    pub fn id(&self) -> u64 {
        if self.axis.is_empty() {
            return 0;
        }
        let bits = |a: &Axis| [a.scale, a.offset, a.force].map(f64::to_le_bytes).concat();
        fnv(&self.axis.iter().flat_map(bits).collect::<Vec<u8>>())
    }

    /// Positions as the device says them, to metres.
    pub fn positions(&self, pos: &mut [f64; DOF]) {
        for (x, a) in pos.iter_mut().zip(&self.axis) {
            *x = a.scale * *x + a.offset;
        }
    }

    /// Newtons to what the device takes.
    pub fn forces(&self, force: &mut [f32; DOF]) {
        for (f, a) in force.iter_mut().zip(&self.axis) {
            *f = (f64::from(*f) * a.force) as f32;
        }
    }
}
