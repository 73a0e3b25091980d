//! Verdicts of the bundled models: with explicit links, as they are, and by `method = "auto"`.

use super::rendering::{file_names, load};
use ca_benches::proven::HEAD;
use ca_compile::{Options, compile};
use ca_tests::catalog;

const PAGE: &str = include_str!("../../../docs/measured/proven.md");

/// No model is proven less than with explicit links, `auto` proves none less than it is written, and the page has
/// these verdicts.
#[test]
fn bundled_models_have_the_verdicts_of_the_page() {
    assert!(PAGE.starts_with(HEAD), "`UPDATE=1 cargo bench -p ca-benches --bench proven` makes it anew");
    let rows = PAGE.lines().filter(|l| l.starts_with("| ")).skip(1);
    let written: Vec<Vec<&str>> = rows.map(|row| row.split('|').map(str::trim).collect()).collect();
    assert_eq!(written.len(), file_names().len());
    for (name, row) in file_names().iter().zip(written) {
        let level = |method: Option<&str>| {
            let mut model = load(name);
            if let Some(method) = method {
                assert!(model.set("model.method", method));
            }
            let c = compile(&model, &catalog(), &Options::default()).unwrap_or_else(|d| panic!("{name}: {d:?}"));
            c.certificate.level
        };
        let levels = [level(Some("ca")), level(None), level(Some("auto"))];
        assert!(levels[1] <= levels[0] && levels[2] <= levels[1], "{name}: {levels:?}");
        let said = [name.to_owned(), levels[0].to_string(), levels[1].to_string(), levels[2].to_string()];
        assert_eq!([row[1], row[2], row[4], row[6]], said.each_ref().map(String::as_str));
    }
}
