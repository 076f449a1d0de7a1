//! Which output of one version belongs to which of the other.

use robovec_ir::print::print_output;
use robovec_ir::{Array, Output, View};

/// The same output element in both versions.
pub(super) struct Pair {
    pub(super) output: Output,
    /// Index into the assignments of the version before.
    pub(super) before: usize,
    /// Index into the assignments of the version after.
    pub(super) after: usize,
}

/// Two versions of a function with the same signature and the same outputs.
pub(super) struct Pairs<'a> {
    pub(super) before: View<'a>,
    pub(super) after: View<'a>,
    /// In order of the output elements.
    pub(super) list: Vec<Pair>,
}

/// Why two functions cannot be compared, for people.
pub(super) struct Unpaired {
    /// The output that only one of them sets, if it is that.
    pub(super) output: Option<Output>,
    pub(super) reason: String,
}

impl<'a> Pairs<'a> {
    pub(super) fn new(before: View<'a>, after: View<'a>) -> Result<Pairs<'a>, Unpaired> {
        same_arrays(
            "input",
            before,
            before.function.inputs(),
            after,
            after.function.inputs(),
        )?;
        same_arrays(
            "output",
            before,
            before.function.outputs(),
            after,
            after.function.outputs(),
        )?;
        let (first, second) = (by_output(before)?, by_output(after)?);
        let mut list = Vec::with_capacity(before.function.assignments.len());
        for (index, indices) in first.into_iter().zip(second).enumerate() {
            let output = Output(index as u32);
            match indices {
                (Some(before), Some(after)) => list.push(Pair {
                    output,
                    before,
                    after,
                }),
                (None, None) => {}
                (Some(_), None) => return Err(one_sided(before, output, "no longer set")),
                (None, Some(_)) => {
                    return Err(one_sided(before, output, "set, and was not before"));
                }
            }
        }
        Ok(Pairs {
            before,
            after,
            list,
        })
    }
}

fn one_sided(view: View<'_>, output: Output, what: &str) -> Unpaired {
    Unpaired {
        output: Some(output),
        reason: format!("{} is {what}", print_output(view, output)),
    }
}

/// For each output element the assignment that sets it.
fn by_output(view: View<'_>) -> Result<Vec<Option<usize>>, Unpaired> {
    let mut found = vec![None; view.function.output_len()];
    for (index, assignment) in view.function.assignments.iter().enumerate() {
        let entry = &mut found[assignment.output.index()];
        if entry.replace(index).is_some() {
            return Err(one_sided(view, assignment.output, "set twice"));
        }
    }
    Ok(found)
}

fn same_arrays(
    what: &str,
    before: View<'_>,
    left: &[Array],
    after: View<'_>,
    right: &[Array],
) -> Result<(), Unpaired> {
    let describe = |view: View<'_>, array: &Array| {
        let name = view.tables.symbols.text(array.name).to_owned();
        (name, array.shape)
    };
    let left: Vec<_> = left.iter().map(|array| describe(before, array)).collect();
    let right: Vec<_> = right.iter().map(|array| describe(after, array)).collect();
    if left == right {
        return Ok(());
    }
    let odd = left.iter().find(|array| !right.contains(array));
    let odd = odd.or_else(|| right.iter().find(|array| !left.contains(array)));
    Err(Unpaired {
        output: None,
        reason: match odd {
            Some((name, _)) => format!("the {what} array {name} is not the same in both versions"),
            None => format!("the {what} arrays stand in another order"),
        },
    })
}
