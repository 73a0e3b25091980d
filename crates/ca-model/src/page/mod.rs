//! Pages of the language: of a kind of modules ([`kind`]), and of the parts that come with the program ([`part`]), as text and JSON.

pub mod kind;
pub mod part;
