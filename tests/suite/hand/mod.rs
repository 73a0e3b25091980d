//! The hand: gestures, ports, pointers, scales in the hand, the guard, the real-time loop.

mod driven;
mod equivalence;
mod gestures;
mod guard;
mod live;
mod pointer;
