//! The accounts of energy, as data; [`crate::op::energy`] writes them.
//!
//! Accounts are [`Real::Outer`]: `f64` in both precisions, and with derivatives over dual numbers, whose [`Ledger::balance`] so
//! has those of each sum (docs/numerics.md §9). `peak`, `received` and `worst`, and the energy that a hand gives, are `f64`.

use crate::numeric::Real;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// Links, or masses, that are computed together.
pub const BLOCK: usize = 64;
/// A number of each link of a block.
pub type Block<R = f64> = [R; BLOCK];

/// Numbers in passing: a block of each, kept since to clear them takes as long as to enter a few links.
#[derive(Clone, Debug, PartialEq)]
pub struct Room<R: Real = f64> {
    /// elongations before, at and after the tick
    pub(crate) e: [Block<R>; 3],
    /// how far the ends moved along the force in the two ticks together
    pub(crate) moved: Block<R>,
    /// stored, heat
    pub(crate) out: [Block<R>; 2],
}

impl<R: Real> Default for Room<R> {
    fn default() -> Room<R> {
        Room { e: [[R::ZERO; BLOCK]; 3], moved: [R::ZERO; BLOCK], out: [[R::ZERO; BLOCK]; 2] }
    }
}

/// The largest of each so far \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extremes {
    /// largest so far of |h|, or of its part in motion, + Σ|lost|: the scale of the residual
    pub peak: f64,
    /// largest so far of h, or of its part in motion, + Σlost, less the energy made by the scheme until then: the most that load,
    /// ports, changes and weight had given
    pub received: f64,
    /// largest imbalance of a single tick
    pub worst: f64,
}

/// The account of groups at the gesture rate \[J\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupAccount<R: Real = f64> {
    /// what their border gave them beyond what it took from the sound, where it is compensated; 0 where it is exact
    pub border: R::Outer,
    /// energy that these groups hold and lose by a separate ledger, up to the last frame
    pub slow: Balance<R>,
}

/// The accounts \[J\]. `h = h0 + work − lost + scheme_error + changed + residual`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger<R: Real = f64> {
    /// energy at load
    pub h0: R::Outer,
    /// energy now, between the last tick and the one before
    pub h: R::Outer,
    /// its part in motion
    pub kinetic: R::Outer,
    /// the largest of each so far
    pub extremes: Extremes,
    /// heat of MATs with dampers of their own, and of the ends of waveguides
    pub lost_mats: R::Outer,
    /// heat of each link (n_lia)
    pub lost: Vec<R::Outer>,
    /// energy made (+) or taken (−) by the scheme in each link (n_lia); 0 for linear ones
    pub scheme_error: Vec<R::Outer>,
    /// work received from each port: position ports, device ports, force ports
    pub work: Vec<R::Outer>,
    /// work received from a pointer that pulls, see [`crate::pointer`]
    pub pointer: R::Outer,
    /// groups at the gesture rate
    pub groups: GroupAccount<R>,
    /// work received from groups at the gesture rate
    pub(crate) crossed: R::Outer,
    /// that of the tick which the ledger has not entered yet
    pub(crate) pulled: R::Outer,
    /// what crossed each device port (tgr), counted by frames
    pub hands: Vec<Exchange>,
    /// energy that came in by changing parameters or moving interaction points
    pub changed: R::Outer,
    /// d of the tick that the ledger is at (n_mat)
    pub(crate) d0: Vec<R>,
    /// magnitude of the heat of each tick so far, kept apart so that no tick sums over all links again
    pub(crate) heat: f64,
    /// heat so far
    pub(crate) net_heat: f64,
    /// error of the scheme so far, kept apart for the same reason
    pub(crate) made: f64,
    /// force on position and device ports, force given by force ports (ports)
    pub(crate) port: Vec<R::Outer>,
    /// energy stored by each link at the last tick of the ledger (n_lia)
    pub(crate) stored: Vec<R::Outer>,
    /// where the moving points were when the last tick was entered, and their motion (moving points x 2)
    pub(crate) points: Vec<[R; 2]>,
    /// energy stored by each batch of links then (accounts)
    pub(crate) stored_batches: Vec<R::Outer>,
    /// energy stored by MATs and weight then, and that of motion
    pub(crate) stored_mats: R::Outer,
    /// mass of each MAT, as T²C⁻¹; 0 of what no force moves (n_mat)
    pub(crate) mass: Vec<R::Outer>,
    /// whether it has looked at what everything holds at load: a state at load may be played on from any tick
    pub(crate) begun: bool,
    /// whether coefficients were on their way then
    pub(crate) turning: bool,
    /// numbers in passing
    pub(crate) room: Box<Room<R>>,
    /// force \[N\] that only the first tick has, see the start of mi.lib (n_mat, or none)
    pub(crate) kick: Vec<R>,
}

/// Gives a ledger the force \[N\] that only the first tick has (n_mat).
pub fn set_kick<R: Real>(ledger: &mut Ledger<R>, kick: Vec<R>) {
    ledger.kick = kick;
}

/// What crossed the border at one device port, whole frames only \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// energy the scene received: the force of each frame times the motion of the port in it
    pub received: f64,
    /// energy the hand gave: the force it was sent, held over the frame, times its own motion
    pub given: f64,
    /// where the hand was at the last frame, absolute \[m\]
    pub(crate) hand: f64,
    /// the force on the port at the last frame's end \[N\]
    pub(crate) last: f64,
    /// the force it has been held since \[N\]
    pub(crate) held: f64,
    /// what has been collected of the force so far \[N\], where no force goes to the hand; kept here rather than in
    /// [`Border::sum`](crate::state::Border::sum), since it decides nothing of the future
    pub(crate) sum: f64,
}

impl Exchange {
    /// Energy the border made (+) or taken (−), by answering late or not at all.
    pub fn leak(&self) -> f64 {
        self.received - self.given
    }
}

/// Sums of the ledgers, for people.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance<R: Real = f64> {
    /// energy at load \[J\]
    pub h0: R::Outer,
    /// energy now \[J\]
    pub h: R::Outer,
    /// heat \[J\]
    pub lost: R::Outer,
    /// error of the scheme: what non-linear links, and a compensated border, gave that nothing gave them \[J\]
    pub scheme_error: R::Outer,
    /// received from ports and a pointer \[J\]
    pub work: R::Outer,
    /// received by changes \[J\]
    pub changed: R::Outer,
    /// residual, what the ledger does not explain \[J\]
    pub residual: R::Outer,
    /// scale of the residual \[J\]
    pub peak: f64,
    /// most energy received, see [`Extremes::received`] \[J\]
    pub received: f64,
}

impl<R: Real> Ledger<R> {
    /// The sums.
    pub fn balance(&self) -> Balance<R> {
        let (lost, scheme_error) =
            (self.lost_mats + self.lost.iter().sum::<R::Outer>(), self.scheme_error.iter().sum::<R::Outer>());
        let work = self.work.iter().sum::<R::Outer>() + self.pointer;
        let residual = self.h - self.h0 - work - self.crossed + lost - scheme_error - self.changed;
        let slow = &self.groups.slow;
        Balance {
            h0: self.h0 + slow.h0,
            h: self.h + slow.h + self.under_way(),
            lost: lost + slow.lost,
            scheme_error: scheme_error + self.groups.border + slow.scheme_error,
            work,
            changed: self.changed + slow.changed,
            residual: residual + slow.residual,
            peak: self.extremes.peak + slow.peak,
            received: self.extremes.received + slow.received,
        }
    }

    /// What one side of the border of groups at the gesture rate gave and the other has not entered yet \[J\], a part of the energy
    /// now: when a frame is entered, what the links across do in half a tick.
    pub fn under_way(&self) -> R::Outer {
        self.groups.border - (self.crossed + self.groups.slow.work)
    }

    /// The link that made the most energy, with its account; `None` where none made any.
    pub fn largest_error(&self) -> Option<(usize, f64)> {
        let (i, s) = self.scheme_error.iter().enumerate().max_by(|a, b| a.1.wide().total_cmp(&b.1.wide()))?;
        (s.wide() > 0.0).then_some((i, s.wide()))
    }
}
