//! The kernel of each pass other than links, over any number type.

use crate::border::{self, group};
use crate::method::{implicit, modes, pefrl, together};
use crate::numeric::Real;
use crate::op::{Kernel, Op, Pass, dc_blocker, driven, energy, lowpass, output_links, pass, substep, wave};

impl Pass {
    /// Returns the kernel over `R`. For [`Pass::Links`] it does nothing, since the law of the links has the kernel.
    pub fn kernel<R: Real>(self) -> Kernel<R> {
        match self {
            Pass::Links => |_, _, _| {},
            Pass::Enx => pass::enx,
            Pass::DevicesIn(way, late) => border::position(way, late),
            Pass::Ahead => pass::delay_ports,
            Pass::ModalPorts => pass::sum,
            Pass::Driven => driven::drive,
            Pass::Points => pass::project,
            Pass::Ledger => energy::ledger,
            Pass::Changes => pass::ramp,
            Pass::Aim => pass::aim,
            Pass::LedgerOfChanges => energy::ledger_changes,
            Pass::Enf { counted: true } => pass::enf::<R, true>,
            Pass::Enf { counted: false } => pass::enf::<R, false>,
            Pass::Weight => pass::weight,
            Pass::WavesIn => wave::arrive,
            Pass::PointsBack => pass::distribute_forces,
            Pass::Modes => pass::share,
            Pass::Implicit => implicit::solve,
            Pass::ImplicitPairs => implicit::pairs,
            Pass::ModesAhead => modes::ahead,
            Pass::Contacts { modes: false, sweeps: false } => together::solve::<R, false, false>,
            Pass::Contacts { modes: false, sweeps: true } => together::solve::<R, false, true>,
            Pass::Contacts { modes: true, .. } => together::solve::<R, true, false>,
            Pass::ModesAgain => modes::back,
            Pass::Mute => border::mute,
            Pass::DevicesOut(way) => border::collect(way),
            Pass::LedgerOfBorder(way) => border::ledger(way),
            Pass::LedgerOfForces => energy::store_forces,
            Pass::Group { compensated: true } => group::advance::<R, true>,
            Pass::Group { compensated: false } => group::advance::<R, false>,
            Pass::GroupOut { compensated: true } => group::collect::<R, true>,
            Pass::GroupOut { compensated: false } => group::collect::<R, false>,
            Pass::OutputLinks => output_links::output_links,
            Pass::Outputs => pass::outputs,
            Pass::ManyOutputs => pass::many_outputs,
            Pass::Positions => pass::positions,
            Pass::Motions => pass::motions,
            Pass::HighPass => dc_blocker::blocker,
            Pass::HighPassOfMotion => dc_blocker::of_motion,
            Pass::LowPass => lowpass::lowpass,
            Pass::Remember => lowpass::remember,
            Pass::IntegrateFree => pass::integrate_free,
            Pass::IntegrateFull => pass::integrate_full,
            Pass::WavesOut => wave::depart,
            Pass::Flush => pass::flush,
            Pass::Drift => pefrl::drift,
            Pass::Kick { own: false } => pefrl::kick,
            Pass::Kick { own: true } => pefrl::kick_own,
            Pass::Inputs => substep::inputs,
            Pass::Between => substep::between,
            Pass::ToTicks => substep::to_ticks,
            Pass::ToSamples => substep::to_samples,
        }
    }
}

impl Op {
    /// Makes a pass without links. It is not generic, so that this crate instantiates the kernels over `f64`.
    pub fn pass(pass: Pass, n: usize) -> Op {
        Op::new(pass, pass.kernel(), n)
    }
}
