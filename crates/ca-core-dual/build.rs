//! Turns the numbers of the tick to dual numbers, for this crate and no other.

fn main() {
    println!("cargo::rustc-cfg=dual");
    println!("cargo::rerun-if-changed=build.rs");
}
