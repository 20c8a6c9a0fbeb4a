use super::CtlError;
use crate::cli;
pub fn run(_arguments: &cli::Stats) -> Result<(), CtlError> {
    Ok(())
}
