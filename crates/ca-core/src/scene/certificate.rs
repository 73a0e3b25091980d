//! The certificate of a scene's stability, as data. The compiler writes it.

use alloc::string::String;
use alloc::vec::Vec;

/// Level of certainty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Level {
    /// every link is linear or conserves energy by its method, and the bound is below the limit: passive by theorem at
    /// every setting. Changing a parameter or moving a point does work
    Proven,
    /// like `Proven`, for small motions about the pose at load; distances conserve energy up to [`Certificate::ripple`]
    Linearised,
    /// the linear links are proven, others judged by rules of thumb; set-valued friction of shared masses creeps, and
    /// contacts beyond kT²/m = 1e9 may add energy by rounding
    RuleOfThumb,
    /// neither bounds nor a factorisation decide, or groups at the gesture rate have a compensated border
    #[default]
    NotProven,
    /// above the limit, by one module or by all together
    Unstable,
}

impl core::fmt::Display for Level {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Level::Proven => "proven",
            Level::Linearised => "linear part proven",
            Level::RuleOfThumb => "rule of thumb",
            Level::NotProven => "not proven",
            Level::Unstable => "unstable",
        })
    }
}

/// Result of a factorisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorVerdict {
    /// all eigenvalues are below the limit
    Stable,
    /// one eigenvalue is above the limit
    Unstable,
    /// undecided: it depends on more than was examined
    Open,
}

/// A device key and its links.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Key {
    /// name of the key
    pub name: String,
    /// sum of the largest slopes of all links at it \[N/m\]; for laws that stiffen without limit, the slope at rest
    pub k: f64,
    /// sum of the viscosities of all links at it \[N s/m\], for a curve the steepest
    pub z: f64,
    /// true if set-valued friction holds it, which has no known slope
    pub sticks: bool,
    /// modules that contribute to `k`: name and slope \[N/m\], summed over a list or a set
    pub links: Vec<(String, f64)>,
}

/// Rules of thumb for contacts, non-linear links and friction (docs/numerics.md §3.2).
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Rules {
    /// largest contact stiffness ratio kT²/m; an explicit contact makes energy at any ratio, see
    /// [`Growth::near`](crate::scene::growth::Growth::near)
    pub contact: f64,
    /// name of the contact with this ratio
    pub stiffest: String,
    /// largest T²k + 2Tz of a closed contact against its masses, at its steepest within reach; from 4 on it is unstable
    pub closed: f64,
    /// name of the link that uses the largest share of its limit, among those judged by rule
    pub decides: String,
    /// hardening links with an unknown largest elongation, which are judged at rest
    pub open: Vec<String>,
    /// contact by a power of its depth η whose p q η^(p−1) T²/m reaches 1 first, and this depth \[m\]
    pub depth: Option<(String, f64)>,
    /// steepest friction along a curve against the masses, slope·T/m; at most 1.5 is recommended
    pub friction: f64,
}

/// Stability statements that the compiler could prove.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Certificate {
    /// level of certainty
    pub level: Level,
    /// upper bound of the largest eigenvalue of T²K + 2TC against M; the limit is 4. For a model with `pefrl` it is
    /// scaled so that 4 stands for the limit of that method, [`crate::method::pefrl::LIMIT`]
    pub bound: f64,
    /// lower bound of the same eigenvalue
    pub lower: f64,
    /// true if a factorisation decided what the bounds left open
    pub exact: bool,
    /// interval of the largest eigenvalue itself, if requested
    pub largest: Option<(f64, f64)>,
    /// after a factorisation: the largest T²k + 2Tz that one more link from any single mass to ground may have against
    /// its mass \[1\], rounded down to a power of two, since last digits differ between processors; `None` if not
    /// examined
    pub headroom: Option<f64>,
    /// for a linearised scene: the largest rise of the energy above rest, at any time, over any earlier value, relative
    /// to that value. It holds for an undisturbed scene, for motions small against the lengths of links, about a pose
    /// of rest in which links carry no force. `None` if it is not known
    pub ripple: Option<f64>,
    /// module nearest to the limit; empty if no module has one
    pub worst: String,
    /// contacts, non-linear links and friction
    pub rules: Rules,
    /// items that have masses but do not reach any output: they are left out, and the certificate does not cover them
    pub not_judged: Vec<String>,
    /// device keys with stiff links
    pub keys: Vec<Key>,
}

impl Certificate {
    /// Returns the factor by which everything could be stiffer: the limit over the upper bound of the largest
    /// eigenvalue, or the margin of the stiffest contact (up to 1, and 4 with viscosity) or steepest friction (up to
    /// 1.5), if less.
    ///
    /// It is infinite if nothing has a limit: without links, or with methods without a limit.
    pub fn margin(&self) -> f64 {
        let linear = 4.0 / self.largest.map_or(self.bound, |l| l.1).max(0.0);
        let factor = |limit: f64, now: f64| if now > 0.0 { limit / now } else { f64::INFINITY };
        linear
            .min(factor(1.0, self.rules.contact))
            .min(factor(4.0, self.rules.closed))
            .min(factor(1.5, self.rules.friction))
    }
}
