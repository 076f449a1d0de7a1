//! Statements of a scene about input elements, the more specific word winning.

use super::document::{DocumentProblems, DocumentRange};
use robovec_framework::scene::{Bindings, ElementPattern};
use robovec_ir::Shape;
use robovec_ir::states::Ranges;
use std::collections::BTreeMap;

/// Statement about an element.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum ElementKnowledge {
    /// It is an input of any size.
    Free,
    /// It is a number.
    Bound(f64),
    /// It is between two numbers.
    Range(f64, f64),
}

/// Specificity of a word about one element.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Rank {
    /// All parameters of the model, or the limits of its joints.
    Model,
    Array,
    Part,
    Element,
    /// A joint that is held.
    Joint,
}

impl Rank {
    /// The condition of a pattern for an array of a shape.
    pub(super) fn of(pattern: &ElementPattern, shape: Shape) -> Rank {
        let fixed = |index: &robovec_framework::scene::IndexPattern| {
            use robovec_framework::scene::IndexPattern::Between;
            matches!(index, Between(first, last) if first == last)
        };
        match (shape, pattern.indices.iter().all(fixed)) {
            (Shape::Scalar, _) => Rank::Element,
            _ if pattern.indices.is_empty() => Rank::Array,
            (_, true) => Rank::Element,
            (_, false) => Rank::Part,
        }
    }
}

struct ElementStatement {
    rank: Rank,
    known: ElementKnowledge,
    span: DocumentRange,
}

#[derive(Default)]
pub(super) struct ElementStatements {
    elements: BTreeMap<(String, [u32; 2]), ElementStatement>,
}

/// Maximum number of elements that a scene can name, far above any system's.
const MAX_ELEMENTS: usize = 1_000_000;

impl ElementStatements {
    /// Records a fact about the elements that a pattern names.
    pub(super) fn say(
        &mut self,
        shape: Shape,
        pattern: &ElementPattern,
        known: ElementKnowledge,
        span: &DocumentRange,
        problems: &mut DocumentProblems,
    ) {
        let rank = Rank::of(pattern, shape);
        if shape.len() > MAX_ELEMENTS {
            let message = format!("'{}' has more than {MAX_ELEMENTS} elements", pattern.array);
            problems.add(span.clone(), message);
            return;
        }
        for offset in 0..shape.len() as u32 {
            let (indices, count) = shape.indices(offset);
            if pattern.matches(&pattern.array, &indices[..count])
                && !self.element(&pattern.array, indices, rank, known, span, problems)
            {
                return;
            }
        }
    }

    /// Records a fact about an element; false for one against an earlier one.
    pub(super) fn element(
        &mut self,
        array: &str,
        indices: [u32; 2],
        rank: Rank,
        known: ElementKnowledge,
        span: &DocumentRange,
        problems: &mut DocumentProblems,
    ) -> bool {
        let word = ElementStatement {
            rank,
            known,
            span: span.clone(),
        };
        let key = (array.to_owned(), indices);
        let Some(before) = self.elements.get_mut(&key) else {
            self.elements.insert(key, word);
            return true;
        };
        let name = name(array, indices);
        if rank == before.rank {
            let other = Some((before.span.clone(), "here"));
            let message = format!("'{name}' is already bound or has a range");
            problems.point(span.clone(), message, None, other);
            return false;
        }
        if rank == Rank::Joint && before.rank >= Rank::Part {
            let other = Some((span.clone(), "the joint is locked here"));
            let message =
                format!("'{name}' belongs to a locked joint: it cannot be bound or have a range");
            let note = "leave it out, or do not lock the joint".to_owned();
            problems.point(before.span.clone(), message, Some(note), other);
            return false;
        }
        if rank > before.rank {
            *before = word;
        }
        true
    }

    /// All elements with a fact that does not come from the model, in order.
    pub(super) fn said(&self) -> impl Iterator<Item = (&str, [u32; 2], ElementKnowledge)> + '_ {
        let words = self.elements.iter();
        let own = words.filter(|(_, word)| word.rank > Rank::Model);
        own.map(|((array, indices), word)| (array.as_str(), *indices, word.known))
    }

    /// The bound elements, and the ranges of others.
    pub(super) fn split(self) -> (Bindings, Ranges) {
        let (mut bound, mut ranges) = (Bindings::default(), Ranges::default());
        for ((array, indices), word) in self.elements {
            match word.known {
                ElementKnowledge::Free => {}
                ElementKnowledge::Bound(number) => bound.set(&array, indices, number),
                ElementKnowledge::Range(low, high) => ranges.set(&array, indices, low, high),
            }
        }
        (bound, ranges)
    }
}

fn name(array: &str, indices: [u32; 2]) -> String {
    let present = indices.iter().take_while(|&&index| index > 0).count();
    robovec_dynamics::kinematics::element_name(array, &indices[..present])
}
