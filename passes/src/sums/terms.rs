//! Terms that cancel.

/// Sorts the terms of a sum and takes out pairs of a term and its opposite,
/// which must be neighbours in the order of terms.
pub(crate) fn cancel<T: Copy + Ord>(terms: &mut Vec<T>, opposite: impl Fn(T) -> T) {
    terms.sort_unstable();
    let mut kept = 0;
    for place in 0..terms.len() {
        let term = terms[place];
        // Several copies of one term may lie between two pairs.
        if kept > 0 && terms[kept - 1] == opposite(term) {
            kept -= 1;
        } else {
            terms[kept] = term;
            kept += 1;
        }
    }
    terms.truncate(kept);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_go_and_copies_stay() {
        let opposite = |(term, negative): (char, bool)| (term, !negative);
        let [a, b, c] = ['a', 'b', 'c'].map(|name| (name, false));
        let minus = [a, b, c].map(opposite);
        let mut terms = vec![c, a, minus[0], b, a, minus[1], a, minus[1], minus[1]];
        cancel(&mut terms, opposite);
        assert_eq!(terms, [a, a, minus[1], minus[1], c]);
    }
}
