//! Names of values: Robotran's own, and derived ones for array elements that
//! are read back and for temporaries of loops.

use hashbrown::HashMap;
use robovec_ir::{Name, Symbol, Symbols};
use rustc_hash::FxBuildHasher;
use std::fmt::Write;

/// The names given so far in a function.
///
/// Invariant: the plain name of a symbol of the file is kept for its scalar.
#[derive(Debug)]
pub(super) struct GivenNames {
    /// Per symbol of the file: the next free number.
    next: Vec<u32>,
    /// Per symbol of the file: true when a scalar has it.
    defined: Vec<bool>,
    /// The same for symbols made later, which only elements bear.
    later: HashMap<Symbol, u32, FxBuildHasher>,
    buffer: String,
}

impl GivenNames {
    /// No names; `known` symbols occur in the file.
    pub(super) fn new(known: usize) -> GivenNames {
        GivenNames {
            next: vec![1; known],
            defined: vec![false; known],
            later: HashMap::default(),
            buffer: String::new(),
        }
    }

    /// True when the scalar is defined.
    pub(super) fn is_defined(&self, symbol: Symbol) -> bool {
        self.defined
            .get(symbol.index())
            .is_some_and(|&defined| defined)
    }

    /// Name of the next definition of a scalar: the symbol, then derived ones.
    pub(super) fn scalar(&mut self, symbol: Symbol) -> Name {
        match self.defined.get_mut(symbol.index()) {
            Some(defined) if !*defined => {
                *defined = true;
                Name::plain(symbol)
            }
            Some(_) | None => self.derived(symbol),
        }
    }

    fn derived(&mut self, base: Symbol) -> Name {
        let next = match self.next.get_mut(base.index()) {
            Some(next) => next,
            None => self.later.entry(base).or_insert(0),
        };
        let suffix = *next;
        *next += 1;
        Name { base, suffix }
    }

    /// A name for a value of an array element: `frc_1_6`, `sens_P_2`.
    pub(super) fn element(
        &mut self,
        symbols: &mut Symbols,
        array: Symbol,
        indices: &[u32],
    ) -> Name {
        self.buffer.clear();
        for character in symbols.text(array).chars() {
            self.buffer
                .push(if character == '.' { '_' } else { character });
        }
        for index in indices {
            // Writing to a string cannot fail.
            let _ = write!(self.buffer, "_{index}");
        }
        self.derived(symbols.intern(&self.buffer))
    }
}
