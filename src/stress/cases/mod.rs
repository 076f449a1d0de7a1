//! The cases.

mod chains;

use super::case::Case;

/// All cases, in the order of their classes.
pub fn cases() -> Vec<Case> {
    let mut cases = chains::cases();
    cases.sort_by_key(|case| case.class);
    cases
}
