//! What a hand does: gestures, ports that drive parameters, pointers, and the guard before it.

mod driven;
mod gestures;
mod guard;
mod live;
mod pointer;
