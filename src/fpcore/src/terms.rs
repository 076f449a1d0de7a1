//! Expressions on their way into a function.
//!
//! In the text a binding may be inside an expression; in a function definitions
//! come before their readers. So expressions are kept here until the core is
//! read, and bound ones become definitions in their order.

use robovec_ir::parenthesised::Forest;
use robovec_ir::{
    FreshNames, Function, Input, Name, Node, Operand, Operation, Output, SourceSet, Symbol, Tables,
};
use robovec_robotran::{LineIndex, SourceSpan};

/// An expression.
#[derive(Clone, Copy, Debug)]
pub(super) enum Term {
    /// An argument.
    Input(u32),
    Number(f64),
    /// An operation on earlier terms.
    Node {
        operation: Operation,
        operands: [u32; 3],
    },
}

/// A term that a variable represents.
#[derive(Clone, Copy, Debug)]
struct BoundTerm {
    term: u32,
    name: Symbol,
    /// The tree of its expression.
    tree: u32,
}

#[derive(Default, Debug)]
pub(super) struct Terms {
    terms: Vec<Term>,
    /// True for the terms that a variable represents.
    named: Vec<bool>,
    /// The operand of a defined term, once it is made.
    defined: Vec<Operand>,
    definitions: Vec<BoundTerm>,
}

impl Terms {
    pub(super) fn push(&mut self, term: Term) -> u32 {
        debug_assert!(
            !matches!(term, Term::Node { operation, operands }
                if operands[..operation.arity()].iter().any(|&term| term as usize >= self.terms.len())),
            "operands are earlier terms"
        );
        self.terms.push(term);
        self.named.push(false);
        self.defined.push(Operand::NONE);
        self.terms.len() as u32 - 1
    }

    /// Makes an unread term the value of a variable, if it has no name.
    pub(super) fn define(&mut self, term: u32, name: Symbol, tree: u32) {
        let is_node = matches!(self.terms[term as usize], Term::Node { .. });
        let named = std::mem::replace(&mut self.named[term as usize], true);
        if is_node && !named {
            self.definitions.push(BoundTerm { term, name, tree });
        }
    }

    /// Writes definitions and result into a function with inputs and output.
    pub(super) fn emit(
        mut self,
        (result, body): (u32, u32),
        forest: &Forest<'_>,
        tables: &mut Tables,
        places: &mut LineIndex<'_>,
        function: &mut Function,
    ) {
        let mut names = FreshNames::new(std::iter::empty());
        let mut place = |tree: u32, tables: &mut Tables| {
            let span = forest.get(tree).span.clone();
            let place = places.place(SourceSpan::new(span.start, span.end));
            tables.sources.single(place)
        };
        // A term reads only earlier ones.
        let mut definitions = std::mem::take(&mut self.definitions);
        definitions.sort_unstable_by_key(|definition| definition.term);
        for definition in definitions {
            let sources = place(definition.tree, tables);
            let name = names.fresh(definition.name);
            let operand = self.tree(definition.term, name, sources, function);
            self.defined[definition.term as usize] = operand;
        }
        let sources = place(body, tables);
        let operand = match self.defined[result as usize] {
            Operand::NONE => self.tree(result, Name::NONE, sources, function),
            defined => defined,
        };
        function.assign(Output(0), operand, sources);
    }

    /// Writes the operations of a term, the last one under a name.
    fn tree(&self, root: u32, name: Name, sources: SourceSet, function: &mut Function) -> Operand {
        // Terms with the number of operands that are made.
        let mut open: Vec<(u32, usize)> = vec![(root, 0)];
        let mut made: Vec<Operand> = Vec::new();
        while let Some((term, done)) = open.pop() {
            match self.terms[term as usize] {
                _ if !self.defined[term as usize].is_none() => {
                    made.push(self.defined[term as usize]);
                }
                Term::Input(input) => made.push(Input(input).into()),
                Term::Number(number) => made.push(function.constant(number).into()),
                Term::Node {
                    operation,
                    operands,
                } if done < operation.arity() => {
                    open.push((term, done + 1));
                    open.push((operands[done], 0));
                }
                Term::Node { operation, .. } => {
                    let mut operands = [Operand::NONE; 3];
                    let first = made.len() - operation.arity();
                    for (place, operand) in operands.iter_mut().zip(made.drain(first..)) {
                        *place = operand;
                    }
                    let name = if term == root { name } else { Name::NONE };
                    let node = Node {
                        name,
                        sources,
                        operands,
                        operation,
                    };
                    made.push(function.push(node).into());
                }
            }
        }
        let root = made.pop().expect("the root is made last");
        assert!(made.is_empty(), "every other operand has a user");
        root
    }
}
