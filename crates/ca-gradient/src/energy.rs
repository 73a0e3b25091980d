//! Energy: the accounts of energy of a scene, with their derivatives, at some instants.
//!
//! This is the ledger of the tick itself over dual numbers ([`ca_core::Ledger`], whose accounts carry derivatives in
//! that build): what a law stores and loses is written once, for the ledger of a render and for this. The identity of the ledger
//! holds for each derivative as for the accounts, `h = h0 + work − lost + scheme_error + changed + residual`, with a residual
//! that is rounding. A type beside [`Forward`], not a call of it: the scene is another one, whose passes keep the ledger, so that
//! its numbers are differenced for themselves, and who asks for sound alone pays nothing. Only sums are given, at as many
//! instants as are asked for: a number of each link in each sample would be more than anybody reads.

use crate::played::{Played, diverged, zeros};
use crate::{Error, Forward, GoesOn, Parameter};
use ca_core::{Balance, Dual, TANGENTS};
use ca_io::gesture::Gesture;
use cordis_anima::{Loaded, Options};

/// The accounts, in the order of [`EnergyTangents::values`], by their names in [`ca_core::Balance`]: energy at load, energy
/// now, heat, error of the scheme, work received from ports, received by changes, and what these do not explain \[J\].
pub const ACCOUNTS: [&str; 7] = ["h0", "h", "lost", "scheme_error", "work", "changed", "residual"];

/// A scene that keeps the energy ledger, with the derivatives of all that it begins with.
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

/// Accounts of energy at some instants, and their derivatives. All arrays row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyTangents {
    /// how much time the ledger covers at each instant \[s\] (instants): one tick less than was played, since a tick is entered
    /// when the next one begins
    pub seconds: Vec<f64>,
    /// by which parameters
    pub parameters: Vec<Parameter>,
    /// the accounts \[J\] (instants x [`ACCOUNTS`]): those of a render that keeps the ledger, to the bit where its links lie in the
    /// same order, and to 1e-13 of all energy else
    pub values: Vec<f64>,
    /// their derivatives \[J\] per unit of the parameter (instants x [`ACCOUNTS`] x parameters)
    pub tangents: Vec<f64>,
}

impl EnergyTangents {
    /// How many instants there are.
    pub fn instants(&self) -> usize {
        self.seconds.len()
    }

    /// An account of [`ACCOUNTS`] at an instant \[J\], with its derivatives \[J\] per unit of each parameter; nothing where there is
    /// no such account or instant.
    pub fn account(&self, name: &str, instant: usize) -> Option<(f64, &[f64])> {
        let at = instant * ACCOUNTS.len() + ACCOUNTS.iter().position(|a| *a == name)?;
        let n = self.parameters.len();
        Some((*self.values.get(at)?, self.tangents.get(at * n..(at + 1) * n)?))
    }
}

impl Energy {
    /// A model, compiled with these options and with the energy ledger, and by which parameters is differentiated: names as
    /// [`Forward::new`] takes them.
    ///
    /// # Errors
    /// As [`Forward::new`]; [`Error::Refused`] also where no ledger is kept of the scene (`pefrl`).
    pub fn new(loaded: &Loaded, options: &Options, wrt: &[&str]) -> Result<Energy, Error> {
        Ok(Energy { forward: Forward::with_ledger(loaded, options, wrt)? })
    }

    /// The sound rate \[Hz\].
    pub fn rate(&self) -> f64 {
        self.forward.rate()
    }

    /// By what is differentiated.
    pub fn parameters(&self) -> &[Parameter] {
        self.forward.parameters()
    }

    /// Plays so many seconds, or as many as a render of the model has, and gives the accounts at so many `instants`, evenly
    /// spaced, of which the last is the end: 1 is the end alone.
    ///
    /// # Errors
    /// As [`Forward::tangents`]; [`Error::Refused`] also where there is no instant, or are more of them than samples.
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
            return Err(Error::refused(format!(
                "{instants} instants of {frames} samples: from 1 to as many as samples"
            )));
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

/// How many samples have been played at instant `k` of several.
fn after(k: usize, instants: usize, frames: usize) -> usize {
    // in wide numbers, since both may be large
    ((k as u128 + 1) * frames as u128 / instants as u128) as usize
}

/// In the order of [`ACCOUNTS`].
fn accounts(b: &Balance<Dual>) -> [Dual; ACCOUNTS.len()] {
    // who adds an account is asked here what to do with it
    let Balance { h0, h, lost, scheme_error, work, changed, residual, peak: _, received: _ } = *b;
    [h0, h, lost, scheme_error, work, changed, residual]
}
