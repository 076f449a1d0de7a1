//! One rule of rewriting.

use super::pattern::Pattern;
use robovec_analysis::class::NumericClass;
use std::ops::Range;

robovec_num::named! {
    /// A condition on the value that a variable represents.
    ///
    /// A pass may use the rule only where it *knows* that the condition holds:
    /// of a number in the equations it does, of a state it does not.
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
    pub enum Requirement {
        /// `constant(a)`: a number written in the equations.
        Constant = "constant",
        /// `nonzero(a)`: not zero.
        Nonzero = "nonzero",
        /// `positive(a)`: above zero.
        Positive = "positive",
    }
}

impl Requirement {
    /// True when a number meets the requirement.
    pub fn holds_for(self, number: f64) -> bool {
        match self {
            Requirement::Constant => true,
            Requirement::Nonzero => number != 0.0,
            Requirement::Positive => number > 0.0,
        }
    }
}

/// A condition of a rule: a requirement on one of its variables.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Condition {
    /// The requirement.
    pub requirement: Requirement,
    /// Of which variable, by its number.
    pub variable: u32,
}

/// The places of the parts of a rule in its file, in bytes.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct RulePlaces {
    /// The number of the file in [`RuleSet::files`](super::RuleSet::files).
    pub file: usize,
    /// The name.
    pub name: Range<usize>,
    /// The left side.
    pub left: Range<usize>,
    /// The right side.
    pub right: Range<usize>,
    /// The class, or the name when no class is written.
    pub class: Range<usize>,
}

/// A rule: a term that matches the left side may be replaced by the right side.
#[derive(Clone, PartialEq, Debug)]
pub struct Rule {
    /// The name, unique in its set.
    pub name: String,
    /// The file it comes from, without folder and ending: `distribution`.
    pub group: String,
    /// The names of the variables of both sides, by number.
    pub variables: Vec<String>,
    /// The pattern that is looked for.
    pub left: Pattern,
    /// The pattern that may take its place. Its variables occur on the left
    /// side.
    pub right: Pattern,
    /// True for a rule written with `<=>`: the sides may also be exchanged.
    pub both_ways: bool,
    /// All must hold where the rule is used.
    pub conditions: Vec<Condition>,
    /// The numeric class, as the author of the rule declares it.
    pub class: NumericClass,
    /// The reason for the rule, in one line; may be empty.
    pub reason: String,
    /// Its places in the text.
    pub places: RulePlaces,
}

impl Rule {
    /// A rule of class real without a name, conditions or places.
    pub fn new(variables: Vec<String>, left: Pattern, right: Pattern) -> Rule {
        Rule {
            name: String::new(),
            group: String::new(),
            variables,
            left,
            right,
            both_ways: false,
            conditions: Vec::new(),
            class: NumericClass::Real,
            reason: String::new(),
            places: RulePlaces::default(),
        }
    }

    /// The rule and, if it has two directions, its reverse as a separate rule,
    /// whose name ends in `.back`. Each of the two has one direction.
    pub fn directed(&self) -> Vec<Rule> {
        let forward = Rule {
            both_ways: false,
            ..self.clone()
        };
        if !self.both_ways {
            return vec![forward];
        }
        let mut back = forward.clone();
        back.name = format!("{}.back", self.name);
        std::mem::swap(&mut back.left, &mut back.right);
        std::mem::swap(&mut back.places.left, &mut back.places.right);
        vec![forward, back]
    }

    /// The requirements on a variable.
    pub fn requirements(&self, variable: u32) -> impl Iterator<Item = Requirement> + '_ {
        let here = move |condition: &&Condition| condition.variable == variable;
        let conditions = self.conditions.iter().filter(here);
        conditions.map(|condition| condition.requirement)
    }
}
