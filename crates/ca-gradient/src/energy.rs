//! Energy accounts of a scene and their derivatives, at chosen instants.
//!
//! This is the ledger of the tick over dual numbers ([`ca_core::Ledger`]), so that the energy a law stores and loses is
//! written once. The identity of the ledger, `h = h0 + work − lost + scheme_error + changed + residual`, holds for each
//! derivative too; the residual is rounding.
//!
//! [`Energy`] is not a method of [`Forward`] because it needs another scene, whose passes compute the ledger and whose
//! numbers are differentiated separately. It returns only sums, at the requested instants, since a value per link and
//! sample would be too much data to read.

use crate::play_io::{Played, diverged, zeros};
use crate::{Error, Forward, GoesOn, Parameter};
use ca_core::{Balance, Dual, TANGENTS};
use ca_io::gesture::Gesture;
use cordis_anima::{Loaded, Options};

/// Accounts in the order of [`EnergyTangents::values`], named as in [`ca_core::Balance`] \[J\]: energy at load, energy
/// now, heat, error of the scheme, work received from ports, energy received by changes, residual.
pub const ACCOUNTS: [&str; 7] = ["h0", "h", "lost", "scheme_error", "work", "changed", "residual"];

/// Scene with the energy ledger and the derivatives of everything it begins with.
///
/// ```
/// use ca_gradient::Energy;
/// use cordis_anima::{Loaded, Options};
///
/// let text = "[CEL]\nbar = { m = '2 g', f = '440 Hz', t60 = '2 s', dx0 = '1 mm' }\n[SOX]\nout = { from = 'bar' }\n";
/// let energy = Energy::new(&Loaded::read(text, "bar.ca.toml"), &Options::default(), &["bar.dx0", "bar.t60"]).unwrap();
/// let t = energy.tangents(Some(0.1), None, 4, &mut || true).unwrap();
/// assert_eq!(t.instants(), 4);
/// // energy goes with the square of where it begins
/// let (stored, by) = t.account("h", 3).unwrap();
/// assert!((by[0] * 1e-3 / (2.0 * stored) - 1.0).abs() < 1e-9);
/// // what rings longer has lost less
/// let (_, by) = t.account("lost", 3).unwrap();
/// assert!(by[1] < 0.0);
/// ```
pub struct Energy {
    forward: Forward,
}

/// Energy accounts at some instants and their derivatives. All arrays are row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyTangents {
    /// Time covered by the ledger at each instant \[s\] (instants). It is one tick less than was played, since a tick
    /// is entered when the next one begins.
    pub seconds: Vec<f64>,
    /// Parameters differentiated by.
    pub parameters: Vec<Parameter>,
    /// Accounts \[J\] (instants x [`ACCOUNTS`]): the same bits as a render with the ledger if its links have the same
    /// order, otherwise within 1e-13 of all energy.
    pub values: Vec<f64>,
    /// Derivatives of the accounts \[J\] per unit of the parameter (instants x [`ACCOUNTS`] x parameters).
    pub tangents: Vec<f64>,
}

impl EnergyTangents {
    /// Number of instants.
    pub fn instants(&self) -> usize {
        self.seconds.len()
    }

    /// Returns an account of [`ACCOUNTS`] at an instant \[J\] with its derivatives \[J\] per unit of each parameter, or
    /// `None` without such an account or instant.
    pub fn account(&self, name: &str, instant: usize) -> Option<(f64, &[f64])> {
        let at = instant * ACCOUNTS.len() + ACCOUNTS.iter().position(|a| *a == name)?;
        let n = self.parameters.len();
        Some((*self.values.get(at)?, self.tangents.get(at * n..(at + 1) * n)?))
    }
}

impl Energy {
    /// Compiles a model with these options and the energy ledger, to be differentiated as by [`Forward::new`].
    ///
    /// # Errors
    /// As [`Forward::new`]; [`Error::Refused`] also where the ledger does not support the scene (`pefrl`).
    pub fn new(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Energy, Error> {
        Ok(Energy { forward: Forward::with_ledger(loaded, options, wrt)? })
    }

    /// The sound rate \[Hz\].
    pub fn rate(&self) -> f64 {
        self.forward.rate()
    }

    /// Parameters differentiated by.
    pub fn parameters(&self) -> &[Parameter] {
        self.forward.parameters()
    }

    /// Plays `seconds`, or as long as a render of the model, and returns the accounts at `instants` evenly spaced
    /// instants. The last instant is the end; 1 means only the end.
    ///
    /// # Errors
    /// As [`Forward::tangents`]; [`Error::Refused`] also where `instants` is 0 or greater than the number of samples.
    pub fn tangents(
        &self,
        seconds: Option<f64>,
        gesture: Option<&Gesture>,
        instants: usize,
        goes_on: GoesOn,
    ) -> Result<EnergyTangents, Error> {
        let forward = &self.forward;
        let played = Played::new(&forward.plain, seconds, gesture, goes_on)?;
        let (frames, n) = (played.frames, forward.parameters().len());
        if instants == 0 || instants > frames {
            return Err(Error::refused(format!("{instants} instants for {frames} samples: use 1 to {frames}")));
        }
        let mut to = EnergyTangents {
            seconds: zeros(instants, 1, 1)?,
            parameters: forward.parameters().to_vec(),
            values: zeros(instants, ACCOUNTS.len(), 1)?,
            tangents: zeros(instants, ACCOUNTS.len(), n)?,
        };
        for first in (0..n.max(1)).step_by(TANGENTS) {
            let (some, mut k) = (first..n.min(first + TANGENTS), 0);
            forward.play(
                &played,
                some.clone(),
                &mut |frame, s| {
                    let Some(ledger) = s.ledger.as_deref().filter(|_| frame + 1 == after(k, instants, frames)) else {
                        return;
                    };
                    to.seconds[k] = s.tick.saturating_sub(1) as f64 * forward.sample_dt();
                    for (j, v) in accounts(&ledger.balance()).iter().enumerate() {
                        let at = k * ACCOUNTS.len() + j;
                        to.values[at] = v.value();
                        to.tangents[at * n..][some.clone()].copy_from_slice(&v.tangents()[..some.len()]);
                    }
                    k += 1;
                },
                goes_on,
            )?;
        }
        if to.values.iter().all(|v| v.is_finite()) { Ok(to) } else { Err(diverged()) }
    }
}

/// Number of samples played by instant `k`.
fn after(k: usize, instants: usize, frames: usize) -> usize {
    // u128, since the product may exceed 64 bits
    ((k as u128 + 1) * frames as u128 / instants as u128) as usize
}

fn accounts(b: &Balance<Dual>) -> [Dual; ACCOUNTS.len()] {
    // exhaustive, so that a new account has to be considered here
    let Balance { h0, h, lost, scheme_error, work, changed, residual, peak: _, received: _, strayed: _ } = *b;
    [h0, h, lost, scheme_error, work, changed, residual]
}
