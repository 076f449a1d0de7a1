//! Reading one side of a rule: operators by precedence, with stacks of our
//! own, so that no nesting is too deep.

use super::cursor::{Cursor, Told};
use super::pattern::{Pattern, PatternNode};
use super::token::Token;
use robovec_ir::Operation;
use robovec_ir::diagnostic::{clip, did_you_mean};
use std::ops::Range;

/// Words that cannot be variables.
pub(super) const RESERVED: [&str; 3] = ["rule", "when", "class"];

/// The operations written as calls.
const CALLS: [(&str, Operation); 4] = [
    ("neg", Operation::Neg),
    ("sin", Operation::Sin),
    ("cos", Operation::Cos),
    ("sqrt", Operation::Sqrt),
];

/// What was read of one side.
#[derive(Default)]
pub(super) struct Side {
    pub(super) pattern: Pattern,
    pub(super) span: Range<usize>,
    /// Where each variable stands, in order of reading.
    pub(super) occurrences: Vec<(u32, Range<usize>)>,
}

/// An operator that waits for its last operand, or an open parenthesis.
enum Pending {
    Open(Range<usize>),
    Call(Operation, Range<usize>),
    Negate,
    Binary(Operation),
}

impl Pending {
    /// How strongly it binds; parentheses hold everything back.
    fn precedence(&self) -> u32 {
        match self {
            Pending::Open(_) | Pending::Call(..) => 0,
            Pending::Binary(operation) => precedence(*operation),
            Pending::Negate => 3,
        }
    }
}

pub(super) fn precedence(operation: Operation) -> u32 {
    match operation {
        Operation::Add | Operation::Sub => 1,
        _ => 2,
    }
}

/// Reads a term up to the first token that cannot continue it.
pub(super) fn expression(
    cursor: &mut Cursor<'_>,
    variables: &mut Vec<String>,
) -> Result<Side, Told> {
    let start = cursor.span().start;
    let mut reader = Reader {
        cursor,
        variables,
        side: Side::default(),
        operands: Vec::new(),
        pending: Vec::new(),
    };
    loop {
        reader.operand()?;
        if !reader.operator()? {
            break;
        }
    }
    reader.finish()?;
    let mut side = reader.side;
    side.span = start..cursor.end();
    Ok(side)
}

struct Reader<'a, 'text> {
    cursor: &'a mut Cursor<'text>,
    variables: &'a mut Vec<String>,
    side: Side,
    operands: Vec<u32>,
    pending: Vec<Pending>,
}

impl Reader<'_, '_> {
    /// Reads prefixes and one number or variable.
    fn operand(&mut self) -> Result<(), Told> {
        loop {
            let span = self.cursor.span();
            match self.cursor.peek() {
                Some(Token::Open) => self.pending.push(Pending::Open(span)),
                Some(Token::Minus) => {
                    if let Some(Token::Number(_)) = self.cursor.peek_at(1) {
                        self.cursor.advance();
                        return self.number(-1.0);
                    }
                    self.pending.push(Pending::Negate);
                }
                Some(Token::Number(_)) => return self.number(1.0),
                Some(Token::Word(word)) if self.cursor.peek_at(1) == Some(Token::Open) => {
                    let operation = self.called(word, span.clone())?;
                    self.cursor.advance();
                    self.pending.push(Pending::Call(operation, span));
                }
                Some(Token::Word(word)) => return self.variable(word, span),
                _ => return Err(self.cursor.unexpected("a number, a variable or '('")),
            }
            self.cursor.advance();
        }
    }

    fn called(&mut self, word: &str, span: Range<usize>) -> Result<Operation, Told> {
        if let Some((_, operation)) = CALLS.iter().find(|(name, _)| *name == word) {
            return Ok(*operation);
        }
        let mut notes: Vec<String> = did_you_mean(word, CALLS.map(|(name, _)| name))
            .map(|near| format!("did you mean '{near}'?"))
            .into_iter()
            .collect();
        let names = CALLS.map(|(name, _)| name).join(", ");
        notes.push(format!("operations: +, -, *, /, {names}"));
        let message = format!("there is no operation '{}'", clip(word));
        Err(self.cursor.advise(span, message, notes))
    }

    fn number(&mut self, sign: f64) -> Result<(), Told> {
        let span = self.cursor.span();
        let text = &self.cursor.text[span.clone()];
        let number = match text.parse::<f64>() {
            Ok(number) if number.is_finite() => sign * number,
            Ok(_) | Err(_) => {
                let message = format!("the number {} is too large", clip(text));
                return Err(self.cursor.error(span, message));
            }
        };
        self.cursor.advance();
        // One zero is enough: over the reals they are the same.
        self.push(PatternNode::Number(number + 0.0), span)
    }

    fn variable(&mut self, word: &str, span: Range<usize>) -> Result<(), Told> {
        if CALLS.iter().any(|(name, _)| *name == word) {
            let message = format!("'{word}' needs its operand in parentheses: {word}(a)");
            return Err(self.cursor.error(span, message));
        }
        if RESERVED.contains(&word) {
            return Err(self.cursor.unexpected("a number, a variable or '('"));
        }
        let known = self.variables.iter().position(|name| name == word);
        let variable = known.unwrap_or_else(|| {
            self.variables.push(word.to_owned());
            self.variables.len() - 1
        });
        self.cursor.advance();
        self.side.occurrences.push((variable as u32, span.clone()));
        self.push(PatternNode::Variable(variable as u32), span)
    }

    fn push(&mut self, node: PatternNode, span: Range<usize>) -> Result<(), Told> {
        if self.side.pattern.nodes.len() >= Pattern::LARGEST {
            let most = Pattern::LARGEST;
            let message = format!("a side of a rule has at most {most} operations and values");
            return Err(self.cursor.error(span, message));
        }
        let index = self.side.pattern.push(node);
        self.operands.push(index);
        Ok(())
    }

    /// Reads closing parentheses and one operator; false when the term ends.
    fn operator(&mut self) -> Result<bool, Told> {
        loop {
            let operation = match self.cursor.peek() {
                Some(Token::Plus) => Operation::Add,
                Some(Token::Minus) => Operation::Sub,
                Some(Token::Times) => Operation::Mul,
                Some(Token::Over) => Operation::Div,
                Some(Token::Close) => {
                    self.close()?;
                    continue;
                }
                _ => return Ok(false),
            };
            self.cursor.advance();
            self.reduce(precedence(operation))?;
            self.pending.push(Pending::Binary(operation));
            return Ok(true);
        }
    }

    fn close(&mut self) -> Result<(), Told> {
        self.reduce(1)?;
        let span = self.cursor.span();
        match self.pending.pop() {
            Some(Pending::Open(_)) => {}
            Some(Pending::Call(operation, _)) => self.apply(operation)?,
            _ => return Err(self.cursor.error(span, "no '(' is open here")),
        }
        self.cursor.advance();
        Ok(())
    }

    /// Carries out what binds at least as strongly as `least`.
    fn reduce(&mut self, least: u32) -> Result<(), Told> {
        while let Some(top) = self.pending.last()
            && top.precedence() >= least
        {
            let operation = match self.pending.pop() {
                Some(Pending::Binary(operation)) => operation,
                _ => Operation::Neg,
            };
            self.apply(operation)?;
        }
        Ok(())
    }

    fn apply(&mut self, operation: Operation) -> Result<(), Told> {
        let from = self.operands.len() - operation.arity();
        let operands = self.operands.split_off(from);
        let second = operands.get(1).copied().unwrap_or(operands[0]);
        let node = PatternNode::Operation(operation, [operands[0], second]);
        let end = self.cursor.end();
        self.push(node, end.saturating_sub(1)..end)
    }

    fn finish(&mut self) -> Result<(), Told> {
        self.reduce(1)?;
        match self.pending.last() {
            Some(Pending::Open(span) | Pending::Call(_, span)) => {
                let span = span.clone();
                Err(self.cursor.error(span, "this parenthesis is not closed"))
            }
            _ => Ok(()),
        }
    }
}
