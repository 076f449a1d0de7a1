//! Operands at which floating-point operators often fail, with the expected
//! results.

use super::reference::Reference;
use robovec_fpga::rtl::cores::OperatorCore;
use robovec_num::NumberFormat;
use robovec_num::arithmetic::Arithmetic;

/// Operands and the result they must have, as words.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vector {
    /// The operation among those of the core: 1 subtracts in `fp_add`;
    /// `operation` of `fp_fma`.
    pub(crate) operation: u64,
    pub(crate) left: u64,
    pub(crate) right: u64,
    pub(crate) addend: u64,
    pub(crate) result: u64,
}

/// This number of vectors for a core; the same for the same seed.
pub(crate) fn vectors(
    core: OperatorCore,
    format: NumberFormat,
    count: usize,
    seed: u64,
) -> Vec<Vector> {
    let reference = Reference::new(format);
    let mut source = Source {
        format,
        state: seed ^ 0x9E37_79B9_7F4A_7C15,
    };
    (0..count)
        .map(|_| {
            let left = source.word();
            let right = match core {
                OperatorCore::Add => source.close(left),
                OperatorCore::Multiply => source.balanced(left, false),
                OperatorCore::Divide => source.balanced(left, true),
                OperatorCore::Root => left,
                OperatorCore::Fused => source.balanced(left, false),
            };
            let addend = if core == OperatorCore::Fused {
                let arithmetic = reference.simulator();
                let factors = [left, right].map(|word| arithmetic.from_word(word));
                let product = arithmetic.word(arithmetic.mul(factors[0], factors[1]));
                source.close(product)
            } else {
                0
            };
            let operation = match core {
                OperatorCore::Add => source.below(2),
                OperatorCore::Fused => source.below(3),
                _ => 0,
            };
            Vector {
                operation,
                left,
                right,
                addend,
                result: reference.result(core, operation, [left, right, addend]),
            }
        })
        .collect()
}

/// Random words of a format (xorshift, Marsaglia 2003).
struct Source {
    format: NumberFormat,
    state: u64,
}

impl Source {
    fn next(&mut self) -> u64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        self.state.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    fn below(&mut self, limit: u64) -> u64 {
        (self.next() >> 32) % limit
    }

    fn ones(&self) -> u64 {
        (1 << self.format.exponent) - 1
    }

    fn behind(&self) -> u64 {
        (1 << self.format.mantissa) - 1
    }

    fn exponent_of(&self, word: u64) -> i64 {
        (word >> self.format.mantissa & self.ones()) as i64
    }

    fn packed(&mut self, exponent: i64, mantissa: u64) -> u64 {
        let exponent = exponent.clamp(0, self.ones() as i64) as u64;
        let sign = self.next() & 1;
        (sign << self.format.exponent | exponent) << self.format.mantissa | mantissa & self.behind()
    }

    /// Mantissas: any, a few ones, a run of ones, and next to a power of two.
    fn mantissa(&mut self) -> u64 {
        let width = u64::from(self.format.mantissa);
        match self.below(6) {
            0 => 0,
            1 => 1 << self.below(width) | 1 << self.below(width),
            2 => self.behind() << self.below(width + 1),
            3 => self.behind() >> self.below(width + 1),
            _ => self.next(),
        }
    }

    fn special(&mut self) -> u64 {
        let ones = self.ones() as i64;
        let middle = ones / 2;
        let choices = [
            (0, 0),
            (0, 1),
            (0, self.behind()),
            (1, 0),
            (1, 1),
            (ones - 1, self.behind()),
            (ones, 0),
            (ones, 1 << (self.format.mantissa - 1)),
            (ones, 1),
            (middle, 0),
            (middle, 1),
            (middle - 1, self.behind()),
        ];
        let (exponent, mantissa) = choices[self.below(choices.len() as u64) as usize];
        self.packed(exponent, mantissa)
    }

    fn word(&mut self) -> u64 {
        let mantissa = self.mantissa();
        match self.below(8) {
            0 => self.special(),
            1 => self.packed(0, mantissa),
            2 => {
                let exponent = self.below(4) as i64;
                self.packed(exponent, mantissa)
            }
            3 => {
                let exponent = (self.ones() - 1 - self.below(3).min(self.ones() - 1)) as i64;
                self.packed(exponent, mantissa)
            }
            _ => {
                let exponent = self.below(self.ones() + 1) as i64;
                self.packed(exponent, mantissa)
            }
        }
    }

    /// A word that another is to be added to: of a near exponent, or the same
    /// except for a few bits.
    fn close(&mut self, word: u64) -> u64 {
        let mantissa = self.mantissa();
        let reach = 2 * u64::from(self.format.mantissa) + 12;
        match self.below(8) {
            0 => self.word(),
            1 => word ^ (self.next() & 1) << (self.format.exponent + self.format.mantissa),
            2 | 3 => {
                let flipped = self.mantissa() & 7;
                let flipped = flipped | 1 << self.below(u64::from(self.format.mantissa) + 1);
                let sign = (self.next() & 1) << (self.format.exponent + self.format.mantissa);
                word ^ sign ^ flipped
            }
            4 => {
                let exponent = self.exponent_of(word) + self.below(3) as i64 - 1;
                self.packed(exponent, mantissa)
            }
            _ => {
                let away = self.below(reach) as i64 - (reach / 2) as i64;
                let exponent = self.exponent_of(word) + away;
                self.packed(exponent, mantissa)
            }
        }
    }

    /// A word whose product (or quotient) with another lies at an end of the
    /// range as often as not.
    fn balanced(&mut self, word: u64, divides: bool) -> u64 {
        if self.below(2) == 0 {
            return self.word();
        }
        let mantissa = self.mantissa();
        let bias = (self.ones() / 2) as i64;
        let target = match self.below(3) {
            0 => self.ones() as i64 - self.below(4) as i64,
            _ => 2 - self.below(u64::from(self.format.mantissa) + 5) as i64,
        };
        let exponent = if divides {
            self.exponent_of(word) - target + bias
        } else {
            target - self.exponent_of(word) + bias
        };
        self.packed(exponent, mantissa)
    }
}
