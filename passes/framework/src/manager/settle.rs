//! End of a pass: its report, its error, or its panic.

use super::RunError;
use crate::pass::{NestedReport, PassError};
use robovec_ir::Function;
use std::any::Any;

/// Error of a pass that gave up, and its place.
pub(super) fn pass_failed(name: &str, function: &Function, error: PassError) -> RunError {
    RunError::Pass {
        pass: name.to_owned(),
        function: function.name.clone(),
        error,
    }
}

/// Report of a pass, or the reason why the run ends with it.
pub(super) fn settled(
    ran: Result<Result<NestedReport, PassError>, Box<dyn Any + Send>>,
    name: &str,
    function: &Function,
) -> Result<NestedReport, RunError> {
    match ran {
        Ok(Ok(report)) => Ok(report),
        Ok(Err(error)) => Err(pass_failed(name, function, error)),
        Err(panic) => Err(RunError::Panic {
            pass: name.to_owned(),
            function: function.name.clone(),
            message: panic_message(panic.as_ref()),
        }),
    }
}

fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("without a message").to_owned()
}
