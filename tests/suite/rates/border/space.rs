//! A hand in a plane: each axis crosses the rate boundary separately, with everything that a key on a line has.

use super::hand;
use crate::play::{audited, case, num, within};
use ca_core::internal::border::{delays, frame_due};
use ca_core::tick;

const BOWL: &str = r#"
[plane]
dim = 2
[plane.TGR]
hand = { dof = [0, 1] }
[plane.SOL]
bowl = {}
[plane.MAS]
ball = { m = "5 g", x = ["20 mm", "10 mm"] }
[plane.REF]
tie = { between = ["plane.hand", "plane.ball"], k = "2 kN/m", z = "0.05 N s/m" }
rim = { between = ["plane.bowl", "plane.ball"], k = "500 N/m" }
[plane.SOX]
out = { from = "plane.ball", along = [1, 0], dc = "7 Hz" }
"#;

#[test]
fn e01_in_a_plane() {
    for rate in ["", "border = \"hold\"", "latency = 3", "feedback = false"] {
        let scene = audited(&format!("[rate]\n{rate}\n{BOWL}"));
        assert_eq!(scene.ports.tgr.len(), 2);
        assert_eq!(scene.state().ports.late.len(), 2 * scene.ports.crossing.latency as usize);
        let x = hand(900, 3000.0);
        let mut s = scene.state();
        let mut frame = 0;
        loop {
            if frame_due(&scene, s.tick) {
                if frame == x.len() + 5 {
                    break;
                }
                let at = |n: usize| x[n.min(x.len() - 1)];
                // the axes move differently; both are at rest at the end so that the last frame is complete
                s.input.copy_from_slice(&[at(frame), 0.5 * at(2 * frame)]);
                frame += 1;
            }
            tick(&scene, &mut s);
        }
        let ledger = s.ledger.as_ref().expect("a ledger");
        let b = ledger.balance();
        within(&format!("in a plane, {rate}, residual"), b.residual.abs() / b.peak, 1e-12);
        for (hand, work) in ledger.hands.iter().zip(&ledger.work) {
            assert!(work.abs() > 1e-6);
            within(
                &format!("in a plane, {rate}"),
                (hand.received - work).abs() / b.peak,
                num(case("E01"), "tolerance/rel"),
            );
            assert_eq!(hand.given == 0.0, rate.contains("false"));
        }
        // stiffness along the tie, whatever its direction
        let key = &scene.certificate.keys[0];
        assert_eq!((key.name.as_str(), key.k), ("plane.hand", 2000.0));
        assert!(delays(&scene).friction(key.k) > 0.6);
        assert_eq!(scene.out.blockers.len(), 1);
    }
}
