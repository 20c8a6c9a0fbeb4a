use super::CtlError;
use crate::cli;
pub fn run(_arguments: &cli::Record) -> Result<(), CtlError> {
    Ok(())
}
