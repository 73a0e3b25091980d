//! Counts memory and work for very large models: proportional to the text, and no more for a refused text.

use crate::{calls, most};
use ca_benches::string;
use ca_compile::{Options, compile, load};
use ca_model::diag::KEPT;
use ca_model::read::read;
use ca_tests::catalog;
use std::fmt::Write as _;

/// A chain of `n` masses written one by one. Its links name their second end `to` and a number.
fn chain(n: usize, to: &str) -> String {
    let mut text = String::from("[SOL]\nwall = {}\n[MAS]\n");
    (0..n).for_each(|i| _ = writeln!(text, "m{i} = {{ m = \"1 g\" }}"));
    text += "[REF]\n";
    for i in 1..n {
        let (a, b) = (i - 1, i);
        _ = writeln!(text, "r{b} = {{ between = [\"m{a}\", \"{to}{b}\"], k = \"10 kN/m\", z = \"5 mN s/m\" }}");
    }
    text + "[SOX]\nout = { from = \"m0\" }\n"
}

#[test]
fn more_modules_than_a_model_holds_are_refused_before_they_are_parsed() {
    let mut text = String::from("[SOL]\nwall = {}\n[MAS]\n");
    (0..1_000_000).for_each(|i| _ = writeln!(text, "m{i}={{m=1}}"));
    let mut found = Vec::new();
    let bytes = most(|| {
        let (_, result) = load(&text, "large.ca.toml", &catalog(), &Options::default());
        found = result.unwrap_err().list;
    });
    let last = text.rfind("m999999").unwrap();
    assert_eq!(found.len(), 1, "{}", found[0].title);
    assert_eq!((found[0].code, found[0].span().start), ("E027", last));
    assert!(bytes < 2 * text.len() as u64, "{bytes} bytes for {}", text.len());
}

#[test]
fn a_mistake_in_every_line_costs_no_more_than_none() {
    let (right, wrong) = (chain(30_000, "m"), chain(30_000, "n"));
    let play = |text: &str| load(text, "large.ca.toml", &catalog(), &Options::default()).1;
    let (mut good, mut found) = (false, None);
    let of_right = most(|| good = play(&right).is_ok());
    let of_wrong = most(|| found = play(&wrong).err());
    let found = found.expect("errors");
    assert!(good && found.is_full());
    assert_eq!(found.list.len(), KEPT + 1);
    let limit = found.list.last().unwrap();
    assert_eq!((limit.code, limit.title.as_str()), ("E027", "more than 100 errors: the search stopped there"));
    println!("right {} wrong {} of {}", of_right, of_wrong, right.len());
    assert!(of_wrong < of_right, "{of_wrong} {of_right}");
}

#[test]
fn reading_takes_memory_and_work_in_proportion_to_the_text() {
    let (small, large) = (chain(30_000, "m"), chain(60_000, "m"));
    let took = |text: &str| {
        let mut bytes = 0;
        let work = calls(|| bytes = most(|| assert!(read(text, "large.ca.toml", &catalog()).1.list.is_empty())));
        println!("{bytes} bytes, {work} calls for {}", text.len());
        (bytes as f64 / text.len() as f64, work as f64 / text.len() as f64)
    };
    let (few, many) = (took(&small), took(&large));
    assert!(many.0 < 1.2 * few.0 && many.1 < 1.05 * few.1, "{few:?} {many:?}");
}

/// Limits per module: peak bytes while compiling, bytes of a state, and allocator calls, freeing included.
const BYTES: f64 = 510.0;
const STATE: f64 = 33.0;
const CALLS: f64 = 5.1;

#[test]
fn a_generated_model_takes_memory_and_work_in_proportion_to_its_modules() {
    let took = |masses: usize| {
        let (model, _) = read(&string(masses), "large.ca.toml", &catalog());
        let (mut bytes, mut scene) = (0, None);
        let work = calls(|| bytes = most(|| scene = compile(&model, &catalog(), &Options::default()).ok()));
        let scene = scene.expect("it compiles").scene;
        let modules = (scene.mats() + scene.lias()) as f64;
        let held = most(|| drop(std::hint::black_box(scene.state())));
        println!("{bytes} bytes at most, {held} of a state, {work} calls for {modules} modules");
        [bytes as f64, held as f64, work as f64].map(|v| v / modules)
    };
    let (few, many) = (took(20_000), took(40_000));
    for (few, many) in few.into_iter().zip(many) {
        assert!(many < 1.05 * few, "{few} {many}");
    }
    // this fails once a pass makes one more list per module
    assert!(many[0] < BYTES && many[1] < STATE && many[2] < CALLS, "{many:?}");
}
