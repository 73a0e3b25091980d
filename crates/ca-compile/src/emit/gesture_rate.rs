//! Slow: the groups at the gesture rate in the layout of the sound, and the response of the sound within a frame.
//!
//! The response is measured by running the passes of the scene, with a displacement of one metre at each position. It
//! is not derived from the numbers of the modules again, so that the border always agrees with the tick.

use crate::emit::layout_builder::LayoutBuilder;
use crate::net::{End, MatRole, OutputTap, Pruned};
use crate::passes::gesture_rate::SlowPart;
use alloc::collections::BTreeSet;
use alloc::vec::Vec;
use ca_core::internal::border;
use ca_core::internal::op::layout::{Copied, Layout, Response, SlowGroup};
use ca_core::internal::op::{MeasureKind, Op, Pass};
use ca_core::internal::state::SlowState;
use ca_core::{Scene, State};

/// The groups, compiled at their rate.
pub struct Slow<'a> {
    /// Their modules.
    pub part: &'a SlowPart,
    /// Their scene.
    pub scene: Scene,
    /// Slot of each MAT in this scene, by document number; `u32::MAX` if it is not there.
    pub place: Vec<u32>,
}

impl<'a> Slow<'a> {
    /// Combines the network of the groups with the scene compiled from it.
    pub fn new(net: &Pruned, part: &'a SlowPart, mut scene: Scene) -> Slow<'a> {
        let mut place = alloc::vec![u32::MAX; net.mats.len()];
        let alive = (0..net.mats.len()).filter(|m| net.alive[*m]);
        for (m, at) in alive.zip(scene.symbols.places()) {
            place[m] = *at;
        }
        // Positions of its scheme are half a frame later, so that the border begins at the written positions.
        for (m, at) in net.mats.iter().zip(&place).filter(|(m, at)| **at != u32::MAX && !m.is_fixed()) {
            for k in 0..m.axes as usize {
                let moved = m.v[k] * net.tick_dt;
                scene.initial.x[*at as usize + k] = m.dx0[k] + 0.5 * moved;
                scene.initial.d[*at as usize + k] = moved;
            }
        }
        Slow { part, scene, place }
    }

    /// Returns the groups for the layout of the sound, still without the response of the sound.
    pub fn group(&self, builder: &LayoutBuilder) -> SlowGroup {
        let net = builder.net;
        let copied = |m: u32, k: u8| {
            let at = builder.slot[m as usize];
            (at != u32::MAX).then(|| Copied { own: self.place[m as usize] + u32::from(k), at: at + u32::from(k) })
        };
        let mut ports: Vec<Copied> = self.part.coupled.iter().filter_map(|(m, k)| copied(*m, *k)).collect();
        let coupled = ports.len();
        let read: BTreeSet<u32> = net
            .outs
            .iter()
            .filter_map(|o| if let OutputTap::Position(End::Mat(m)) = o.tap { Some(m) } else { None })
            .filter(|m| self.part.slow[*m as usize])
            .collect();
        let mut shown = Vec::new();
        for (m, mat) in (0..).zip(&net.mats).filter(|(_, mat)| matches!(mat.role, MatRole::Slow)) {
            for place in (0..mat.axes).filter_map(|k| copied(m, k)) {
                if ports[..coupled].contains(&place) {
                    continue;
                }
                if read.contains(&m) { ports.push(place) } else { shown.push(place) }
            }
        }
        let (after, forces): (Vec<Op>, Vec<Op>) =
            self.scene.passes.forces.iter().partition(|op| op.name() == "ledger of forces");
        SlowGroup {
            layout: self.scene.layout.clone(),
            reads: self.scene.passes.reads.clone(),
            forces: forces.into_iter().filter(|op| op.name() != "ENF").collect(),
            after,
            moves: self.scene.passes.moves.clone(),
            ports,
            coupled,
            compensated: self.part.compensated,
            shown,
            links: self.scene.lias(),
            masses: self.part.slow.iter().zip(&net.alive).filter(|(slow, alive)| **slow && **alive).count(),
            response: Response::default(),
        }
    }

    /// Returns the state of the groups at load.
    pub fn state(&self, group: &SlowGroup) -> SlowState {
        let mut slow = SlowState::new(self.scene.initial.clone(), group.ports.len(), group.coupled, group.compensated);
        border::group::placed(group, &mut slow);
        slow
    }

    /// Returns the slots of the sound that respond within a frame, and whether each is moved from outside.
    pub fn reach(&self, builder: &LayoutBuilder) -> Vec<(u32, bool)> {
        let net = builder.net;
        let of = |m: &u32| {
            let (mat, at) = (&net.mats[*m as usize], builder.slot[*m as usize]);
            let axes = if at == u32::MAX { 0 } else { mat.axes };
            let held = matches!(mat.role, MatRole::Port(..));
            (0..axes).map(move |k| (at + u32::from(k), held))
        };
        self.part.reach.iter().flat_map(of).collect()
    }
}

/// Inserts the passes of the border.
pub fn passes(group: &SlowGroup, reads: &mut Vec<Op>, forces: &mut Vec<Op>) {
    let ports = reads.iter().take_while(|op| matches!(op.name(), "ENX" | "TGR in")).count();
    let compensated = group.compensated;
    reads.insert(ports, Op::pass(Pass::Group { compensated }, group.ports.len()));
    if group.coupled > 0 {
        let kept = forces.iter().filter(|op| op.name() == "ledger of forces").count();
        forces.insert(forces.len() - kept, Op::pass(Pass::GroupOut { compensated }, group.coupled));
    }
}

/// One tick of the sound, for the frames measured at load.
pub struct Tick {
    /// Passes that sum forces.
    pub forces: Vec<Op>,
    /// Integration.
    pub moves: Vec<Op>,
}

impl Tick {
    /// Returns the linear part of a tick, from passes before rows are fused. A metre of displacement tells nothing
    /// about contacts.
    pub fn proportional(forces: &[Op], moves: Vec<Op>) -> Tick {
        let radial = |op: &Op| [Some(op.form.measure), op.form.onto].contains(&Some(MeasureKind::Radial));
        let is = |op: &&Op| {
            op.law.is_none_or(|l| l.linear && l.mem == 0 && l.stage.is_explicit() && !op.form.set && !radial(op))
        };
        Tick { forces: forces.iter().filter(is).copied().collect(), moves }
    }
}

/// Measures the response of the sound within a frame; `blank` is the state at load without any displacement.
pub fn response(layout: &Layout, group: &SlowGroup, tick: &Tick, blank: &State, reach: &[(u32, bool)]) -> Response {
    let coupled = &group.ports[..group.coupled];
    let n = coupled.len();
    let frame = layout.rates.frame;
    // Mean forces of one frame that starts from `s`, in which port `moving` moves by a metre.
    let frame_of = |mut s: State, moving: Option<usize>| -> Vec<f64> {
        let mut mean = alloc::vec![0.0; n];
        let still: Vec<f64> = coupled.iter().map(|p| s.x[p.at as usize]).collect();
        let step = 1.0 / f64::from(frame);
        for j in 1..=frame {
            for (k, p) in coupled.iter().enumerate() {
                let by = if moving == Some(k) { step } else { 0.0 };
                s.x[p.at as usize] = still[k] + f64::from(j) * by;
                s.d[p.at as usize] = by;
                s.f[p.at as usize] = 0.0;
            }
            for (at, _) in reach.iter().filter(|(_, held)| *held) {
                let at = *at as usize;
                s.f[at] = 0.0;
                if j > 1 {
                    s.x[at] += s.d[at];
                }
            }
            s.tick += 1;
            tick.forces.iter().for_each(|op| (op.kernel)(op, layout, &mut s));
            let weight = if j == frame { 0.5 * step } else { step };
            for (mean, p) in mean.iter_mut().zip(coupled) {
                *mean += weight * s.f[p.at as usize];
            }
            tick.moves.iter().for_each(|op| (op.kernel)(op, layout, &mut s));
        }
        mean
    };
    let ports = coupled.iter().map(|p| (p.at, false));
    let places: Vec<u32> = reach.iter().map(|r| r.0).chain(ports.map(|p| p.0)).collect();
    let width = 1 + 2 * places.len();
    let always = frame_of(blank.clone(), None);
    let mut known = alloc::vec![0.0; n * width];
    for (i, mean) in always.iter().enumerate() {
        known[i * width] = *mean;
    }
    for (k, at) in places.iter().enumerate() {
        // The motion of a port is the unknown of the response.
        let motion = k < reach.len();
        for (column, moved) in [(1 + 2 * k, false), (2 + 2 * k, true)].into_iter().take(1 + usize::from(motion)) {
            let mut s = blank.clone();
            let of = if moved { &mut s.d } else { &mut s.x };
            of[*at as usize] = 1.0;
            for (i, (mean, always)) in frame_of(s, None).iter().zip(&always).enumerate() {
                known[i * width + column] = mean - always;
            }
        }
    }
    let mut by_motion = alloc::vec![0.0; n * n];
    for k in 0..n {
        for (i, (mean, always)) in frame_of(blank.clone(), Some(k)).iter().zip(&always).enumerate() {
            by_motion[i * n + k] = mean - always;
        }
    }
    // T²/m.
    let mobility =
        |p: &Copied| blank.slow.as_ref().map_or(0.0, |s| s.state.coef[2 * group.layout.counts.n_mat + p.own as usize]);
    let mobility: Vec<f64> = coupled.iter().map(mobility).collect();
    Response { places, known, answer: solved(&by_motion, &mobility, n) }
}

/// Returns Y (1 − ½ C Y)⁻¹, the force as a function of the motion without it. Uses elimination with the largest pivot,
/// which exists because the matrix is 1 plus a resistance.
fn solved(y: &[f64], c: &[f64], n: usize) -> Vec<f64> {
    // Transposed, the unknown is a matrix of columns: (1 − ½ C Y)ᵀ Hᵀ = Yᵀ.
    let mut a: Vec<f64> = (0..n * n)
        .map(|at| {
            let (row, column) = (at / n, at % n);
            f64::from(u8::from(row == column)) - 0.5 * c[column] * y[column * n + row]
        })
        .collect();
    let mut h: Vec<f64> = (0..n * n).map(|at| y[at % n * n + at / n]).collect();
    for k in 0..n {
        let pivot = (k..n).max_by(|i, j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs())).unwrap_or(k);
        for column in 0..n {
            a.swap(k * n + column, pivot * n + column);
            h.swap(k * n + column, pivot * n + column);
        }
        for row in (0..n).filter(|row| *row != k) {
            let by = a[row * n + k] / a[k * n + k];
            for column in 0..n {
                a[row * n + column] -= by * a[k * n + column];
                h[row * n + column] -= by * h[k * n + column];
            }
        }
    }
    (0..n * n).map(|at| h[at % n * n + at / n] / a[at % n * n + at % n]).collect()
}

/// Returns a state without any displacement.
pub fn blank(loaded: &State, slow: SlowState) -> State {
    let mut s = loaded.clone();
    s.ledger = None;
    s.slow = Some(alloc::boxed::Box::new(slow));
    s.x.fill(0.0);
    s.d.fill(0.0);
    s
}
