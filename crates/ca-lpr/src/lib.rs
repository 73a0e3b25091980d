//! LPR links will live here: quadripoles whose axial deformations in a 3-D world and in a 1-D acoustic world are
//! summed, with one force at both ports, so that energy crosses and nothing is created. Nothing is built yet: the 1-D
//! world of [`ca_core`] comes first.
#![forbid(unsafe_code)]
