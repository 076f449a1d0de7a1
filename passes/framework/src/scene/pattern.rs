//! Patterns that name elements of arrays: `qdd[3]`, `M[*,1..4]`, `qdd`.

use robovec_ir::{Function, Output, View};
use std::fmt;

/// The indices that one place of a pattern allows. They count from 1.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum IndexPattern {
    /// Every index.
    Any,
    /// Those from the first to the last, both included; one when they are
    /// equal.
    Between(u32, u32),
}

impl IndexPattern {
    fn allows(self, index: u32) -> bool {
        match self {
            IndexPattern::Any => true,
            IndexPattern::Between(first, last) => (first..=last).contains(&index),
        }
    }
}

impl fmt::Display for IndexPattern {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            IndexPattern::Any => formatter.write_str("*"),
            IndexPattern::Between(first, last) if first == last => write!(formatter, "{first}"),
            IndexPattern::Between(first, last) => write!(formatter, "{first}..{last}"),
        }
    }
}

/// Elements of an array.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct ElementPattern {
    /// The name of the array.
    pub array: String,
    /// One for each index of the array; without any, every element is meant.
    pub indices: Vec<IndexPattern>,
}

impl ElementPattern {
    /// Every element of an array.
    pub fn whole(array: &str) -> ElementPattern {
        ElementPattern {
            array: array.to_owned(),
            indices: Vec::new(),
        }
    }

    /// True for an element with these indices, of which an array of vectors
    /// has one and a matrix two.
    pub fn matches(&self, array: &str, indices: &[u32]) -> bool {
        self.array == array
            && (self.indices.is_empty()
                || self.indices.len() == indices.len()
                    && self
                        .indices
                        .iter()
                        .zip(indices)
                        .all(|(pattern, &index)| pattern.allows(index)))
    }

    /// True for an output element of a function.
    pub fn matches_output(&self, view: View<'_>, output: Output) -> bool {
        let (array, indices, rank) = view.function.output_element(output);
        self.matches(view.tables.symbols.text(array.name), &indices[..rank])
    }

    /// The output elements that a function sets and the pattern means, in the
    /// order of the function's assignments.
    pub fn outputs(&self, view: View<'_>) -> Vec<Output> {
        let function: &Function = view.function;
        let set = function
            .assignments
            .iter()
            .map(|assignment| assignment.output);
        set.filter(|&output| self.matches_output(view, output))
            .collect()
    }
}

impl fmt::Display for ElementPattern {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.array)?;
        for (place, index) in self.indices.iter().enumerate() {
            let before = if place == 0 { '[' } else { ',' };
            write!(formatter, "{before}{index}")?;
        }
        if !self.indices.is_empty() {
            formatter.write_str("]")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_mean_elements_and_print_as_they_are_written() {
        let pattern = ElementPattern {
            array: "M".to_owned(),
            indices: vec![IndexPattern::Any, IndexPattern::Between(2, 4)],
        };
        assert_eq!(pattern.to_string(), "M[*,2..4]");
        assert!(pattern.matches("M", &[7, 4]) && pattern.matches("M", &[1, 2]));
        assert!(!pattern.matches("M", &[2, 5]) && !pattern.matches("c", &[2, 2]));
        assert!(!pattern.matches("M", &[2]));
        let whole = ElementPattern::whole("M");
        assert_eq!(whole.to_string(), "M");
        assert!(whole.matches("M", &[3, 3]) && whole.matches("M", &[]));
        let one = ElementPattern {
            array: "q".to_owned(),
            indices: vec![IndexPattern::Between(3, 3)],
        };
        assert_eq!(one.to_string(), "q[3]");
    }
}
