//! The bundled models by `method = "auto"`: none is refused, and none is proven less than as it is written.

use super::rendering::{file_names, load};
use ca_compile::{Options, compile};
use ca_tests::catalog;

#[test]
fn bundled_models_are_proven_no_less() {
    for name in file_names() {
        let level = |method: Option<&str>| {
            let mut model = load(&name);
            if let Some(method) = method {
                assert!(model.set("model.method", method));
            }
            let c = compile(&model, &catalog(), &Options::default()).unwrap_or_else(|d| panic!("{name}: {d:?}"));
            c.certificate.level
        };
        let (before, after) = (level(None), level(Some("auto")));
        assert!(after <= before, "{name}: {before}, by `auto` {after}");
        println!("{name:18} {before:18} {after}");
    }
}
