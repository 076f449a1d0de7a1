//! The resources of an operator, for any format and latency.
//!
//! Registers follow from the cuts: every cut of a core is this number of bits
//! wide ([`CoreStep::bits`](crate::rtl::cores::CoreStep)). Look-up tables
//! hardly depend on the cuts: shifting, adding and rounding take a few tables
//! per bit of the significand, and exponents are compared, added and limited
//! bit by bit, so the tables are linear in both widths. The factors are fitted
//! to mappings by yosys' `synth_intel_alm` of formats from 5 + 7 to 11 + 52
//! bits, which they meet within a tenth.

use super::ResourceUse;
use crate::layout::bits;
use crate::rtl::cores::{self, OperatorCore};
use robovec_ir::Format;
use robovec_ir::machine::Device;
use robovec_num::NumberFormat;

/// The resources of one operator with this number of stages.
pub fn operator(core: OperatorCore, number: Format, stages: u32, device: &Device) -> ResourceUse {
    match number {
        Format::Float(format) => float(core, format, stages, device),
        Format::Fixed(_) => fixed(core, number.width(), stages, device),
    }
}

/// Tables per bit and step of a shift, per bit of the mantissa and of the
/// exponent, and a constant.
fn tables(core: OperatorCore, subnormals: bool) -> [f64; 4] {
    match (core, subnormals) {
        (OperatorCore::Add, true) => [1.66, 5.42, 14.6, 0.0],
        (OperatorCore::Add, false) => [0.0, 17.5, 10.5, 0.0],
        (OperatorCore::Multiply, true) => [0.0, 10.5, 24.1, -52.0],
        (OperatorCore::Multiply, false) => [0.0, 2.6, 10.6, 0.0],
        (OperatorCore::Divide, true) => [0.0, 11.0, 25.0, 0.0],
        (OperatorCore::Divide, false) => [0.0, 4.0, 14.0, 0.0],
        (OperatorCore::Root, _) => [0.0, 1.5, 3.0, 0.0],
        // A product, and a sum of three times the width.
        (OperatorCore::Fused, _) => [4.8, 20.0, 30.0, 0.0],
    }
}

fn float(core: OperatorCore, format: NumberFormat, stages: u32, device: &Device) -> ResourceUse {
    let (exponent, mantissa) = (f64::from(format.exponent), f64::from(format.mantissa));
    let [per_step, per_mantissa, per_exponent, constant] = tables(core, format.subnormals);
    let steps = f64::from(bits(format.mantissa + 5));
    let mut aluts = per_step * (mantissa + 4.0) * steps
        + per_mantissa * mantissa
        + per_exponent * exponent
        + constant;
    let mut multiplier_blocks = 0.0;
    if matches!(core, OperatorCore::Divide | OperatorCore::Root) {
        // One row per bit of the result: a subtraction and a choice.
        let rows = mantissa + 3.0;
        let wide = if core == OperatorCore::Divide {
            2.0
        } else {
            1.6
        };
        aluts += wide * rows * (mantissa + 2.0);
    }
    if matches!(core, OperatorCore::Multiply | OperatorCore::Fused) {
        let significand = format.mantissa + 1;
        multiplier_blocks = product_blocks(significand, device);
        aluts += product_tables(significand, device);
    }
    let cuts = cores::cuts(core, format, stages, device);
    let steps = core.steps(format, device);
    let cut = (0_u32..)
        .zip(&steps)
        .filter(|(place, _)| cuts.mask >> place & 1 == 1);
    let held: u32 = cut.map(|(_, step)| step.bits).sum();
    let width = 1 + format.exponent + format.mantissa;
    ResourceUse {
        aluts,
        registers: f64::from(held + cuts.extra * width),
        multiplier_blocks,
        ..ResourceUse::default()
    }
}

/// Numbers without an exponent: a carry chain that saturates, or a product
/// that is rounded and saturates. No cores are built for them; this is for
/// comparing formats.
fn fixed(core: OperatorCore, width: u32, stages: u32, device: &Device) -> ResourceUse {
    let places = f64::from(width);
    let registers = places * f64::from(stages);
    match core {
        OperatorCore::Divide | OperatorCore::Root => ResourceUse {
            aluts: 2.0 * places * places,
            registers,
            ..ResourceUse::default()
        },
        OperatorCore::Add => ResourceUse {
            aluts: 2.0 * places,
            registers,
            ..ResourceUse::default()
        },
        OperatorCore::Multiply | OperatorCore::Fused => ResourceUse {
            aluts: 3.0 * places + product_tables(width, device),
            registers,
            multiplier_blocks: product_blocks(width, device),
            ..ResourceUse::default()
        },
    }
}

/// Multiplier blocks of a product of two numbers of this number of bits. In a
/// block of 27 bits three products of 9 or two of 18 share it; wider numbers
/// are cut into pieces, each product of which takes a block.
pub(super) fn product_blocks(width: u32, device: &Device) -> f64 {
    match (width, device.blocks.factor) {
        (0..=9, 27) => 1.0 / 3.0,
        (10..=18, 27) => 0.5,
        (_, factor) => f64::from(width.div_ceil(factor).pow(2)),
    }
}

/// Tables that add up the partial products of wide numbers.
fn product_tables(width: u32, device: &Device) -> f64 {
    let products = width.div_ceil(device.blocks.factor).pow(2);
    0.95 * f64::from((products - 1) * 2 * width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_ir::machine::DeviceFamily;

    fn operator(core: OperatorCore, number: Format, stages: u32) -> ResourceUse {
        super::operator(core, number, stages, DeviceFamily::default().device())
    }

    fn float(exponent: u32, mantissa: u32, subnormals: bool) -> NumberFormat {
        NumberFormat {
            exponent,
            mantissa,
            subnormals,
        }
    }

    /// Tables that yosys 0.70 maps the cores of no latency to.
    const MAPPED: [(OperatorCore, u32, u32, bool, f64); 34] = [
        (OperatorCore::Add, 8, 23, true, 458.0),
        (OperatorCore::Add, 5, 10, true, 239.0),
        (OperatorCore::Add, 11, 52, true, 1082.0),
        (OperatorCore::Add, 8, 17, true, 398.0),
        (OperatorCore::Add, 8, 7, true, 236.0),
        (OperatorCore::Add, 11, 40, true, 874.0),
        (OperatorCore::Add, 6, 13, true, 299.0),
        (OperatorCore::Add, 8, 23, false, 498.0),
        (OperatorCore::Add, 5, 10, false, 237.0),
        (OperatorCore::Add, 11, 52, false, 1071.0),
        (OperatorCore::Add, 8, 17, false, 391.0),
        (OperatorCore::Add, 8, 7, false, 214.0),
        (OperatorCore::Add, 11, 40, false, 852.0),
        (OperatorCore::Multiply, 8, 23, true, 408.0),
        (OperatorCore::Multiply, 5, 10, true, 188.0),
        (OperatorCore::Multiply, 11, 52, true, 1118.0),
        (OperatorCore::Multiply, 8, 17, true, 340.0),
        (OperatorCore::Multiply, 8, 7, true, 226.0),
        (OperatorCore::Multiply, 11, 40, true, 949.0),
        (OperatorCore::Multiply, 6, 13, true, 229.0),
        (OperatorCore::Multiply, 8, 23, false, 146.0),
        (OperatorCore::Multiply, 5, 10, false, 81.0),
        (OperatorCore::Multiply, 11, 52, false, 517.0),
        (OperatorCore::Multiply, 8, 17, false, 124.0),
        (OperatorCore::Multiply, 8, 7, false, 103.0),
        (OperatorCore::Multiply, 11, 40, false, 465.0),
        (OperatorCore::Divide, 5, 10, true, 538.0),
        (OperatorCore::Divide, 8, 17, true, 1160.0),
        (OperatorCore::Root, 5, 10, true, 277.0),
        (OperatorCore::Root, 8, 17, true, 614.0),
        (OperatorCore::Fused, 8, 23, true, 1345.0),
        (OperatorCore::Fused, 5, 10, true, 625.0),
        (OperatorCore::Fused, 8, 17, true, 1044.0),
        (OperatorCore::Fused, 11, 52, true, 3520.0),
    ];

    #[test]
    fn tables_are_within_a_tenth_of_the_mapping() {
        for (core, exponent, mantissa, subnormals, mapped) in MAPPED {
            let format = float(exponent, mantissa, subnormals);
            let estimated = operator(core, Format::Float(format), 1).aluts;
            let error = (estimated - mapped).abs() / mapped;
            assert!(error < 0.1, "{core:?} {format:?}: {estimated} for {mapped}");
        }
    }

    /// Tables and registers that yosys 0.70 maps cores of binary32 to.
    const BY_STAGES: [(OperatorCore, u32, f64, f64); 10] = [
        (OperatorCore::Add, 1, 469.0, 32.0),
        (OperatorCore::Add, 3, 450.0, 132.0),
        (OperatorCore::Add, 5, 424.0, 226.0),
        (OperatorCore::Add, 7, 456.0, 357.0),
        (OperatorCore::Add, 10, 451.0, 508.0),
        (OperatorCore::Add, 14, 446.0, 702.0),
        (OperatorCore::Multiply, 2, 368.0, 100.0),
        (OperatorCore::Multiply, 4, 356.0, 200.0),
        (OperatorCore::Multiply, 5, 388.0, 272.0),
        (OperatorCore::Multiply, 9, 390.0, 452.0),
    ];

    #[test]
    fn latencies_are_within_an_eighth_of_the_mapping() {
        let binary32 = Format::Float(NumberFormat::BINARY32);
        for (core, stages, aluts, registers) in BY_STAGES {
            let estimated = operator(core, binary32, stages);
            for (formula, mapped) in [(estimated.aluts, aluts), (estimated.registers, registers)] {
                let error = (formula - mapped).abs() / mapped;
                assert!(error < 0.125, "{core:?} {stages}: {formula} for {mapped}");
            }
        }
    }

    #[test]
    fn products_share_blocks_or_take_several() {
        assert_eq!(
            [8, 18, 24, 27, 28, 53]
                .map(|width| product_blocks(width, DeviceFamily::default().device())),
            [1.0 / 3.0, 0.5, 1.0, 1.0, 4.0, 4.0]
        );
    }
}
