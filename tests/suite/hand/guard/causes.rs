//! H14: provokes every cause for which forces go off.

use super::{KEY, Rig, cause, is_off, mode, profile};
use ca_haptic::frame::{CAUSES, Cause, ForceFrame, Mode, status};
use ca_haptic::guard::Order;

/// Provokes the cause in an engine with forces on, and returns the frame that reports it.
fn provoke(rig: &mut Rig, why: Cause) -> ForceFrame {
    match why {
        Cause::None => rig.go(&[0.0]),
        Cause::Disarmed => {
            rig.order(Order::Disarm);
            rig.go(&[0.0])
        }
        Cause::Button | Cause::WatchdogOut => {
            rig.next.cause = why as u16;
            let f = rig.go(&[0.0]);
            rig.next.cause = 0;
            f
        }
        Cause::Deadman | Cause::Thermal => {
            let bit = if why == Cause::Deadman { status::DEADMAN } else { status::THERMAL };
            rig.next.status |= bit;
            let f = rig.go(&[0.0]);
            rig.next.status &= !bit;
            f
        }
        Cause::Velocity => {
            let mut x = 0.0;
            (0..1000)
                .map(|_| {
                    x += 1.6 / 3000.0;
                    rig.go(&[x])
                })
                .last()
                .expect("frames")
        }
        Cause::WatchdogIn => (0..30).map(|_| rig.frame()).last().expect("frames"),
        Cause::Nonfinite => {
            rig.engine.state.ports.border[0].sum = f64::INFINITY;
            rig.go(&[0.0])
        }
        Cause::Implausible => {
            let mut last = None;
            for _ in 0..10 {
                rig.next.seq += 1;
                let mut f = rig.next;
                f.pos[0] = f64::INFINITY;
                rig.engine.take(0, &mut f);
                last = Some(rig.frame());
            }
            last.expect("frames")
        }
        Cause::Disconnect => {
            // unplugged and plugged in: the device process is another one
            (rig.next.session, rig.next.seq) = (rig.next.session + 1, 0);
            rig.go(&[0.0])
        }
        Cause::Software => {
            rig.order(Order::Trip(Cause::Software));
            rig.go(&[0.0])
        }
        Cause::ModelUnstable => {
            let m = rig.engine.state.x.len() - 1;
            rig.engine.state.x[m] = 2e3;
            rig.go(&[0.0])
        }
    }
}

/// A key, and a bar that is not connected to it.
fn text() -> String {
    format!("{KEY}\n[CEL]\nbar = {{ m = \"1 g\", f = \"100 Hz\" }}\n")
}

#[test]
fn every_cause_can_happen_is_reported_and_ends_with_arming() {
    for why in CAUSES {
        let mut rig = Rig::new(&text(), profile(|_| {}));
        rig.on(&[0.0]);
        let f = provoke(&mut rig, why);
        assert_eq!(cause(&f), why, "{}", why.name());
        match why {
            Cause::None => assert_eq!(mode(&f), Mode::On),
            Cause::Disarmed => assert_eq!((mode(&f), f.force[0]), (Mode::Off, 0.0)),
            _ => {
                assert!(is_off(&f, why), "{}", why.name());
                assert_eq!(rig.engine.counts.faults, 1, "{}", why.name());
            }
        }
        if why == Cause::None {
            continue;
        }
        // the cause is over; forces stay off
        let x = rig.next.pos[0];
        for _ in 0..300 {
            let f = rig.go(&[x]);
            assert_eq!((cause(&f), f.force[0]), (why, 0.0), "{}", why.name());
        }
        if why == Cause::ModelUnstable {
            // a diverged instrument must be reloaded first
            rig.order(Order::Arm);
            assert!(is_off(&rig.go(&[x]), why));
        } else {
            for i in 0..3000 {
                rig.go(&[x * (1.0 - f64::from(i + 1) / 3000.0)]);
            }
            rig.on(&[0.0]);
        }
    }
}

#[test]
fn a_device_that_loses_its_hardware_or_its_metres_is_off() {
    for (bit, why) in [(status::CONNECTED, Cause::Disconnect), (status::CALIBRATED, Cause::Implausible)] {
        let mut rig = Rig::new(KEY, profile(|_| {}));
        rig.on(&[0.0]);
        rig.next.status &= !bit;
        assert!(is_off(&rig.go(&[0.0]), why));
        rig.next.status |= bit;
        assert!(is_off(&rig.go(&[0.0]), why));
        rig.on(&[0.0]);
    }
}

#[test]
fn the_first_cause_stays() {
    let mut rig = Rig::new(&text(), profile(|_| {}));
    rig.on(&[0.0]);
    provoke(&mut rig, Cause::Button);
    for why in [Cause::Thermal, Cause::Software, Cause::WatchdogIn, Cause::Disconnect] {
        assert_eq!(cause(&provoke(&mut rig, why)), Cause::Button);
    }
}

#[test]
fn what_a_device_missed_before_forces_were_on_is_no_fault() {
    // it heard of an earlier engine, or not yet of this one
    for why in [Cause::WatchdogOut, Cause::Disconnect] {
        let mut rig = Rig::new(KEY, profile(|_| {}));
        rig.order(Order::Arm);
        rig.next.cause = why as u16;
        for _ in 0..100 {
            let f = rig.go(&[0.0]);
            assert_eq!((mode(&f), cause(&f), f.force[0]), (Mode::Off, Cause::None, 0.0));
        }
        rig.next.cause = 0;
        rig.on(&[0.0]);
        rig.next.cause = why as u16;
        assert!(is_off(&rig.go(&[0.0]), why), "{}", why.name());
    }
}
