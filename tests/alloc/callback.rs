//! Checks that the callback of the `callback` example allocates nothing, as its header says.

#[allow(dead_code)]
#[path = "../../crates/cordis-anima/examples/callback.rs"]
mod example;

use crate::counting::calls;

#[test]
fn the_callback_of_the_example_allocates_nothing() {
    let (mut voice, panel) = example::voice();
    let mut block = [0.0; 128];
    for n in 0..100 {
        panel.pitch(200.0 + f64::from(n));
        assert_eq!(calls(|| voice.fill(&mut block)), 0, "block {n}");
    }
    assert!(block.iter().any(|s| s.abs() > 1e-3), "it is heard");
}
