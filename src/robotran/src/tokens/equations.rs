//! Plain equations, read by the precedence of their operators.
//!
//! Nearly all of a file are equations of names, elements and numbers, sums,
//! products, minuses, parentheses and functions of one number. These are read
//! here, with two stacks and one branch per lexeme, in a fraction of the time
//! that the tables of the grammar need. All other statements are left to the
//! grammar, from their start: it alone defines the language and its messages.
//!
//! **Invariant.** This code reads equations exactly as `grammar.lalrpop` does:
//! the same calls of the builder in the same order.

use super::TokenStream;
use super::words::starts_as_keyword;
use crate::Language;
use crate::raw::{Raw, Surface};
use crate::syntax::{SyntaxBuilder, SyntaxLeaf};
use crate::token::LexicalError;
use crate::token::{RobotranToken, SourceSpan};
use robovec_ir::Operation;

/// An operator whose right operand is being read, or an open parenthesis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum OpenOperator {
    /// An operation on two operands.
    Binary(Operation),
    /// A minus before a whole product.
    NegatedProduct,
    /// A minus before a factor after `*` or `/`.
    NegatedFactor,
    /// A parenthesis.
    Group,
    /// A function with its parenthesis.
    Function(Operation),
}

impl OpenOperator {
    /// Binding strength of its right operand; a parenthesis ends it.
    fn strength(self) -> u8 {
        match self {
            OpenOperator::Group | OpenOperator::Function(_) => 0,
            OpenOperator::Binary(Operation::Add | Operation::Sub) => 1,
            OpenOperator::NegatedProduct => 2,
            OpenOperator::Binary(_) => 3,
            OpenOperator::NegatedFactor => 4,
        }
    }
}

/// Operands and operators of the expression being read, allocated once.
#[derive(Default, Debug)]
pub(crate) struct ExpressionStacks {
    operands: Vec<SyntaxLeaf>,
    operators: Vec<OpenOperator>,
}

/// The statement is no plain equation, or a wrong one.
struct NotPlain;

impl From<LexicalError> for NotPlain {
    fn from(_: LexicalError) -> NotPlain {
        NotPlain
    }
}

impl ExpressionStacks {
    /// Applies the pending operators that bind more tightly than this one.
    fn apply(&mut self, builder: &mut SyntaxBuilder, strength: u8) -> Result<(), NotPlain> {
        // Places matter in messages only, and these are the grammar's.
        const PLACE: u32 = 0;
        while let Some(&operator) = self.operators.last()
            && operator.strength() >= strength
        {
            self.operators.pop();
            let right = self.operands.pop().ok_or(NotPlain)?;
            let result = match operator {
                OpenOperator::Binary(operation) => {
                    let left = self.operands.pop().ok_or(NotPlain)?;
                    builder.node(operation, (PLACE, left), (right, PLACE))
                }
                OpenOperator::NegatedProduct | OpenOperator::NegatedFactor => {
                    builder.negated(PLACE, right, PLACE)
                }
                OpenOperator::Group | OpenOperator::Function(_) => return Err(NotPlain),
            };
            self.operands.push(result.map_err(|_| NotPlain)?);
        }
        Ok(())
    }

    /// Takes in an operator after an operand.
    fn binary(
        &mut self,
        operation: Operation,
        builder: &mut SyntaxBuilder,
    ) -> Result<(), NotPlain> {
        let operator = OpenOperator::Binary(operation);
        self.apply(builder, operator.strength())?;
        self.operators.push(operator);
        Ok(())
    }

    /// Takes in a minus before an operand.
    fn minus(&mut self) {
        let behind_factor = OpenOperator::Binary(Operation::Mul).strength();
        let before = self.operators.last().map_or(0, |last| last.strength());
        self.operators.push(if before >= behind_factor {
            OpenOperator::NegatedFactor
        } else {
            OpenOperator::NegatedProduct
        });
    }

    /// True within a parenthesis.
    fn are_open(&self) -> bool {
        let mut operators = self.operators.iter();
        operators.any(|operator| operator.strength() == 0)
    }

    /// The last operand left.
    fn root(&mut self, builder: &mut SyntaxBuilder) -> Result<SyntaxLeaf, NotPlain> {
        self.apply(builder, 1)?;
        match (self.operands.pop(), self.operators.is_empty()) {
            (Some(root), true) => {
                debug_assert!(self.operands.is_empty(), "every operator took its operands");
                Ok(root)
            }
            _ => Err(NotPlain),
        }
    }

    /// Closes the innermost parenthesis.
    fn close(&mut self, builder: &mut SyntaxBuilder) -> Result<(), NotPlain> {
        self.apply(builder, 1)?;
        let opened = self.operators.pop().ok_or(NotPlain)?;
        let inner = self.operands.pop().ok_or(NotPlain)?;
        self.operands.push(match opened {
            OpenOperator::Function(function) => builder.apply(function, inner),
            _ => builder.grouped(inner),
        });
        Ok(())
    }
}

impl<'s, L: Surface<'s>> TokenStream<'s, '_, L> {
    /// Reads the next statement if it is a plain equation, else nothing.
    pub(crate) fn plain_equation(
        &mut self,
        builder: &mut SyntaxBuilder,
        stacks: &mut ExpressionStacks,
    ) -> bool {
        let begins = matches!(self.recent[0], None | Some((_, RobotranToken::End, _)));
        let plain = self.preprocessor.is_empty() && !self.preprocessor.skips();
        if !begins || !plain || !self.open.is_empty() || !self.pending.is_empty() {
            return false;
        }
        let (lexer, recent) = (self.lexer.clone(), self.recent);
        if self.equation(builder, stacks).is_ok() {
            return true;
        }
        (self.lexer, self.recent) = (lexer, recent);
        self.pending.clear();
        builder.abandon_statement();
        false
    }

    fn equation(
        &mut self,
        builder: &mut SyntaxBuilder,
        stacks: &mut ExpressionStacks,
    ) -> Result<(), NotPlain> {
        stacks.operands.clear();
        stacks.operators.clear();
        let mut raw = self.lexeme()?;
        while raw == Raw::LineEnd {
            raw = self.lexeme()?;
        }
        let start = self.span().start;
        let target = match self.name(raw) {
            Some(name) => name,
            None => match self.leaf(raw)? {
                RobotranToken::Name(name) => SyntaxLeaf::scalar(name),
                RobotranToken::Element(element) => builder.element(element),
                _ => return Err(NotPlain),
            },
        };
        if self.lexeme()? != Raw::Equals {
            return Err(NotPlain);
        }
        let root_end = self.right_side(builder, stacks)?;
        let root = stacks.root(builder)?;
        // A line end has no width, and no statement includes it.
        let SourceSpan { start: at, end } = self.span();
        let (last, end) = match self.lexer.slice() {
            ";" => (end, end),
            _ => (root_end, at),
        };
        builder.equation(start, target, root, last);
        self.recent = [Some((at, RobotranToken::End, end)), None];
        Ok(())
    }

    /// Reads an expression onto the stacks; returns where its last lexeme ends.
    fn right_side(
        &mut self,
        builder: &mut SyntaxBuilder,
        stacks: &mut ExpressionStacks,
    ) -> Result<u32, NotPlain> {
        // Where the next operand stands directly behind a parenthesis.
        let mut opened = false;
        loop {
            let raw = self.lexeme_within(stacks)?;
            if let Some(name) = self.name(raw) {
                opened = false;
                stacks.operands.push(name);
                if let Some(end) = self.operator(builder, stacks)? {
                    return Ok(end);
                }
                continue;
            }
            let token = match raw {
                Raw::Open => {
                    stacks.operators.push(OpenOperator::Group);
                    opened = true;
                    continue;
                }
                Raw::Minus if opened => self.minus_behind_parenthesis()?,
                Raw::Minus => RobotranToken::Minus,
                _ => self.leaf(raw)?,
            };
            opened = false;
            match token {
                RobotranToken::Minus => {
                    stacks.minus();
                    continue;
                }
                RobotranToken::Function(function) => {
                    if self.lexeme_within(stacks)? != Raw::Open {
                        return Err(NotPlain);
                    }
                    stacks.operators.push(OpenOperator::Function(function));
                    opened = true;
                    continue;
                }
                RobotranToken::Name(name) => stacks.operands.push(SyntaxLeaf::scalar(name)),
                RobotranToken::Element(element) => stacks.operands.push(builder.element(element)),
                RobotranToken::Number(number) => stacks.operands.push(builder.number(number)),
                _ => return Err(NotPlain),
            }
            if let Some(end) = self.operator(builder, stacks)? {
                return Ok(end);
            }
        }
    }

    /// Reads the part after an operand: closing parentheses and an operator, or
    /// the statement's end; then returns the end of the previous lexeme.
    fn operator(
        &mut self,
        builder: &mut SyntaxBuilder,
        stacks: &mut ExpressionStacks,
    ) -> Result<Option<u32>, NotPlain> {
        loop {
            let before = self.span().end;
            let operation = match self.lexeme_within(stacks)? {
                Raw::Plus => Operation::Add,
                Raw::Minus => Operation::Sub,
                Raw::Star => Operation::Mul,
                Raw::Slash => Operation::Div,
                Raw::Close => {
                    stacks.close(builder)?;
                    continue;
                }
                Raw::Semicolon | Raw::LineEnd => return Ok(Some(before)),
                _ => return Err(NotPlain),
            };
            stacks.binary(operation, builder)?;
            return Ok(None);
        }
    }

    #[inline]
    fn lexeme(&mut self) -> Result<Raw, NotPlain> {
        match self.lexer.next() {
            Some(Ok(lexeme)) => Ok(lexeme.raw()),
            Some(Err(())) | None => Err(NotPlain),
        }
    }

    /// The next lexeme; Python's lines end only where parentheses are closed.
    #[inline]
    fn lexeme_within(&mut self, stacks: &ExpressionStacks) -> Result<Raw, NotPlain> {
        let mut raw = self.lexeme()?;
        while raw == Raw::LineEnd && self.language == Language::Python && stacks.are_open() {
            raw = self.lexeme()?;
        }
        Ok(raw)
    }

    /// The operand of a lexeme that can only be a name, without a token.
    #[inline]
    fn name(&mut self, raw: Raw) -> Option<SyntaxLeaf> {
        let word = self.lexer.slice();
        let is_name = raw == Raw::Word && !starts_as_keyword(word);
        is_name.then(|| SyntaxLeaf::scalar(self.local_name(word)))
    }

    /// The token of a lexeme that may be an operand.
    #[inline]
    fn leaf(&mut self, raw: Raw) -> Result<RobotranToken, NotPlain> {
        Ok(match raw {
            Raw::Word => self.plain_word(self.lexer.slice())?.ok_or(NotPlain)?,
            Raw::Element | Raw::MemberElement => self.element(raw)?,
            Raw::Member => self.member(self.lexer.slice())?,
            Raw::Number | Raw::Numeral => RobotranToken::Number(self.number()?),
            _ => return Err(NotPlain),
        })
    }

    /// A minus after a parenthesis, which may be the sign of a number.
    fn minus_behind_parenthesis(&mut self) -> Result<RobotranToken, NotPlain> {
        self.recent[0] = Some((0, RobotranToken::Open, 0));
        Ok(self.minus()?)
    }
}

#[cfg(test)]
mod tests {
    use crate::explain::explain;
    use crate::raw::{C, Matlab, Python, Surface};
    use crate::syntax::SyntaxBuilder;
    use crate::tokens::{TokenSource, TokenStream};
    use crate::{ERROR_LIMIT, Language, grammar, parse_tokens};
    use robovec_ir::Symbols;
    use robovec_num::random::Random;

    /// Result of the grammar alone for a text: the tree and the errors.
    fn by_grammar<'s, L: Surface<'s>>(text: &'s str, language: Language) -> String {
        let (mut symbols, mut builder) = (Symbols::default(), SyntaxBuilder::default());
        let mut tokens = TokenStream::<L>::new(text, language, &mut symbols);
        let parser = grammar::FileParser::new();
        let mut errors = Vec::new();
        while let Err(error) = parser.parse(&mut builder, &mut tokens) {
            let [last, before] = tokens.recent();
            let at_end = matches!(error, lalrpop_util::ParseError::UnrecognizedEof { .. });
            errors.push(explain(error, if at_end { last } else { before }, text));
            builder.abandon_statement();
            if at_end || errors.len() >= ERROR_LIMIT {
                break;
            }
            tokens.skip_statement();
        }
        told(&builder, &symbols, &errors)
    }

    /// The same by way of plain equations.
    fn by_both<'s, L: Surface<'s>>(text: &'s str, language: Language) -> String {
        let (mut symbols, mut builder) = (Symbols::default(), SyntaxBuilder::default());
        let errors = parse_tokens::<L>(text, language, &mut symbols, &mut builder);
        told(&builder, &symbols, &errors)
    }

    /// After an error only messages are of use.
    fn told(
        builder: &SyntaxBuilder,
        symbols: &Symbols,
        errors: &[robovec_ir::diagnostic::Diagnostic],
    ) -> String {
        if errors.is_empty() {
            format!("{:#?}\n{:?}", builder.syntax, symbols)
        } else {
            format!("{errors:#?}")
        }
    }

    fn expression(random: &mut Random, leaves: &[&str], depth: u32) -> String {
        let inner = |random: &mut Random| expression(random, leaves, depth - 1);
        match random.below(if depth == 0 { 1 } else { 8 }) {
            0 | 1 => leaves[random.below(leaves.len())].to_owned(),
            2 => format!("({})", inner(random)),
            3 => format!("-{}", inner(random)),
            4 => format!("sin({})", inner(random)),
            _ => {
                let operator = ["+", "-", "*", "/", "*-", "+ -"][random.below(6)];
                format!("{}{operator}{}", inner(random), inner(random))
            }
        }
    }

    /// A few statements, some of them with a lexeme too many.
    fn text(random: &mut Random, leaves: &[&str], ends: &[&str]) -> String {
        let spoilers = [
            "", "", "", "", "+", "(", ")", "=", "a = ", ",", "f(a)", "%", "\n",
        ];
        (0..1 + random.below(4))
            .map(|_| {
                let mut statement = format!(
                    "{} = {}",
                    leaves[random.below(4)],
                    expression(random, leaves, 4)
                );
                let at = random.below(statement.len() + 1);
                statement.insert_str(at, spoilers[random.below(spoilers.len())]);
                statement + ends[random.below(ends.len())]
            })
            .collect()
    }

    #[test]
    fn plain_equations_are_read_as_the_grammar_reads_them() {
        let c = [
            "x", "M[1][2]", "s->q[3]", "y", "0.5", "2", "x7", "s->tsim", "010", "0.1f",
        ];
        let matlab = [
            "x", "M(1,2)", "s.q(3)", "y", "0.5", "2", "sin(2)", "s.tsim", "1e3",
        ];
        let python = [
            "x",
            "M[1,2]",
            "s.q[3]",
            "y",
            "0.5",
            "2",
            "np.sin(x)",
            "s.tsim",
            "1e3",
        ];
        let mut random = Random::new(40);
        for _ in 0..3000 {
            let given = text(&mut random, &c, &[";", ";\n", " ; // x\n", "\n"]);
            let read = by_both::<C>(&given, Language::C);
            assert_eq!(read, by_grammar::<C>(&given, Language::C), "{given}");
            let given = text(&mut random, &matlab, &[";\n", "\n", " % x\n", ";"]);
            let read = by_both::<Matlab>(&given, Language::Matlab);
            assert_eq!(
                read,
                by_grammar::<Matlab>(&given, Language::Matlab),
                "{given}"
            );
            let given = text(&mut random, &python, &["\n", "\n", " # x\n", ";"]);
            let read = by_both::<Python>(&given, Language::Python);
            assert_eq!(
                read,
                by_grammar::<Python>(&given, Language::Python),
                "{given}"
            );
        }
    }
}
