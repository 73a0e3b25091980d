//! Instructions per tick, counted by valgrind, so that they do not depend on what else the machine does: what a scene
//! pays for what it does not use is nothing.
//!
//! The same string is played as it is; with a body in space, an LPR and a device in the file that nothing hears, which
//! the compiler leaves out; and with each of them heard. The first two must count the same, and the bench fails where
//! they do not. It counts by running itself under `valgrind --tool=callgrind`, twice with different numbers of ticks;
//! without valgrind it says so and counts nothing.

use ca_benches::{model, scene, string};
use ca_core::{KernelClass, tick};
use std::process::{Command, ExitCode};

/// Ticks of the two runs whose difference counts.
const FEW: u32 = 1024;
const MANY: u32 = 11 * FEW;

const BODY: &str = "[room]\ndim = 3\n[room.TETRA]\np = { edge = 0.02, m = 1e-3 }\n[MESH]\nsheet = { nx = 4, ny = 4, \
                    m = 1e-3, k = 1e5, edges = \"closed\" }\n[SOL]\nrim = {}\n[LPR]\nedges = { between = [\"room.p[*]\", \
                    \"room.p[*]\"], onto = [\"rim\", \"sheet[1,1]\"], k = 2e4 }\n";

fn cases() -> [(&'static str, String); 5] {
    let string = string(100);
    let heard = "far = { from = \"room.p[0]\", along = \"x\", dc = 0 }\n";
    let key = "[TGR]\nkey = {}\n[RES]\ntie = { between = [\"key\", \"s[50]\"], k = 500 }\n";
    let filter = "[rate]\nfilter = \"18 kHz\"\n";
    [
        ("a string of 100", string.clone()),
        ("… and what nobody hears in space", format!("{string}{BODY}")),
        ("… and a tetrahedron of 6 LPR that is heard", format!("{string}{heard}{BODY}")),
        ("… on a device key", format!("{string}{key}")),
        ("… behind a low-pass", format!("{filter}{string}")),
    ]
}

/// Instructions of a run of this many ticks of case `i`.
fn count(i: usize, ticks: u32) -> Option<u64> {
    let out = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .env("CA_INSTRUCTIONS", format!("{i} {ticks}"))
        .output()
        .ok()?;
    let told = String::from_utf8_lossy(&out.stderr).into_owned();
    told.lines().find_map(|l| l.split("Collected : ").nth(1)).and_then(|n| n.trim().parse().ok())
}

fn main() -> ExitCode {
    if let Ok(run) = std::env::var("CA_INSTRUCTIONS") {
        let mut numbers = run.split(' ').filter_map(|n| n.parse::<usize>().ok());
        let (i, ticks) = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
        let scene = scene(&model(&cases()[i].1), KernelClass::Fast, false);
        let mut state = scene.state();
        (0..ticks).for_each(|_| tick(&scene, &mut state));
        assert!(state.is_sound(1.0));
        return ExitCode::SUCCESS;
    }
    println!("{:<46} {:>7} {:>18}", "", "passes", "instructions/tick");
    let mut counts = Vec::new();
    for (i, (name, text)) in cases().iter().enumerate() {
        let scene = scene(&model(text), KernelClass::Fast, false);
        let passes = scene.reads.len() + scene.forces.len() + scene.writes.len() + scene.moves.len();
        let (Some(few), Some(many)) = (count(i, FEW), count(i, MANY)) else {
            println!("instructions are counted by valgrind, which is not at hand");
            return ExitCode::SUCCESS;
        };
        let each = (many - few) as f64 / f64::from(MANY - FEW);
        println!("{name:<46} {passes:>7} {each:>18.1}");
        counts.push(each);
    }
    // a hash seed or the length of an environment may cost a handful of instructions over a whole run
    if (counts[1] - counts[0]).abs() > 0.05 {
        println!("what nobody hears is paid for");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
