//! The peers of `docs/measured/peers.md` play what the engine plays, tested with two networks in flat C, which needs no
//! Faust; and the page is the one of the bench. Times depend on the machine and are left to `benches/peers.rs`.
#![cfg(target_os = "linux")]

use crate::play::within;
use ca_benches::peers::build::{Builder, Without};
use ca_benches::peers::page::{HEAD, PEERS, Row, SHORT};
use ca_benches::peers::player::{BLOCK, Engine, Peer, Player, apart};
use ca_benches::peers::{Case, cases, write};

/// Two machines with AVX-512, and one without.
const PAGES: [&str; 3] = [
    include_str!("../../../docs/measured/peers.md"),
    include_str!("../../../docs/measured/peers-xeon.md"),
    include_str!("../../../docs/measured/peers-avx2.md"),
];

#[test]
fn flat_c_plays_what_the_engine_plays() {
    let dir = tempfile::tempdir().unwrap();
    let builder = Builder::new(dir.path().into(), 120).unwrap();
    let flat = builder.peer("flat.c", "cc").unwrap_or_else(|why| panic!("no C compiler: {why:?}"));
    // all laws on a line, and contacts in space
    for name in ["mixture", "64 grains, 3-D"] {
        let all = cases();
        let case = all.iter().find(|c| c.net.name == name).expect(name);
        let mut engine = Engine::new(&case.net);
        let heard = engine.play(case.compared).unwrap();
        let peer = |net| {
            let mut peer = Peer::start(&[&flat], &builder.table(net).unwrap()).unwrap();
            assert!(peer.time(BLOCK).unwrap() > 0.0);
            peer.play(case.compared).unwrap().into_iter().map(|x| x - case.net.rest()).collect::<Vec<_>>()
        };
        let started = engine.started(&case.net);
        within(name, apart(&heard, &peer(&started)), case.tolerance);
        // a network with one mass different by a thousandth is detected
        let mut other = started.clone();
        other.mats[case.net.outputs[0]].m *= 1.001;
        assert!(apart(&heard, &peer(&other)) > case.tolerance, "{name}: nobody would see it");
    }
}

#[test]
fn what_is_not_a_number_is_not_near() {
    assert_eq!(apart(&[1.0, -2.0], &[1.0, -2.5]), 0.25);
    assert!(apart(&[1.0, 2.0], &[f64::NAN, 2.0]).is_nan() && apart(&[1.0, 2.0], &[1.0, f64::NAN]).is_nan());
}

#[test]
fn a_compiler_that_is_not_here_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let builder = Builder::new(dir.path().into(), 1).unwrap();
    assert_eq!(builder.peer("flat.c", "no-such-compiler"), Err(Without::Missing("no-such-compiler".into())));
}

/// The Faust program has every module once; there is none for space.
#[test]
fn faust_has_every_module() {
    for Case { net, .. } in cases() {
        let Some(program) = write::faust(&net) else {
            assert!(net.space, "{}", net.name);
            continue;
        };
        let ours = program.matches("hertz(").count().saturating_sub(1);
        assert_eq!(program.matches("mi.").count() - 1 + ours, net.modules(), "{}", net.name);
    }
}

#[test]
fn the_pages_have_the_rows_the_bench_makes() {
    assert_eq!(PAGES.map(|page| page.contains("avx512f")), [true, true, false]);
    PAGES.into_iter().for_each(has_the_rows);
}

fn has_the_rows(page: &str) {
    let made = page.starts_with(HEAD) && page.ends_with(SHORT);
    assert!(made, "`UPDATE=1 cargo bench -p ca-benches --bench peers` makes it anew");
    let lines = page.lines().filter(|l| l.starts_with("| ") && !l.starts_with("| network |"));
    let rows: Vec<Vec<&str>> = lines.map(|l| l.trim_matches('|').split('|').map(str::trim).collect()).collect();
    let all = cases();
    let (times, ratios) = rows.split_at(all.len());
    assert_eq!(ratios.len(), all.len());
    for ((case, times), ratios) in all.iter().zip(times).zip(ratios) {
        assert_eq!([times[0], ratios[0]], [case.net.name.as_str(); 2]);
        assert_eq!((times[1].parse(), times.len()), (Ok(case.net.modules()), 3 + PEERS.len()));
        // claims about a target follow from the times on the same page
        let mut row = Row::new(case);
        let time = |cell: &str| cell.parse::<f64>().ok().map(Ok);
        row.engine = times[2].parse().unwrap();
        for (peer, cell) in row.peers.iter_mut().zip(&times[3..]) {
            *peer = time(cell);
        }
        for (claim, cell) in row.claims(page.contains("avx512f")).iter().zip(&ratios[1..]) {
            let Some(claim) = claim else {
                assert_eq!(*cell, "–", "{}", case.net.name);
                continue;
            };
            let is: f64 = cell.split(' ').next().and_then(|n| n.parse().ok()).expect("a figure");
            assert!((is / claim.is - 1.0).abs() < 0.06, "{}: {is} is not {}", case.net.name, claim.is);
            assert_eq!(cell.contains('('), claim.target.is_some(), "{}: {cell}", case.net.name);
        }
    }
}
