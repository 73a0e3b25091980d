//! stub
use crate::{Failure, Outcome};
pub fn run(_: &crate::args::CheckArgs) -> Outcome {
    Err(Failure::Usage("not yet".into()))
}
