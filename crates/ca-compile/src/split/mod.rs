//! Split: one big scene as two halves, which two threads play side by side.
//!
//! ```text
//! Pruned ─ cut ─ which half each MAT is in ─ half ─ the network of one half ─ emit ─ its scene
//! ```
//! Decides to cut the network and not the list of passes: each half is a scene by itself, with kernels, rows and folds as
//! any other, and a state that no other thread writes. A MAT that a link ties to the other half stands there too, as a
//! *ghost*: a fixed point whose position and motion are written from outside between two ticks. A link across the cut is
//! computed in both halves, each time for the end that moves there, so every MAT gets the forces of the whole scene. Link by
//! link the bits are the same; the fast passes find rows in each half by itself, and may round otherwise. The same cut is
//! made each time, and on every processor. What is solved at once, or shares numbers with others (a moving point, a set of
//! contacts, a quadripole, implicit links), stays in one half.
//!
//! Groups at the gesture rate are cut out in the same way, to be a scene of their own at another tick (`rates`).

pub mod cut;
pub mod half;
pub mod rates;
