//! stub
use crate::{Failure, Outcome};
pub fn run(_: &crate::args::NewArgs) -> Outcome {
    Err(Failure::Usage("not yet".into()))
}
