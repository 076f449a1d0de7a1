//! The text of superwords: vectors of gcc and clang.

use super::Real;
use super::text::{PartBody, PlainWriter};
use crate::emit::expression::{BoundText, Operands, apply};
use robovec_ir::{Operand, Operation, Value};
use std::fmt::Write;

/// The type of a vector, once in a file.
pub(super) fn types(width: usize, real: Real) -> String {
    let name = type_name(width, real);
    let upper = name.to_ascii_uppercase();
    let size = match real {
        Real::Double => 8 * width,
        Real::Float => 4 * width,
    };
    let real = real.name();
    format!(
        "\n#if !defined({upper})\n#define {upper}\n\
         #if !defined(__GNUC__)\n\
         #error \"superwords are vectors of gcc and clang: write this file with superwords=none\"\n\
         #endif\n\
         typedef {real} {name} __attribute__((vector_size({size})));\n#endif\n"
    )
}

/// The name of the type of a vector.
fn type_name(width: usize, real: Real) -> String {
    let first = &real.name()[..1];
    format!("robovec_{first}{width}_word")
}

impl PlainWriter<'_> {
    /// The type of a superword.
    pub(super) fn vector(&self) -> String {
        type_name(self.plan.superwords.width(), self.real)
    }

    /// Computes a superword, whose first lane is `leader`.
    pub(super) fn define_word(
        &self,
        body: &mut PartBody,
        number: usize,
        word: usize,
        leader: Value,
    ) {
        let own = &self.plan.superwords.words()[word];
        let texts = own.operands.iter();
        let texts: Vec<BoundText> = texts
            .map(|operands| self.lanes(body, number, operands))
            .collect();
        let operation = own.operation.expect("this superword computes");
        let all = u8::MAX >> (8 - self.plan.superwords.lanes());
        let text = match (operation, own.negative) {
            (Operation::Add, negative) if negative == all => {
                apply(Operation::Sub, &texts, self.real, Operands::Lanes).text
            }
            (Operation::Add, negative) if negative != 0 => self.with_signs(&texts, negative),
            _ => apply(operation, &texts, self.real, Operands::Lanes).text,
        };
        let (vector, name) = (self.vector(), &self.words[word]);
        let _ = writeln!(body.text, "    const {vector} {name} = {text};");
        if let Some(element) = self.plan.vector(leader) {
            let _ = writeln!(body.text, "    {}[{element}] = {name};", self.vectors);
        }
    }

    /// A sum in some of whose lanes the second operand is subtracted. A product
    /// with 1 or -1 is exact.
    fn with_signs(&self, operands: &[BoundText], negative: u8) -> String {
        let signs = (0..self.plan.superwords.lanes()).map(|lane| match negative >> lane & 1 {
            1 => "-1".to_owned(),
            _ => "1".to_owned(),
        });
        let signs = self.braces(signs.collect());
        let signed = [signs, operands[1].clone()];
        let signed = apply(Operation::Mul, &signed, self.real, Operands::Lanes);
        let both = [operands[0].clone(), signed];
        apply(Operation::Add, &both, self.real, Operands::Lanes).text
    }

    /// The operands of all lanes as one vector.
    fn lanes(&self, body: &mut PartBody, number: usize, operands: &[Operand]) -> BoundText {
        if let Some(word) = self.plan.superwords.word_of(operands) {
            return BoundText::primary(self.word(body, number, word));
        }
        let texts = operands.iter();
        let texts = texts.map(|&operand| self.operand(body, number, operand).text);
        let texts = texts.collect();
        self.braces(texts)
    }

    fn braces(&self, lanes: Vec<String>) -> BoundText {
        let lanes = self.filled(lanes);
        BoundText::primary(format!("({}){{{lanes}}}", self.vector()))
    }

    /// The lanes of a vector; one that is not used repeats the first, so that it
    /// holds a number of the function.
    fn filled(&self, mut lanes: Vec<String>) -> String {
        let unused = self.plan.superwords.width() - lanes.len();
        lanes.extend(vec![lanes[0].clone(); unused]);
        lanes.join(", ")
    }

    /// The variable of a superword; it is fetched or gathered where a part reads
    /// it first.
    pub(super) fn word(&self, body: &mut PartBody, number: usize, word: usize) -> String {
        let name = self.words[word].clone();
        let own = &self.plan.superwords.words()[word];
        let first = own.items[0].value();
        let fetched = match (own.operation, first) {
            (Some(_), Some(leader)) => {
                let element = self.plan.load_vector(leader, number);
                element.map(|element| format!("{}[{element}]", self.vectors))
            }
            _ if body.fetched_words.contains(&word) => None,
            _ => {
                let lanes = own.items.iter();
                let lanes = lanes.map(|&item| self.operand(body, number, item).text);
                Some(format!("{{{}}}", self.filled(lanes.collect())))
            }
        };
        if let Some(text) = fetched
            && body.fetched_words.insert(word)
        {
            let _ = writeln!(body.text, "    const {} {name} = {text};", self.vector());
        }
        name
    }
}
