//! Tests `ca check --watch`: a file is checked each time it is saved.

use crate::sandbox::Sandbox;
use std::io::{BufRead as _, BufReader};

#[test]
fn a_file_is_checked_whenever_it_is_saved() {
    let sandbox = Sandbox::new();
    let good = "[CEL]\nm = { m = \"1 g\", f = \"100 Hz\" }\n[SOX]\no = { from = \"m\" }\n";
    sandbox.put("mine.ca.toml", good);
    let mut child = sandbox.start(&["check", "mine.ca.toml", "--watch"]);
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    // collects the messages until the command waits again
    let mut said = || {
        let mut all = Vec::new();
        for line in lines.by_ref() {
            let line = line.unwrap();
            if line.contains("waiting until") {
                return all.join("\n");
            }
            all.push(line);
        }
        panic!("it ended: {all:?}");
    };
    assert_eq!(said(), "");
    sandbox.put("mine.ca.toml", &good.replace("[CEL]", "[CELL]"));
    let wrong = said();
    assert!(wrong.contains("mine.ca.toml") && wrong.contains("error"), "{wrong}");
    sandbox.put("mine.ca.toml", &good.replace("100 Hz", "200 Hz"));
    assert_eq!(said(), "");
    // a part file that did not exist before is watched too
    let uses = format!("{good}[use]\nx = \"part.ca.toml\"\n");
    sandbox.put("mine.ca.toml", &uses);
    let missing = said();
    assert!(missing.contains("part.ca.toml") && missing.contains("E031"), "{missing}");
    sandbox.put("part.ca.toml", "[MAS]\nbob = { m = \"-1 g\" }\n");
    let wrong = said();
    assert!(wrong.contains("part.ca.toml:2") && wrong.contains("E009"), "{wrong}");
    child.kill().unwrap();
    child.wait().unwrap();
    Sandbox::new().ca(&["check", "rattle", "--watch"]).is(2).says(&["bundled"]);
}
