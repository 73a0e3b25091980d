//! Why an armed device has no force yet (H5), for people.
//!
//! Decides that the gate says it itself, from the same comparisons, instead of somebody else working it out from the
//! wire, where a force that is held back is zero like any other.

use core::fmt;

/// What keeps forces from beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Wait {
    /// nothing: forces are on, nobody has armed them, or the time without a push is being counted
    #[default]
    Nothing,
    /// no frame came, or too long ago
    Stale,
    /// nobody has described it, and it has not said what it is
    Undescribed,
    /// it does not say that it is calibrated and has power
    NotReady,
    /// the scene is still on its way to where the device is
    OnTheWay,
    /// faster than the device may move \[m/s\]
    Fast {
        /// degree of freedom
        dof: u32,
        /// \[m/s\]
        speed: f64,
        /// the most \[m/s\]
        limit: f64,
    },
    /// the model presses
    Presses {
        /// first degree of freedom of the vector that presses most
        dof: u32,
        /// its force \[N\]
        force: f64,
        /// what counts as nothing \[N\]
        limit: f64,
        /// how many vectors press
        count: u32,
    },
}

impl Wait {
    /// The same with the degree of freedom called as `name` has it.
    pub fn said(&self, name: &dyn Fn(u32) -> String) -> String {
        match *self {
            Wait::Nothing => "nothing".into(),
            Wait::Stale => "it sends no position".into(),
            Wait::Undescribed => "nobody has described it, and it does not say what it is (`About`)".into(),
            Wait::NotReady => "it does not say that it is calibrated and has power".into(),
            Wait::OnTheWay => "the model is on its way to where the device is".into(),
            Wait::Fast { dof, speed, limit } => {
                format!("{} moves at {} m/s; hold it still, below {} m/s", name(dof), short(speed), short(limit))
            }
            Wait::Presses { dof, force, limit, count } => {
                let others = if count > 1 { format!(" (and {} more press)", count - 1) } else { String::new() };
                format!(
                    "{} presses with {} N{others}; move it to where it presses with less than {} N",
                    name(dof),
                    short(force),
                    short(limit)
                )
            }
        }
    }
}

/// Three digits.
fn short(v: f64) -> String {
    let digits = if v > 0.0 { (2 - v.log10().floor() as i32).clamp(0, 12) as usize } else { 0 };
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

impl fmt::Display for Wait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.said(&|dof| format!("degree of freedom {dof}")))
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
            "degree of freedom 3 presses with 0.61 N (and 1 more press); move it to where it presses with less than 0.1 N"
        );
    }
}
