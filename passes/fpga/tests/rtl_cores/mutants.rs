//! Planted faults: each changes a few characters of a source file, and the
//! vectors must detect every one of them.

use super::simulators::{Bench, Simulator};
use super::{BINARY32, BINARY32_FLUSHED, vectors};
use robovec_fpga::rtl::cores::{OperatorCore, SOURCES};
use robovec_ir::machine::DeviceFamily;

/// A fault.
pub(crate) struct Mutant {
    pub(crate) file: &'static str,
    /// Fault of the operator.
    pub(crate) what: &'static str,
    /// The text it replaces, at its first place.
    from: &'static str,
    to: &'static str,
    core: OperatorCore,
    flushes: bool,
    device: DeviceFamily,
}

impl Mutant {
    /// True when one of this number of vectors gives another result than it
    /// must.
    pub(crate) fn is_noticed(&self, count: usize) -> bool {
        let format = if self.flushes {
            BINARY32_FLUSHED
        } else {
            BINARY32
        };
        let source = SOURCES.iter().find(|(name, _)| *name == self.file);
        let (_, text) = source.expect("the file is there");
        assert!(text.contains(self.from), "{}: {}", self.file, self.from);
        let text = text.replacen(self.from, self.to, 1);
        let vectors = vectors::vectors(self.core, format, count, 3);
        let bench = Bench::new(self.core, format, 4, self.device.device());
        let report = bench
            .with(self.file, text)
            .run(Simulator::Iverilog, &vectors);
        report.wrong > 0
    }
}

const fn mutant(
    (file, what): (&'static str, &'static str),
    (from, to): (&'static str, &'static str),
    core: OperatorCore,
    flushes: bool,
) -> Mutant {
    Mutant {
        file,
        what,
        from,
        to,
        core,
        flushes,
        device: DeviceFamily::CycloneV,
    }
}

/// A fault of products in pieces.
const fn split(names: (&'static str, &'static str), texts: (&'static str, &'static str)) -> Mutant {
    Mutant {
        device: DeviceFamily::Ecp5,
        ..mutant(names, texts, OperatorCore::Multiply, false)
    }
}

pub(crate) const MUTANTS: &[Mutant] = &[
    mutant(
        ("fp_pack.v", "ties are not broken by the sticky bit"),
        ("guard & (sticky | fraction[0])", "guard & fraction[0]"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_pack.v", "ties go away from zero"),
        ("guard & (sticky | fraction[0])", "guard"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_pack.v", "ties go to the odd neighbour"),
        ("(sticky | fraction[0])", "(sticky | ~fraction[0])"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_pack.v", "the carry between the halves is lost"),
        ("low_2[LOW]};", "1'b0};"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_pack.v", "NaN has a sign"),
        ("sign & ~nan", "sign"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_pack.v", "NaN is an infinity"),
        ("quiet[MANTISSA-1:0] | (", "("),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_pack.v", "infinity has a fraction"),
        ("(fraction & {MANTISSA{~special}})", "fraction"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_pack.v", "special results are rounded"),
        ("& ~special;", ";"),
        OperatorCore::Multiply,
        true,
    ),
    mutant(
        ("fp_shift_right.v", "the nearest dropped bits are forgotten"),
        ("(digit != 2'd0 & group[0])", "1'b0"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        (
            "fp_shift_right.v",
            "dropped bits of the second unit are forgotten",
        ),
        ("(digit[1] & group[1])", "1'b0"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        (
            "fp_shift_right.v",
            "dropped bits of the third unit are forgotten",
        ),
        ("(&digit & group[2])", "1'b0"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_shift_right.v", "only the last level sees dropped bits"),
        ("sticky_in | dropped", "dropped"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_normalise.v", "the limit is ignored"),
        ("more ? cap_in :", "1'b0 ? cap_in :"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_normalise.v", "a smaller digit does not free the next"),
        ("wire less = less_held |", "wire less = 1'b0 |"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_normalise.v", "the least sum counts as zero"),
        ("nonzero_in = |value;", "nonzero_in = |value[WIDTH-1:4];"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "an exact zero keeps a sign"),
        ("sign_5 & (nonzero | ~subtracts_5)", "sign_5"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "operands of one exponent are not ordered"),
        ("(~backward_0[E] & less)", "1'b0"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "a subnormal operand lies a place too low"),
        ("small_least & ~large_least ?", "1'b0 ?"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "infinity less infinity is infinity"),
        ("\n        | (left_most & right_most & subtracts)", ""),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "far operands come round again"),
        (" | {AMOUNT{|difference[E-1:AMOUNT]}}", ""),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "differences are one too small"),
        ("term[HALF-1:0], subtracts_2}", "term[HALF-1:0], 1'b0}"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "the carry into the upper half is lost"),
        ("{term_3, low_3[HALF]}", "{term_3, 1'b0}"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "an overflow by a carry is missed"),
        ("flags_4[0] | overflows", "flags_4[0]"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "the lowest bit does not count in the rounding"),
        (".sticky(|shifted[2:0])", ".sticky(|shifted[2:1])"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "the least exponent is zero"),
        ("~|exponent_3}", "1'b0}"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "differences are sums"),
        ("right[E+M] ^ subtract", "right[E+M]"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_add.v", "small sums are not flushed"),
        ("below | ~nonzero", "~nonzero"),
        OperatorCore::Add,
        true,
    ),
    mutant(
        ("fp_add.v", "subnormal operands are not flushed"),
        ("large_fraction & {M{~large_least}}", "large_fraction"),
        OperatorCore::Add,
        true,
    ),
    mutant(
        ("fp_pack.v", "the register at the result is missing"),
        (".REGISTERED(CUTS[2])", ".REGISTERED(0)"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("pipeline_cut.v", "registers do not hold"),
        ("if (enable) held", "held"),
        OperatorCore::Add,
        false,
    ),
    mutant(
        ("fp_mul.v", "the lower half of the product is forgotten"),
        ("|rest,", "1'b0,"),
        OperatorCore::Multiply,
        true,
    ),
    mutant(
        (
            "fp_mul.v",
            "the exponent of a subnormal product is below zero",
        ),
        ("left_over & {WIDE{~limited}}", "left_over"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_mul.v", "the bit below the guard is forgotten"),
        ("sticky | (stays & window[0])", "sticky"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_mul.v", "small products are not flushed"),
        ("SUBNORMALS == 0 & below", "1'b0"),
        OperatorCore::Multiply,
        true,
    ),
    mutant(
        ("fp_mul.v", "products are flushed a binade too late"),
        ("(~top & least_4)", "1'b0"),
        OperatorCore::Multiply,
        true,
    ),
    mutant(
        ("fp_mul.v", "an overflow by the leading bit is missed"),
        ("(top & above_raised_4)", "1'b0"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_mul.v", "infinity times zero is infinity"),
        (
            "\n        | (left_most & right_zero) | (right_most & left_zero)",
            "",
        ),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        (
            "fp_mul.v",
            "a leading bit at the top does not raise the exponent",
        ),
        ("top ? raised_4 : kept_4", "kept_4"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        (
            "fp_mul.v",
            "only the lowest bits of an exponent show subnormals",
        ),
        ("LOW = M + 4 * four", "LOW = M"),
        OperatorCore::Multiply,
        false,
    ),
    split(
        ("fp_mul.v", "products of pieces are in the wrong place"),
        ("at / PIECES + at % PIECES", "at / PIECES"),
    ),
    split(
        ("fp_mul.v", "the highest product of pieces is forgotten"),
        ("at < PIECES * PIECES;", "at < PIECES * PIECES - 1;"),
    ),
    mutant(
        ("fp_mul.v", "minus times minus is minus"),
        ("left_sign ^ right_sign", "left_sign | right_sign"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_mul.v", "a subnormal factor is half as large"),
        ("left_exponent[0] | left_least", "left_exponent[0]"),
        OperatorCore::Multiply,
        false,
    ),
    mutant(
        ("fp_div.v", "the remainder is forgotten"),
        ("rest | (top & quotient[0])", "top & quotient[0]"),
        OperatorCore::Divide,
        false,
    ),
    mutant(
        ("fp_div.v", "zero by zero is infinity"),
        (" | (left_zero & right_zero)", ""),
        OperatorCore::Divide,
        false,
    ),
    mutant(
        ("fp_div.v", "a quotient below one has the exponent of one"),
        ("1'b0}}, ~top}", "1'b0}}, 1'b0}"),
        OperatorCore::Divide,
        false,
    ),
    mutant(
        ("fp_div.v", "what a subnormal quotient drops is forgotten"),
        ("sticky_4 | dropped", "sticky_4"),
        OperatorCore::Divide,
        false,
    ),
    mutant(
        ("fp_div.v", "a large quotient is not infinite"),
        ("flags_2[1] | (above & ~flags_2[0])", "flags_2[1]"),
        OperatorCore::Divide,
        false,
    ),
    mutant(
        ("fp_sqrt.v", "odd powers are taken for even ones"),
        ("odd ? {leading, 1'b0} :", "1'b0 ? {leading, 1'b0} :"),
        OperatorCore::Root,
        false,
    ),
    mutant(
        ("fp_sqrt.v", "the remainder is forgotten"),
        ("assign sticky = rest;", "assign sticky = 1'b0;"),
        OperatorCore::Root,
        false,
    ),
    mutant(
        ("fp_sqrt.v", "the root of minus zero is no number"),
        ("(sign & ~zero)", "sign"),
        OperatorCore::Root,
        false,
    ),
    mutant(
        ("fp_fma.v", "an addend is lost beside a zero product"),
        ("distance[WIDE-1] | product_zero_2", "distance[WIDE-1]"),
        OperatorCore::Fused,
        false,
    ),
    mutant(
        ("fp_fma.v", "a negative sum is positive"),
        ("(negative & ~flags_7[0])", "1'b0"),
        OperatorCore::Fused,
        false,
    ),
    mutant(
        ("fp_fma.v", "differences are one too small"),
        ("? with_7 :", "? without_7 :"),
        OperatorCore::Fused,
        false,
    ),
    mutant(
        ("fp_fma.v", "what is dropped of the addend is forgotten"),
        ("aligned, sticky}", "aligned, 1'b0}"),
        OperatorCore::Fused,
        false,
    ),
    mutant(
        ("fp_fma.v", "the addend is always added"),
        ("addend_sign ^ operation[0]", "addend_sign"),
        OperatorCore::Fused,
        false,
    ),
    mutant(
        ("fp_fma.v", "infinity less infinity is infinity"),
        (
            "\n        | (product_infinite & addend_infinite & subtracts)",
            "",
        ),
        OperatorCore::Fused,
        false,
    ),
    mutant(
        ("fp_fma.v", "the largest exponent is a number's"),
        ("exact >= ONES", "exact > ONES"),
        OperatorCore::Fused,
        false,
    ),
    mutant(
        ("fp_fma.v", "an exact zero keeps a sign"),
        ("(nonzero | ~flags_9[2] | flags_9[0])", "1'b1"),
        OperatorCore::Fused,
        false,
    ),
    mutant(
        ("fp_unpack.v", "a subnormal number is half as large"),
        ("field[0] | least", "field[0]"),
        OperatorCore::Fused,
        false,
    ),
    mutant(
        ("fp_leading.v", "zeros at the top do not count"),
        ("\n                - {{(WIDE - COUNT) {1'b0}}, count}", ""),
        OperatorCore::Divide,
        false,
    ),
];
