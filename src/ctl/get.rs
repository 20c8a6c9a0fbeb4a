use super::CtlError;
use crate::cli;
pub fn run(_arguments: &cli::Get) -> Result<(), CtlError> {
    Ok(())
}
