//! Peers: programs of ours that play the networks of a model by other means, and what is expected of the engine beside
//! them. `cargo bench -p ca-benches --bench peers` runs them; the page is `docs/measured/peers.md`, or
//! `peers-avx2.md` where there is no AVX-512.
//!
//! Decides for peers as processes that time themselves and are asked in turn (`benches/peers/player.h`): no foreign call,
//! and Python takes part. They read the same clock as the engine here, the processor time of one thread.

pub mod build;
pub mod net;
pub mod nets;
pub mod page;
pub mod player;
pub mod write;

use net::Net;

/// What a network is expected to cost; `None` where nothing is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// at most so many ns a module
    pub module: Option<f64>,
    /// at least so many times as fast as Faust with AVX-512
    pub faust: Option<f64>,
    /// the same with AVX2 alone, where that is another
    pub faust_avx2: Option<f64>,
    /// at most so much of the time of the damped stencil
    pub stencil: Option<f64>,
    /// at least so many times as fast as flat C
    pub flat: Option<f64>,
}

/// A row of the table.
pub struct Case {
    /// the network
    pub net: Net,
    /// of the stencils of its topology: the shape and the size
    pub stencil: Option<(&'static str, usize)>,
    /// what is expected
    pub target: Target,
    /// ticks of a peer that are compared with the engine: motion in space is chaotic, and rounding is seen after a while
    pub compared: usize,
    /// how far a peer may be from the engine, of the largest value heard: rounding, and what contacts make of it; the bow
    /// of the engine is a table within 2e-6 of its peak
    pub tolerance: f64,
}

/// All rows.
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
