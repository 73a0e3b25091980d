//! stub
use crate::{Failure, Outcome};
pub fn run(_: &crate::args::ListArgs) -> Outcome {
    Err(Failure::Usage("not yet".into()))
}
