//! The known form of a value: a number, an operand, or a sum of operands times
//! numbers that is not computed yet.

use super::constants::{Known, KnownNumbers};
use robovec_ir::{Name, Operand, Operation, SourceSet};
use smallvec::SmallVec;

/// The translation of an old value.
#[derive(Clone, Debug)]
pub(super) enum Reading {
    /// A number.
    Known(Known),
    /// An input, or a value that is computed.
    Operand(Operand),
    /// A form, computed when it is needed.
    Form(Box<LinearForm>),
}

impl Reading {
    /// True when an operation on it is to be thought about.
    pub(super) fn is_touched(&self) -> bool {
        !matches!(self, Reading::Operand(_))
    }
}

/// A number plus operands times numbers.
#[derive(Clone, Debug)]
pub(super) struct LinearForm {
    /// In order of appearance; no operand twice, no factor zero.
    pub(super) terms: SmallVec<[ScaledOperand; 2]>,
    pub(super) constant: Known,
    /// Its equations.
    pub(super) sources: SourceSet,
    /// The name of the value it represents.
    pub(super) name: Name,
}

/// An operand times a number.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScaledOperand {
    pub(super) factor: Known,
    pub(super) operand: Operand,
}

/// The maximum number of terms of a deferred form: a longer one is computed, so
/// that no chain costs more than its length times this.
pub(super) const MAX_TERMS: usize = 32;

impl LinearForm {
    /// A number, as a form.
    pub(super) fn number(constant: Known) -> LinearForm {
        LinearForm {
            terms: SmallVec::new(),
            constant,
            sources: SourceSet::EMPTY,
            name: Name::NONE,
        }
    }

    /// An operand times a number, as a form.
    pub(super) fn term(factor: Known, operand: Operand) -> LinearForm {
        let mut form = LinearForm::number(Known::ZERO);
        if factor != Known::ZERO {
            form.terms.push(ScaledOperand { factor, operand });
        }
        form
    }

    /// The number it is, when no operand is left.
    pub(super) fn as_number(&self) -> Option<Known> {
        self.terms.is_empty().then_some(self.constant)
    }

    /// The operand, if the form has no other part.
    pub(super) fn as_operand(&self) -> Option<Operand> {
        match self.terms.as_slice() {
            [term] if term.factor == Known::ONE && self.constant == Known::ZERO => {
                Some(term.operand)
            }
            _ => None,
        }
    }

    /// Adds another form, or subtracts it; `None` when a number overflows.
    pub(super) fn plus(
        mut self,
        other: &LinearForm,
        operation: Operation,
        constants: &mut KnownNumbers,
    ) -> Option<LinearForm> {
        self.constant = constants.apply(operation, [self.constant, other.constant])?;
        for term in &other.terms {
            let found = self
                .terms
                .iter()
                .position(|own| own.operand == term.operand);
            let Some(place) = found else {
                let factor = match operation {
                    Operation::Sub => constants.negative(term.factor),
                    _ => term.factor,
                };
                self.terms.push(ScaledOperand { factor, ..*term });
                continue;
            };
            let factors = [self.terms[place].factor, term.factor];
            self.terms[place].factor = constants.apply(operation, factors)?;
            if self.terms[place].factor == Known::ZERO {
                self.terms.remove(place);
            }
        }
        Some(self)
    }

    /// Multiplies by a number; `None` when a number overflows.
    pub(super) fn times(
        mut self,
        factor: Known,
        constants: &mut KnownNumbers,
    ) -> Option<LinearForm> {
        if factor == Known::ZERO {
            self.terms.clear();
        }
        self.constant = constants.apply(Operation::Mul, [self.constant, factor])?;
        for term in &mut self.terms {
            term.factor = constants.apply(Operation::Mul, [term.factor, factor])?;
        }
        Some(self)
    }
}
