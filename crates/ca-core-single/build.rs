//! Turns the numbers of the tick to single precision, for this crate and no other.

fn main() {
    println!("cargo::rustc-cfg=single");
    println!("cargo::rerun-if-changed=build.rs");
}
