//! Links as passes, in the order of work: batches of links of one law ([`batches`]) in the order of rows ([`sorted`]), short rows
//! of one law as one ([`chains`]), what is integrated with them ([`fuse`] by [`added`], meshes by [`bands`]), rows that run as one ([`join`]), rows in eight lanes ([`fold`]), lists from one place
//! to a row ([`fans`]), their arrays ([`links`]), rows of points in space ([`space`]), and the order of the document in which a state is hashed ([`written`]).

pub mod added;
pub mod bands;
pub mod batch;
pub mod batches;
pub mod chains;
pub mod fans;
pub mod fold;
pub mod fuse;
pub mod join;
pub mod links;
pub mod sorted;
pub mod space;
pub mod written;
