//! Reasons why the forces of an armed device have not begun (H5), for people.
//!
//! The gate reports them itself, from its own comparisons. On the wire a withheld force is zero like any other.

use core::fmt;

/// Condition that keeps forces from beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Wait {
    /// None: forces are on, the device is not armed, or the time without a push is being counted.
    #[default]
    Nothing,
    /// No frame came, or too long ago.
    Stale,
    /// The device has neither a profile nor a description of itself.
    Undescribed,
    /// The device does not report that it is calibrated and has power.
    NotReady,
    /// The scene is still moving to the position of the device.
    OnTheWay,
    /// The hand moves too fast.
    Fast {
        /// Degree of freedom.
        dof: u32,
        /// Speed \[m/s\].
        speed: f64,
        /// Speed limit \[m/s\].
        limit: f64,
    },
    /// The model pushes.
    Presses {
        /// First degree of freedom of the vector that pushes most.
        dof: u32,
        /// Its force \[N\].
        force: f64,
        /// Force below which nothing pushes \[N\].
        limit: f64,
        /// Number of vectors that push.
        count: u32,
    },
}

impl Wait {
    /// Returns the reason as text, with `name` giving the name of a degree of freedom.
    pub fn text(&self, name: &dyn Fn(u32) -> String) -> String {
        match *self {
            Wait::Nothing => "nothing".into(),
            Wait::Stale => "the device sends no position".into(),
            Wait::Undescribed => {
                "the device does not have a profile (`--profile`) and does not describe itself (`About`)".into()
            }
            Wait::NotReady => "the device does not report that it is calibrated and powered".into(),
            Wait::OnTheWay => "the model is still moving to the position of the device".into(),
            Wait::Fast { dof, speed, limit } => {
                format!("{} moves at {} m/s; hold it still, below {} m/s", name(dof), short(speed), short(limit))
            }
            Wait::Presses { dof, force, limit, count } => {
                let others = if count > 1 { format!(" (and on {} more)", count - 1) } else { String::new() };
                format!(
                    "the model pushes on {} with {} N{others}; move it to where the force is below {} N",
                    name(dof),
                    short(force),
                    short(limit)
                )
            }
        }
    }
}

fn short(v: f64) -> String {
    let digits = if v > 0.0 { (2 - v.log10().floor() as i32).clamp(0, 12) as usize } else { 0 };
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

impl fmt::Display for Wait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(&|dof| format!("degree of freedom {dof}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (v, want) in
            [(0.0, "0"), (0.612_34, "0.612"), (0.1, "0.1"), (12.345, "12.3"), (1234.5, "1234"), (2e-4, "0.0002")]
        {
            assert_eq!(short(v), want);
        }
    }

    #[test]
    fn it_says_which_and_how_much() {
        let w = Wait::Presses { dof: 3, force: 0.61, limit: 0.1, count: 2 };
        assert_eq!(
            w.to_string(),
            "the model pushes on degree of freedom 3 with 0.61 N (and on 1 more); move it to where the force is below 0.1 N"
        );
    }
}
