//! Every start has the order of its method, by the functions that make the table of `docs/measured/atlas.md`.

use crate::play::{scene, within};
use ca_benches::atlas::orders::CASES;
use ca_io::perform::Performance;

#[test]
fn a_start_has_the_order_of_its_method() {
    let page = include_str!("../../../docs/measured/atlas.md");
    let rows: Vec<String> = CASES.iter().map(ca_benches::atlas::orders::Case::row).collect();
    let here = rows.join("\n");
    for case in &CASES {
        for is in case.measured() {
            within(&format!("order of {}", case.name), (is - case.order).abs(), 0.25);
        }
    }
    assert!(page.contains(&here), "the page is of another build, not\n{here}");
}

/// The default scheme starts a hand as before: the first tick places it, at rest.
#[test]
fn the_default_scheme_begins_as_it_did() {
    let text = |method: &str| {
        format!(
            "[CEL]\nbar = {{ m = 0.01, k = 600, v = 0.1 }}\n[ENX]\nhand = {{}}\n[REF]\ntie = {{ between = [\"hand\", \"bar\"], k = 400, z = 0.5{method} }}\n\
             [SOX]\nout = {{ from = \"bar\" }}\n[gesture]\nhand = [[0, 0.01], [1, 0.41]]\n"
        )
    };
    for (method, same) in [("", true), (", method = \"ca\"", true), (", method = \"centred\"", false)] {
        let scene = scene(&text(method));
        let p = Performance::new(&scene, None).expect("a gesture");
        assert_eq!(p.state == scene.state(), same, "{method}");
    }
}
