//! stub
use crate::{Failure, Outcome};
pub fn run(_: &crate::args::ImportArgs) -> Outcome {
    Err(Failure::Usage("not yet".into()))
}
