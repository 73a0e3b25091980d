//! A plectrum (PLK): one note per passage.

use crate::play::scene;
use ca_core::tick;

#[test]
fn a_plectrum_lets_go_once_per_passage() {
    for seconds in [0.02, 0.3, 2.0] {
        let text = "[CEL]\nreed = { m = \"1 g\", f = \"220 Hz\", t60 = \"0.05 s\" }\n[ENX]\nplectrum = { x = \"-3 mm\" }\n\
             [PLK]\npluck = { between = [\"reed\", \"plectrum\"], k = \"2 kN/m\", z = \"0.05 N s/m\", d = \"1 mm\" }\n\
             [SOX]\nout = { from = \"reed\", gain = 500 }\n";
        let scene = scene(text);
        let mut s = scene.state();
        let (mut releases, mut takes) = (0, 0);
        let passage = (seconds * scene.rate) as u64;
        for n in 0..4 * passage {
            let u = (n % passage) as f64 / passage as f64;
            let up = (n / passage).is_multiple_of(2);
            s.input[0] = 6e-3 * (u - 0.5) * if up { 1.0 } else { -1.0 };
            let (held, last) = (s.mem[0], s.mem[1]);
            tick(&scene, &mut s);
            releases += u32::from(held == 1.0 && s.mem[0] == 0.0);
            if held == 0.0 && s.mem[0] == 1.0 {
                takes += 1;
                assert!(last * s.mem[1] <= 0.0, "it takes hold where it passes the reed, not before");
            }
        }
        assert_eq!((takes, releases), (4, 4), "4 passages of {seconds} s");
    }
}
