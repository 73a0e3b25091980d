//! Calibration: converts device readings to metres and newtons to device commands.
//!
//! It is separate from every modelling choice (GENESIS paper, 6.4): one file per device, made once by `ca device
//! calibrate`, valid for every model until the hardware changes. A device process that already uses metres and newtons
//! needs none; its gains here are then small corrections.

use crate::frame::{DOF, fnv};
use ca_io::error::{FileError, FileErrorKind};
use serde::{Deserialize, Serialize};

/// Largest magnitude of a number of an axis. Beyond it, the wire cannot hold a force of one newton.
const LARGEST: f64 = 1e9;

/// Calibration of one degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Axis {
    /// Metres per unit of the device's reading.
    pub scale: f64,
    /// Position \[m\] at a reading of 0.
    pub offset: f64,
    /// Device units per newton.
    pub force: f64,
}

impl Default for Axis {
    fn default() -> Axis {
        Axis { scale: 1.0, offset: 0.0, force: 1.0 }
    }
}

/// The calibration of a device; an empty one corrects nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Name of the device.
    #[serde(default)]
    pub device: String,
    /// Person who calibrated it, and the tools used.
    #[serde(default)]
    pub by: String,
    /// Degrees of freedom, from the first. Those beyond the list are not corrected.
    #[serde(default)]
    pub axis: Vec<Axis>,
}

impl Calibration {
    /// Parses a calibration. `file` is the name used in errors.
    ///
    /// # Errors
    /// Names the line, where the text is not a calibration or a number is out of bounds.
    pub fn read(text: &str, file: &str) -> Result<Calibration, FileError> {
        let bad = |what: String| FileError::new(FileErrorKind::Content, format!("{file}: {what}"));
        let c: Calibration = toml::from_str(text).map_err(|e| bad(e.to_string().trim_end().into()))?;
        if c.axis.len() > DOF {
            return Err(bad(format!("{} axes; at most {DOF} are allowed", c.axis.len())));
        }
        for (k, a) in c.axis.iter().enumerate() {
            let numbers =
                [("scale", a.scale, 1.0 / LARGEST), ("force", a.force, 1.0 / LARGEST), ("offset", a.offset, 0.0)];
            for (name, v, least) in numbers {
                if !(v.abs() >= least && v.abs() <= LARGEST) {
                    let from = if least > 0.0 {
                        "its absolute value must be from 1e-9 to 1e9"
                    } else {
                        "it must be from -1e9 to 1e9"
                    };
                    return Err(bad(format!("axis {k}: `{name}` is {v}; {from}")));
                }
            }
        }
        Ok(c)
    }

    /// Returns the calibration as text that [`Calibration::read`] parses.
    pub fn write(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Returns the id on the wire: a hash of the numbers, or 0 without axes.
    pub fn id(&self) -> u64 {
        if self.axis.is_empty() {
            return 0;
        }
        let bits = |a: &Axis| [a.scale, a.offset, a.force].map(f64::to_le_bytes).concat();
        fnv(&self.axis.iter().flat_map(bits).collect::<Vec<u8>>())
    }

    /// Converts positions in place from device units to metres.
    pub fn positions(&self, pos: &mut [f64; DOF]) {
        for (x, a) in pos.iter_mut().zip(&self.axis) {
            *x = a.scale * *x + a.offset;
        }
    }

    /// Converts forces in place from newtons to device units.
    pub fn forces(&self, force: &mut [f32; DOF]) {
        for (f, a) in force.iter_mut().zip(&self.axis) {
            *f = (f64::from(*f) * a.force) as f32;
        }
    }
}
