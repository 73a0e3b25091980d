//! (mims)
