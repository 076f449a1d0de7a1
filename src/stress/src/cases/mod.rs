//! The cases.

mod cancellation;
mod chains;
mod contact;
mod drift;
mod far;
mod long;
mod loops;
mod models;
mod ratios;
mod scales;
mod series;
mod springs;

use super::case::StressCase;

#[cfg(test)]
pub(super) use loops::four_bar;

/// All cases, in the order of their classes.
pub fn cases() -> Vec<StressCase> {
    let mut cases = chains::cases();
    cases.extend(ratios::cases());
    cases.extend(scales::cases());
    cases.extend(cancellation::cases());
    cases.extend(springs::cases());
    cases.extend(contact::cases());
    cases.extend(far::cases());
    cases.extend(loops::cases());
    cases.extend(series::cases());
    cases.extend(long::cases());
    cases.extend(drift::cases());
    // A stable sort keeps the order within a class.
    cases.sort_by_key(|case| case.class);
    cases
}
