//! Pages of a kind ([`kind`]) and of a bundled part ([`part`]), as text and JSON.

pub mod kind;
pub mod part;
