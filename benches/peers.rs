//! The engine and peers that play the same networks: Faust, flat C, boxed C++, numba, stencils by hand.
//!
//! `cargo bench -p ca-benches --bench peers -- [--only NAME] [--rounds N] [--limit SECONDS] [--json]` makes the
//! networks, compiles the peers into `target/peers`, fails if one plays something else, and then times all of them in
//! turn. It prints the page, or JSON. With `UPDATE=1` and all networks it writes the page to `docs/measured/peers.md`,
//! or to `peers-avx2.md` without AVX-512. A page of another machine (`peers-xeon.md`) was moved by hand. A missed
//! target is reported but is not a failure, because times depend on the machine.
#![allow(missing_docs)]

use ca_benches::peers::build::{Builder, Without, folder, numba, version};
use ca_benches::peers::net::Net;
use ca_benches::peers::page::{PEERS, Row, page};
use ca_benches::peers::player::{BLOCK, Engine, Peer, Player, apart};
use ca_benches::peers::{Case, cases, nets};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Number of starts of all players of a network, including the engine. The place of a process in memory makes up to a
/// fifth of its time, and more rounds in the same process do not show this.
const STARTS: usize = 6;
/// Approximate length of a round of a player \[ns\]: shorter than a slice of the scheduler, longer than the error of
/// its clock.
const ROUND: f64 = 3e5;

struct BenchOptions {
    only: Option<String>,
    rounds: usize,
    limit: u32,
    json: bool,
}

fn bench_options() -> Result<BenchOptions, String> {
    let mut options = BenchOptions { only: None, rounds: 300, limit: 120, json: false };
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or_else(|| format!("{arg} needs a value"));
        let whole = |v: String| v.parse::<u32>().map_err(|_| format!("`{v}` is not a number"));
        match arg.as_str() {
            "--bench" => {}
            "--json" => options.json = true,
            "--only" => options.only = Some(value()?),
            "--rounds" => options.rounds = whole(value()?)?.max(1) as usize,
            "--limit" => options.limit = whole(value()?)?,
            _ => return Err(format!("`{arg}` is not --only NAME, --rounds N, --limit SECONDS or --json")),
        }
    }
    Ok(options)
}

/// Column, program with its arguments, and its input.
type PeerBuild = (usize, Result<Vec<PathBuf>, Without>, PathBuf);

/// Returns all peers that can play a network.
fn plans(case: &Case, net: &Net, builder: &Builder) -> Result<Vec<PeerBuild>, std::io::Error> {
    let table = builder.table(net)?;
    let one = |path: PathBuf| vec![path];
    let mut all = Vec::new();
    if !case.net.space {
        all.push((0, builder.faust(net, "clang++").map(one), PathBuf::new()));
        all.push((1, builder.faust(net, "g++").map(one), PathBuf::new()));
    }
    all.push((2, builder.peer("flat.c", "clang").map(one), table.clone()));
    all.push((3, builder.peer("flat.c", "gcc").map(one), table.clone()));
    if !case.net.space {
        all.push((4, builder.peer("boxed.cpp", "clang++").map(one), table.clone()));
        all.push((5, builder.peer("boxed.cpp", "g++").map(one), table.clone()));
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("peers/by_numba.py");
        let numba = numba().map(|(python, _)| vec![python, script]).ok_or(Without::Missing("numba".into()));
        all.push((6, numba, table));
    }
    if let Some((shape, n)) = case.stencil {
        // the faster of the two compilers counts, so one column is enough
        for (column, dampers) in [(7, "damped"), (8, "undamped")] {
            for compiler in ["clang", "gcc"] {
                let what = PathBuf::from(format!("{shape}:{n}:{dampers}"));
                all.push((column, builder.peer("stencil.c", compiler).map(one), what));
            }
        }
    }
    Ok(all)
}

/// Plays one network with all its players, in turn.
fn measure(case: &Case, builder: &Builder, rounds: usize) -> Result<Row, String> {
    let name = &case.net.name;
    let mut engine = Engine::new(&case.net);
    let mut row = Row::new(case);
    if engine.modules() != case.net.lines() {
        return Err(format!("{name}: the engine computes {} modules of {}", engine.modules(), case.net.lines()));
    }
    let heard = engine.play(case.compared).map_err(|e| e.to_string())?;
    let net = engine.started(&case.net);
    let mut all = Vec::new();
    for (column, program, what) in plans(case, &net, builder).map_err(|e| e.to_string())? {
        let command = match program {
            Ok(command) => command,
            Err(why) => {
                if let Without::Failed(text) = &why {
                    return Err(format!("{name}, {}: {text}", PEERS[column]));
                }
                // the other compiler of this column may be installed
                row.peers[column].get_or_insert(Err(why));
                continue;
            }
        };
        let mut peer = start(&command, &what).map_err(|e| format!("{name}, {}: {e}", PEERS[column]))?;
        let theirs = peer.play(case.compared).map_err(|e| format!("{name}, {}: {e}", PEERS[column]))?;
        let theirs: Vec<f64> = theirs.into_iter().map(|x| x - case.net.rest()).collect();
        let ours = match case.stencil.filter(|_| column >= 7) {
            Some((shape, n)) => Engine::new(&nets::alike(shape == "mesh", n, column == 7))
                .play(case.compared)
                .map_err(|e| e.to_string())?,
            None => heard.clone(),
        };
        let off = apart(&ours, &theirs);
        eprintln!("{name}, {}: within {off:.1e} of the engine", PEERS[column]);
        if off.is_nan() || off > case.tolerance {
            return Err(format!("{name}, {}: plays something else, {off:e} off", PEERS[column]));
        }
        row.peers[column] = Some(Ok(f64::INFINITY));
        all.push((column, command, what));
    }
    for _ in 0..STARTS {
        let mut players: Vec<(Option<usize>, Box<dyn Player>)> = vec![(None, Box::new(Engine::new(&case.net)))];
        for (column, command, what) in &all {
            players.push((Some(*column), Box::new(start(command, what).map_err(|e| format!("{name}: {e}"))?)));
        }
        time(&mut row, &mut players, rounds.div_ceil(STARTS)).map_err(|e| format!("{name}: {e}"))?;
    }
    Ok(row)
}

fn start(command: &[PathBuf], what: &Path) -> Result<Peer, std::io::Error> {
    let command: Vec<&Path> = command.iter().map(PathBuf::as_path).collect();
    Peer::start(&command, what)
}

fn time(row: &mut Row, players: &mut [(Option<usize>, Box<dyn Player>)], rounds: usize) -> Result<(), std::io::Error> {
    let mut ticks = Vec::new();
    for (_, player) in players.iter_mut() {
        let each = (0..3).map(|_| player.time(4 * BLOCK)).collect::<Result<Vec<_>, _>>()?;
        let each = each.into_iter().fold(f64::INFINITY, f64::min) / (4 * BLOCK) as f64;
        ticks.push(((ROUND / each / BLOCK as f64) as usize).clamp(1, 256) * BLOCK);
    }
    for round in 0..rounds {
        for i in 0..players.len() {
            let i = (i + round) % players.len();
            let (column, player) = &mut players[i];
            let ns = player.time(ticks[i])? / ticks[i] as f64;
            match column.map(|c| &mut row.peers[c]) {
                None => row.engine = row.engine.min(ns),
                Some(Some(Ok(best))) => *best = best.min(ns),
                Some(_) => {}
            }
        }
    }
    Ok(())
}

fn machine() -> String {
    let by = ["faust", "clang++", "g++"].map(|p| version(p).unwrap_or_else(|| format!("no {p}")));
    let numba = numba().map_or("no numba".into(), |(_, version)| version);
    format!("The machine of this page is {}; {}, {numba}.", ca_benches::machine(), by.join(", "))
}

fn as_json(rows: &[Row], machine: &str, wide: bool) -> Value {
    let peers = |row: &Row| -> serde_json::Map<String, Value> {
        let cell = |time: &Result<f64, Without>| match time {
            Ok(ns) => json!(ns),
            Err(Without::Missing(what)) => json!(format!("no {what}")),
            Err(Without::Late(s)) => json!(format!("not compiled in {s} s")),
            Err(Without::Failed(why)) => json!(why),
        };
        let of = PEERS.iter().zip(&row.peers).filter_map(|(name, time)| Some(((*name).into(), cell(time.as_ref()?))));
        of.collect()
    };
    let claims = |row: &Row| -> Vec<Value> {
        let of = row.claims(wide).into_iter().flatten();
        of.map(|c| json!({"what": c.what, "is": c.is, "target": c.target.map(|t| t.0), "holds": c.holds()})).collect()
    };
    let row = |r: &Row| json!({"network": r.name, "modules": r.modules, "ca_ns": r.engine, "peers_ns": peers(r), "figures": claims(r)});
    json!({"machine": machine, "rows": rows.iter().map(row).collect::<Vec<_>>()})
}

fn run() -> Result<(), String> {
    let options = bench_options()?;
    // `cargo test --benches` only checks that it runs
    if !std::env::args().any(|a| a == "--bench") {
        for case in cases() {
            Engine::new(&case.net).play(BLOCK).map_err(|e| e.to_string())?;
        }
        return Ok(());
    }
    let builder = Builder::new(folder(), options.limit).map_err(|e| e.to_string())?;
    let chosen = |case: &Case| options.only.as_ref().is_none_or(|only| case.net.name.contains(only.as_str()));
    let all = cases();
    let rows = all.iter().filter(|c| chosen(c)).map(|c| measure(c, &builder, options.rounds));
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    if rows.is_empty() {
        let names: Vec<String> = cases().into_iter().map(|c| c.net.name).collect();
        return Err(format!("no network of that name; there are {}", names.join("; ")));
    }
    let machine = machine();
    let wide = machine.contains("avx512f");
    let text = page(&rows, &machine, wide);
    println!("{}", if options.json { format!("{:#}", as_json(&rows, &machine, wide)) } else { text.clone() });
    if std::env::var_os("UPDATE").is_some() && options.only.is_none() {
        let name = if wide { "peers.md" } else { "peers-avx2.md" };
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/measured").join(name);
        std::fs::write(path, text).map_err(|e| e.to_string())?;
    }
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}
