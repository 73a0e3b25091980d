//! Gestures, ports, pointers, scaling at the hand, the guard, the real-time loop.

mod driven;
mod equivalence;
mod gestures;
mod guard;
mod live;
mod pointer;
