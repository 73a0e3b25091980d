//! The energy accounts, as data. [`crate::op::energy`] writes them.
//!
//! Accounts are [`Real::Outer`]: `f64`, or with derivatives over dual numbers, also in [`Ledger::balance`]
//! (docs/numerics.md §9). `peak`, `received`, `worst` and the energy given at devices are always `f64`.

use crate::numeric::Real;
use alloc::boxed::Box;
use alloc::vec::Vec;

/// Number of links, or masses, computed together.
pub const BLOCK: usize = 64;
/// One number per link of a block.
pub type Block<R = f64> = [R; BLOCK];

/// Working memory: some blocks of numbers. It is kept because clearing it takes as long as entering a few links.
#[derive(Clone, Debug, PartialEq)]
pub struct LedgerScratch<R: Real = f64> {
    /// elongations before, at and after the tick
    pub(crate) e: [Block<R>; 3],
    /// motion of the ends along the force over the two ticks together
    pub(crate) moved: Block<R>,
    /// stored energy, heat
    pub(crate) out: [Block<R>; 2],
}

impl<R: Real> Default for LedgerScratch<R> {
    fn default() -> LedgerScratch<R> {
        LedgerScratch { e: [[R::ZERO; BLOCK]; 3], moved: [R::ZERO; BLOCK], out: [[R::ZERO; BLOCK]; 2] }
    }
}

/// Largest values so far \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extremes {
    /// largest value of |h|, or of its part in motion, + Σ|lost|: the scale of the residual
    pub peak: f64,
    /// largest h (or kinetic energy) + Σlost less the energy made by the scheme: the most that was given from outside
    pub received: f64,
    /// largest imbalance of a single tick
    pub worst: f64,
    /// largest energy by which contacts in space (`stable`) are outside of the range that their potentials had in a
    /// tick, see [`Balance::strayed`]
    pub strayed: f64,
}

/// Account of the groups at the gesture rate \[J\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupAccount<R: Real = f64> {
    /// energy that a compensated border gave them beyond what it took from the sound side; 0 if it is exact
    pub border: R::Outer,
    /// energy stored and lost in these groups by their own ledger, up to the last frame
    pub slow: Balance<R>,
}

/// The accounts \[J\]. They satisfy `h = h0 + work − lost + scheme_error + changed + residual`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger<R: Real = f64> {
    /// energy at load
    pub h0: R::Outer,
    /// energy now, between the last tick and the one before
    pub h: R::Outer,
    /// part of `h` in motion
    pub kinetic: R::Outer,
    /// largest values so far
    pub extremes: Extremes,
    /// heat of the dampers in MATs and of the ends of waveguides
    pub lost_mats: R::Outer,
    /// heat of each link (n_lia)
    pub lost: Vec<R::Outer>,
    /// energy made (+) or taken (−) by the scheme in each link (n_lia); 0 for linear links
    pub scheme_error: Vec<R::Outer>,
    /// work received from each port: position ports, device ports, force ports
    pub work: Vec<R::Outer>,
    /// work received from a pointer, see [`crate::pointer`]
    pub pointer: R::Outer,
    /// groups at the gesture rate
    pub groups: GroupAccount<R>,
    /// work received from groups at the gesture rate
    pub(crate) crossed: R::Outer,
    /// work of the pointer in the tick that the ledger has not entered yet
    pub(crate) pulled: R::Outer,
    /// energy that crossed each device port (tgr), counted by frames
    pub hands: Vec<Exchange>,
    /// energy added by changing parameters or moving interaction points
    pub changed: R::Outer,
    /// `x` and `d` of the tick that the ledger is at (n_mat)
    pub(crate) x0: Vec<R>,
    pub(crate) d0: Vec<R>,
    /// absolute heat summed over ticks, stored so that no tick sums over all links again
    pub(crate) heat: f64,
    /// heat summed over ticks
    pub(crate) net_heat: f64,
    /// error of the scheme summed over ticks, stored for the same reason
    pub(crate) made: f64,
    /// force on position and device ports, force given by force ports (ports)
    pub(crate) port: Vec<R::Outer>,
    /// energy stored by each link at the last tick of the ledger (n_lia)
    pub(crate) stored: Vec<R::Outer>,
    /// positions and motion of the moving points when the last tick was entered (moving points x 2)
    pub(crate) points: Vec<[R; 2]>,
    /// energy stored by each batch of links at that tick (accounts)
    pub(crate) stored_batches: Vec<R::Outer>,
    /// energy stored by MATs and weight at that tick, with kinetic energy
    pub(crate) stored_mats: R::Outer,
    /// mass of each MAT, as T²C⁻¹; 0 for MATs that forces do not move (n_mat)
    pub(crate) mass: Vec<R::Outer>,
    /// whether the energy at load was entered: a state at load may be played from any tick
    pub(crate) begun: bool,
    /// whether coefficients were moving at that tick
    pub(crate) turning: bool,
    pub(crate) scratch: Box<LedgerScratch<R>>,
    /// force \[N\] of the first tick only, for the start of mi.lib (n_mat, or none)
    pub(crate) start_force: Vec<R>,
}

/// Sets the force \[N\] that acts in the first tick only (n_mat).
pub fn set_kick<R: Real>(ledger: &mut Ledger<R>, kick: Vec<R>) {
    ledger.start_force = kick;
}

/// Energy that crossed the border at one device port, whole frames only \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// energy the scene received: the force of each frame times the motion of the port in it
    pub received: f64,
    /// energy given at the device: the force sent to it, held over the frame, times its own motion
    pub given: f64,
    /// position of the device at the last frame, absolute \[m\]
    pub(crate) hand: f64,
    /// force on the port at the end of the last frame \[N\]
    pub(crate) last: f64,
    /// force held at the device since then \[N\]
    pub(crate) held: f64,
    /// force summed so far \[N\], if no force goes to the device; stored here instead of in
    /// [`Border::sum`](crate::state::Border::sum) because it does not affect the future
    pub(crate) sum: f64,
}

impl Exchange {
    /// Returns the energy that the border made (+) or took (−) by its delay or by sending no force.
    pub fn leak(&self) -> f64 {
        self.received - self.given
    }
}

/// Sums of the ledgers, for display.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance<R: Real = f64> {
    /// energy at load \[J\]
    pub h0: R::Outer,
    /// energy now \[J\]
    pub h: R::Outer,
    /// heat \[J\]
    pub lost: R::Outer,
    /// error of the scheme: energy made by non-linear links and by a compensated border \[J\]
    pub scheme_error: R::Outer,
    /// work received from ports and a pointer \[J\]
    pub work: R::Outer,
    /// energy received by changes \[J\]
    pub changed: R::Outer,
    /// residual: energy that the ledger does not explain \[J\]
    pub residual: R::Outer,
    /// scale of the residual \[J\]
    pub peak: f64,
    /// most energy received, see [`Extremes::received`] \[J\]
    pub received: f64,
    /// largest energy by which contacts in space (`stable`) were off their potential \[J\]. Such a contact stores ψ²/2
    /// with a ψ that follows √(2U) (docs/numerics.md §3.4); in each tick the part of ψ²/2 outside of the range from
    /// U before to U after it counts, summed over contacts. It is 0 without such contacts.
    pub strayed: f64,
}

impl<R: Real> Ledger<R> {
    /// Returns the sums.
    pub fn balance(&self) -> Balance<R> {
        let (lost, scheme_error) =
            (self.lost_mats + self.lost.iter().sum::<R::Outer>(), self.scheme_error.iter().sum::<R::Outer>());
        let work = self.work.iter().sum::<R::Outer>() + self.pointer;
        let residual = self.h - self.h0 - work - self.crossed + lost - scheme_error - self.changed;
        let slow = &self.groups.slow;
        Balance {
            h0: self.h0 + slow.h0,
            h: self.h + slow.h + self.in_transit(),
            lost: lost + slow.lost,
            scheme_error: scheme_error + self.groups.border + slow.scheme_error,
            work,
            changed: self.changed + slow.changed,
            residual: residual + slow.residual,
            peak: self.extremes.peak + slow.peak,
            received: self.extremes.received + slow.received,
            strayed: self.extremes.strayed + slow.strayed,
        }
    }

    /// Returns the energy that one side of the border of groups gave and the other has not entered yet \[J\], a part of
    /// the present energy: when a frame is entered, the work of the links across in half a tick.
    pub fn in_transit(&self) -> R::Outer {
        self.groups.border - (self.crossed + self.groups.slow.work)
    }

    /// Returns the link that made the most energy, with its account, or `None` if none made any.
    pub fn largest_error(&self) -> Option<(usize, f64)> {
        let (i, s) = self.scheme_error.iter().enumerate().max_by(|a, b| a.1.wide().total_cmp(&b.1.wide()))?;
        (s.wide() > 0.0).then_some((i, s.wide()))
    }
}
