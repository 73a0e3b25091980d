//! What was proven of a scene's stability, as data; the compiler writes it.

use alloc::string::String;
use alloc::vec::Vec;

/// How sure the statement is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Level {
    /// every link is linear or of a method that keeps energy, and the bound is below the limit: passive by theorem at every setting;
    /// changing a parameter or moving a point does work. A contact or a friction at a moving port may still make some
    Proven,
    /// as `Proven` for small motions about the pose at load; distances in space keep energy to [`Certificate::ripple`],
    /// without drift
    Linearised,
    /// the linear links are proven; rules of thumb judge contacts and non-linear links, and set-valued friction of shared masses
    /// creeps
    RuleOfThumb,
    /// neither the bounds nor, where there was one, a factorisation settles it; or groups at the gesture rate have a compensated
    /// border
    #[default]
    NotProven,
    /// above the limit, by a module alone or by all together
    Unstable,
}

impl core::fmt::Display for Level {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Level::Proven => "proven",
            Level::Linearised => "linearised",
            Level::RuleOfThumb => "rule of thumb",
            Level::NotProven => "not proven",
            Level::Unstable => "unstable",
        })
    }
}

/// What a factorisation says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorVerdict {
    /// all eigenvalues are below the limit
    Stable,
    /// one is above it
    Unstable,
    /// it depends on more than was looked at
    Open,
}

/// A device key and what holds it.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Key {
    /// its name
    pub name: String,
    /// sum of the largest slopes of all links at it \[N/m\]; of laws that stiffen without end, the slope at rest
    pub k: f64,
    /// sum of the viscosities of all links at it \[N s/m\], the steepest of a curve
    pub z: f64,
    /// friction that sticks holds it: set-valued, so that no slope is known
    pub sticks: bool,
    /// of which modules: name and slope \[N/m\], those of a list or a set together
    pub links: Vec<(String, f64)>,
}

/// Contacts, non-linear links and friction, which are judged by rule (docs/numerics.md §3.2).
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Rules {
    /// largest contact stiffness ratio kT²/m; an explicit contact makes energy at any, see
    /// [`Growth::near`](crate::scene::growth::Growth::near)
    pub contact: f64,
    /// the contact it belongs to
    pub stiffest: String,
    /// largest T²k + 2Tz against the masses of a contact while it presses, where it is steepest within reach; at 4 and above it is
    /// unstable by itself
    pub closed: f64,
    /// of what is judged by rule, the link that uses the largest share of its limit
    pub decides: String,
    /// hardening links with an unknown largest elongation: the certificate judges them at rest
    pub open: Vec<String>,
    /// of contacts by a power of their depth, p q η^(p−1) T²/m reaches 1 in this one first, at this depth η \[m\]
    pub depth: Option<(String, f64)>,
    /// steepest friction along a curve against the masses, slope·T/m; recommended up to 1.5
    pub friction: f64,
}

/// What the compiler could prove.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Certificate {
    /// how sure
    pub level: Level,
    /// upper bound of the largest eigenvalue of T²K + 2TC against M; the limit is 4. Of a model that goes by `pefrl`
    /// it is counted in quarters of that method's own, [`crate::method::pefrl::LIMIT`]
    pub bound: f64,
    /// lower bound of the same
    pub lower: f64,
    /// true where a factorisation decided what the bounds left open
    pub exact: bool,
    /// the largest eigenvalue itself, from … to, where it was asked for
    pub largest: Option<(f64, f64)>,
    /// where a factorisation decided: how much T²k + 2Tz of one more link from any one mass to the ground may be against
    /// its mass \[1\], rounded down to a power of two, so that its last digits, which differ between processors, decide nothing.
    /// `None` where it was not looked at
    pub room: Option<f64>,
    /// of a linearised scene: by what share of itself the energy above that of rest may at most rise, at any time, above
    /// what it was at any time before; for motions small against the lengths of links, about a pose of rest in which no
    /// link is pressed, and left alone. `None` where that is not known
    pub ripple: Option<f64>,
    /// the module nearest to the limit; empty where nothing has one
    pub worst: String,
    /// contacts, non-linear links and friction
    pub rules: Rules,
    /// items with masses that nothing hears: they are left out, and nothing here is said of them
    pub not_judged: Vec<String>,
    /// device keys that something stiff holds
    pub keys: Vec<Key>,
}

impl Certificate {
    /// How many times stiffer everything could be: limit over what is known of the largest eigenvalue from above, or what
    /// the rules leave to the stiffest contact (up to 1, and 4 with its viscosity) and the steepest friction (up to 1.5), where
    /// that is less.
    /// Infinite where nothing has a limit: without links, or with methods that have none.
    pub fn margin(&self) -> f64 {
        let linear = 4.0 / self.largest.map_or(self.bound, |l| l.1).max(0.0);
        let room = |limit: f64, now: f64| if now > 0.0 { limit / now } else { f64::INFINITY };
        linear.min(room(1.0, self.rules.contact)).min(room(4.0, self.rules.closed)).min(room(1.5, self.rules.friction))
    }
}
