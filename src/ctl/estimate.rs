use super::CtlError;
use crate::cli;
pub fn run(_arguments: &cli::Estimate) -> Result<(), CtlError> {
    Ok(())
}
