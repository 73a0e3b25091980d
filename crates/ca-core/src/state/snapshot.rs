//! Snapshots: a state as bytes, to be stored, sent, and continued in another process or on another machine.
//!
//! A snapshot lists all numbers in a fixed order, each as eight bytes, lowest first. The scene determines how many
//! there are, so a snapshot contains no lengths that could be wrong, and the size is checked before anything changes.
//! One function lists the numbers for both writing and reading.
//!
//! Field names would let the format outlive a change of [`State`], but the meaning of its numbers depends on the scene
//! anyway. The head holds the [`Identity`](super::Identity) of the scene.
//!
//! A snapshot omits what is computed anew: lists of near points, contacts of the tick, temporary numbers.

use super::{Balance, Between, Border, Cell, Exchange, Ledger, Ramps, SlowState, State, Unknown};
use crate::state::ledger::{Extremes, GroupAccount};
use crate::state::{LinkState, PortState};
use alloc::vec::Vec;
use core::fmt;
use core::hash::Hasher as _;

const MAGIC: &[u8; 8] = b"ca state";
/// Version of the order of the numbers.
pub const SNAPSHOT_VERSION: u64 = 5;
/// Bytes before the numbers: magic, version, identity of the scene.
const HEAD: usize = 24;
/// Bytes after the numbers: FNV-1a of everything before.
const FOOT: usize = 8;

/// Reason why a state was not restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotRestored {
    /// the bytes are not a snapshot
    NoSnapshot,
    /// the snapshot has this version instead of [`SNAPSHOT_VERSION`]
    Version(u64),
    /// it belongs to another scene: another model, other values, or other compiler options
    OtherScene,
    /// it is truncated, or was changed after writing
    Damaged,
}

impl fmt::Display for NotRestored {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotRestored::NoSnapshot => write!(f, "the bytes are not a snapshot of a state"),
            NotRestored::Version(v) => {
                write!(f, "the snapshot has version {v}, but this program reads version {SNAPSHOT_VERSION}")
            }
            NotRestored::OtherScene => write!(
                f,
                "the snapshot is of another scene: the model, its values, its rate, the probes or the energy ledger \
                 differ"
            ),
            NotRestored::Damaged => write!(f, "the snapshot is cut short or was changed"),
        }
    }
}

impl core::error::Error for NotRestored {}

impl State {
    /// Returns everything that determines the future of this state, between two ticks, as bytes, the same on every
    /// machine.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::from(MAGIC);
        bytes.extend(SNAPSHOT_VERSION.to_le_bytes());
        bytes.extend(self.scene.0.to_le_bytes());
        self.clone().each(&mut Writer(&mut bytes));
        let sum = checksum(&bytes);
        bytes.extend(sum.to_le_bytes());
        bytes
    }

    /// Restores a snapshot of the same scene, which plays on from there with the same bits.
    ///
    /// # Errors
    /// [`NotRestored`]; the state is then unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), NotRestored> {
        let mut restored = self.clone();
        let numbers = self.checked(bytes, &mut restored)?;
        restored.each(&mut Reader(numbers));
        if !restored.is_valid() {
            return Err(NotRestored::Damaged);
        }
        *self = restored;
        Ok(())
    }

    /// Returns the numbers of an intact snapshot of this scene. `like` is a state of its shape.
    fn checked<'b>(&self, bytes: &'b [u8], like: &mut State) -> Result<&'b [u8], NotRestored> {
        let word = |at: usize| bytes.get(at..)?.first_chunk::<8>().map(|w| u64::from_le_bytes(*w));
        if bytes.first_chunk() != Some(MAGIC) {
            return Err(NotRestored::NoSnapshot);
        }
        let version = word(8).ok_or(NotRestored::Damaged)?;
        if version != SNAPSHOT_VERSION {
            return Err(NotRestored::Version(version));
        }
        if word(16).ok_or(NotRestored::Damaged)? != self.scene.0 {
            return Err(NotRestored::OtherScene);
        }
        let mut count = Counter(0);
        like.each(&mut count);
        if bytes.len() != HEAD + 8 * count.0 + FOOT {
            return Err(NotRestored::Damaged);
        }
        let (whole, foot) = bytes.split_at(bytes.len() - FOOT);
        let sum = foot.first_chunk().map(|w| u64::from_le_bytes(*w));
        if sum == Some(checksum(whole)) { Ok(&whole[HEAD..]) } else { Err(NotRestored::Damaged) }
    }

    /// Returns true if every index that a tick looks up is within this state.
    fn is_valid(&self) -> bool {
        let places = self.x.len();
        let cells = self.links.cells.iter().all(|c| c.n <= 4 && c.node.iter().all(|m| (*m as usize) < places.max(1)));
        // centuries, and far below overflow
        let time = self.tick < 1 << 56;
        time && cells && self.ramps.is_valid() && self.slow.as_ref().is_none_or(|slow| slow.state.is_valid())
    }

    /// Visits every number in order. It names each field, so that adding one requires a decision here.
    fn each(&mut self, w: &mut impl Words) {
        let State {
            scene: _,
            x,
            d,
            f,
            coef,
            links: LinkState { mem, lengths, tap, cells, near: _, implicit: _, touches: _ },
            input,
            ports: PortState { last_input, border, late, blocked, glide, under_way, turns, lowpass, refused },
            output,
            slow,
            ramps,
            written: _,
            ledger,
            tick,
        } = self;
        for all in [x, d, f, coef, lengths, tap] {
            w.doubles(all);
        }
        for all in [mem, input, last_input, output, late] {
            w.doubles(all);
        }
        for Cell { n, node, weight } in cells {
            let mut count = *n as u32;
            w.counts(core::slice::from_mut(&mut count));
            *n = count as usize;
            w.counts(node);
            w.doubles(weight);
        }
        for Border { from, to, sum, force } in border {
            w.each_of([from, to, sum, force]);
        }
        w.doubles(blocked.as_flattened_mut());
        w.doubles(glide.as_flattened_mut());
        w.doubles(under_way.as_flattened_mut());
        w.doubles(turns);
        w.doubles(lowpass);
        ramps.each(w);
        w.word(tick);
        w.word(refused);
        if let Some(slow) = slow {
            slow.each(w);
        }
        if let Some(ledger) = ledger {
            ledger.each(w);
        }
    }
}

impl SlowState {
    fn each(&mut self, w: &mut impl Words) {
        let SlowState { state, ports, unknown, free: _ } = self;
        state.each(w);
        for Between { from, to, force } in ports {
            w.each_of([from, to, force]);
        }
        for Unknown { sum, given, expected, last } in unknown {
            w.each_of([sum, given, expected]);
            w.doubles(last);
        }
    }
}

impl Ramps {
    fn each(&mut self, w: &mut impl Words) {
        let Ramps { index: _, left, step, target, active, moving, instant: _ } = self;
        w.counts(left);
        w.doubles(step);
        w.doubles(target);
        w.counts(active);
        let mut count = *moving as u64;
        w.word(&mut count);
        *moving = usize::try_from(count).unwrap_or(usize::MAX);
    }

    /// Returns true if the moving entries are exactly those with ticks left, each listed once.
    fn is_valid(&self) -> bool {
        let Some(active) = self.active.get(..self.moving) else { return false };
        let mut listed: Vec<u32> = active.to_vec();
        listed.sort_unstable();
        listed.dedup();
        let moves = |i: &u32| self.left.get(*i as usize).is_some_and(|left| *left > 0);
        listed.len() == self.moving
            && listed.iter().all(moves)
            && self.left.iter().filter(|left| **left > 0).count() == self.moving
    }
}

impl Ledger {
    fn each(&mut self, w: &mut impl Words) {
        let Ledger {
            h0,
            h,
            kinetic,
            extremes: Extremes { peak, received, worst, strayed },
            lost_mats,
            lost,
            scheme_error,
            work,
            pointer,
            crossed,
            groups: GroupAccount { border, slow },
            pulled,
            hands,
            changed,
            x0,
            d0,
            heat,
            net_heat,
            made,
            port,
            stored,
            points,
            stored_batches,
            stored_mats,
            mass,
            begun,
            turning,
            scratch: _,
            start_force: kick,
        } = self;
        w.each_of([
            h0,
            h,
            kinetic,
            peak,
            received,
            lost_mats,
            pointer,
            crossed,
            border,
            pulled,
            changed,
            worst,
            strayed,
            heat,
            net_heat,
            made,
            stored_mats,
        ]);
        for all in [lost, scheme_error, work, port, stored, stored_batches, mass] {
            w.doubles(all);
        }
        let Balance { h0, h, lost, scheme_error, work, changed, residual, peak, received, strayed } = slow;
        w.each_of([h0, h, lost, scheme_error, work, changed, residual, peak, received, strayed]);
        for Exchange { received, given, hand, last, held, sum } in hands {
            w.each_of([received, given, hand, last, held, sum]);
        }
        w.doubles(x0);
        w.doubles(d0);
        w.doubles(points.as_flattened_mut());
        w.doubles(kick);
        for flag in [begun, turning] {
            let mut word = u64::from(*flag);
            w.word(&mut word);
            *flag = word != 0;
        }
    }
}

/// Visits numbers in sequence, to write, read or count them.
trait Words {
    fn word(&mut self, v: &mut u64);

    fn double(&mut self, v: &mut f64) {
        let mut bits = v.to_bits();
        self.word(&mut bits);
        *v = f64::from_bits(bits);
    }

    fn each_of<const N: usize>(&mut self, all: [&mut f64; N]) {
        for v in all {
            self.double(v);
        }
    }

    fn doubles(&mut self, all: &mut [f64]) {
        for v in all {
            self.double(v);
        }
    }

    fn counts(&mut self, all: &mut [u32]) {
        for v in all {
            let mut word = u64::from(*v);
            self.word(&mut word);
            *v = u32::try_from(word).unwrap_or(u32::MAX);
        }
    }
}

struct Writer<'b>(&'b mut Vec<u8>);
/// Reads the numbers. The length was checked before.
struct Reader<'b>(&'b [u8]);
struct Counter(usize);

impl Words for Writer<'_> {
    fn word(&mut self, v: &mut u64) {
        self.0.extend(v.to_le_bytes());
    }
}

impl Words for Reader<'_> {
    fn word(&mut self, v: &mut u64) {
        if let Some((first, others)) = self.0.split_first_chunk::<8>() {
            *v = u64::from_le_bytes(*first);
            self.0 = others;
        }
    }
}

impl Words for Counter {
    fn word(&mut self, _: &mut u64) {
        self.0 += 1;
    }
}

/// Returns the FNV-1a hash of bytes. It detects truncation and damage, not deliberate forgery.
pub fn checksum(bytes: &[u8]) -> u64 {
    let mut h = fnv::FnvHasher::default();
    h.write(bytes);
    h.finish()
}
