//! Links as passes, in the order of work:
//! - [`batches`]: links of one law, in the order of rows ([`row_order`]);
//! - [`chains`]: short rows that run as one;
//! - [`fuse`]: integration with the links, by [`added`], and of meshes by [`bands`];
//! - [`join`]: rows that run as one;
//! - [`fold`]: rows in eight lanes;
//! - [`fans`]: lists from one slot to a row;
//! - [`links`]: the arrays; [`space`]: rows of points in space;
//! - [`document_order`]: document order for state hashes.

pub mod added;
pub mod bands;
pub mod batch;
pub mod batches;
pub mod chains;
pub mod document_order;
pub mod fans;
pub mod fold;
pub mod fuse;
pub mod join;
pub mod links;
pub mod row_order;
pub mod space;
