//! Peers: programs written for this bench that play the networks of a model by other means, and the ratios expected of
//! the engine.
//!
//! `cargo bench -p ca-benches --bench peers` runs them. The page is `docs/measured/peers.md`, or `peers-avx2.md`
//! without AVX-512.
//!
//! Peers are processes that time themselves and are called one after the other (`benches/peers/player.h`), so that no
//! foreign calls are needed and Python can take part. They read the same clock as the engine: the processor time of one
//! thread.

pub mod build;
pub mod net;
pub mod nets;
pub mod page;
pub mod player;
pub mod write;

use net::Net;

/// Expected cost of a network; `None` if nothing is expected.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// Largest time a module \[ns\].
    pub module: Option<f64>,
    /// Least speed relative to Faust, with AVX-512.
    pub faust: Option<f64>,
    /// The same with AVX2 alone, if it differs.
    pub faust_avx2: Option<f64>,
    /// Largest time relative to the damped stencil.
    pub stencil: Option<f64>,
    /// Least speed relative to flat C.
    pub flat: Option<f64>,
}

/// A row of the table.
pub struct Case {
    /// Network.
    pub net: Net,
    /// Shape and size of the stencil with the same topology.
    pub stencil: Option<(&'static str, usize)>,
    /// Expectation.
    pub target: Target,
    /// Ticks of a peer that are compared with the engine; motion in space is chaotic, so that rounding soon becomes
    /// visible.
    pub compared: usize,
    /// Largest difference between a peer and the engine, relative to the largest output. It allows for rounding, its
    /// growth in contacts, and the bow of the engine, a table within 2e-6 of its peak.
    pub tolerance: f64,
}

/// Returns all rows.
pub fn cases() -> Vec<Case> {
    let case = |net: Net, target: Target| Case { net, stencil: None, target, compared: 4096, tolerance: 1e-9 };
    let chaotic = |net: Net, target: Target| Case { compared: 1024, tolerance: 1e-6, ..case(net, target) };
    let string = |n: usize, target: Target| Case { stencil: Some(("string", n)), ..case(nets::string(n), target) };
    let target = |module: f64, faust: f64| Target { module: Some(module), faust: Some(faust), ..Target::default() };
    let space = |module: f64, flat: f64| Target { module: Some(module), flat: Some(flat), ..Target::default() };
    vec![
        string(24, target(0.32, 2.2)),
        string(101, Target { faust_avx2: Some(4.0), ..target(0.17, 5.0) }),
        string(500, Target { faust_avx2: Some(6.0), stencil: Some(0.65), ..target(0.13, 9.0) }),
        Case {
            stencil: Some(("mesh", 20)),
            ..case(nets::mesh(20), Target { faust_avx2: Some(4.5), stencil: Some(1.05), ..target(0.23, 5.4) })
        },
        case(nets::random(500, 1000), target(0.6, 2.0)),
        Case { tolerance: 1e-7, ..case(nets::mixture(), target(0.29, 3.7)) },
        case(nets::cells(64), target(0.8, 1.5)),
        case(nets::piano(), Target::default()),
        chaotic(nets::cloth(20), space(1.2, 2.5)),
        chaotic(nets::random_space(333, 667), space(2.5, 1.4)),
        chaotic(nets::grains(4), Target::default()),
    ]
}
