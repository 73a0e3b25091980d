//! Energy of the rattle over the stiffness of its contacts, explicit and stable, with run times.
//!
//! Prints the table; with `UPDATE=1` writes it to `docs/measured/rattle-energy.md`. The energies are the same on every
//! machine and checked by a test; the times depend on the machine of the page.
#![allow(missing_docs)]

use ca_benches::publish;
use ca_benches::rattle::{costs, fares, page};

const STIFFNESSES: [f64; 11] = [1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 2.5, 10.0, 100.0, 1e4, 1e6];
const SEEDS: [u64; 3] = [1, 2, 3];

fn main() {
    // `cargo test --benches` only checks that it runs
    let long = std::env::args().any(|a| a == "--bench");
    let (rows, seconds) = if long { (&STIFFNESSES[..], 10.0) } else { (&STIFFNESSES[..1], 0.01) };
    let row = |a: &f64| {
        let runs = |method: &str| SEEDS.map(|seed| fares(*a, method, seed, seconds));
        let cost = |method: &str| costs(*a, method, SEEDS[0], 0.2 * seconds);
        // a run that diverged is not timed
        let explicit = runs("ca");
        let first = explicit[0].worst.is_finite().then(|| cost("ca"));
        page::row(*a, &explicit, first, &runs("stable3d"), cost("stable3d"))
    };
    let table: String = rows.iter().map(row).collect();
    let text = page::page(&table);
    publish("rattle-energy", &text, long);
}
