//! Samples against known properties of the distribution.

use super::*;
use crate::adjoint::AdjointRun;
use robovec_ir::Module;
use robovec_ir::parse::parse_module;
use robovec_ir::states::States;
use robovec_num::arithmetic::Binary32;

fn module(text: &str) -> Module {
    parse_module("sample", text).expect("it is well formed")
}

#[test]
fn rounding_hits_both_neighbours_with_the_right_chances() {
    let formats = [
        "f32",
        "f16",
        "float(8,40)",
        "float(8,5,flush)",
        "fixed(7,8)",
    ];
    for format in formats.map(|text| text.parse::<Format>().expect("it is one")) {
        let rounder = Rounder::new(format).expect("it is narrow");
        let place = 2.0 * half_ulp(format, 3.0);
        let exact = 3.0 + 0.25 * place;
        let (mut above, mut total) = (0, 0);
        for slot in 0..4000 {
            for rounded in rounder.round([exact; LANES], random(5, slot)) {
                assert!(
                    rounded == 3.0 || rounded == 3.0 + place,
                    "{format}: {rounded}"
                );
                above += u32::from(rounded > 3.0);
                total += 1;
            }
        }
        let share = f64::from(above) / f64::from(total);
        // Four standard deviations of the share.
        assert!((share - 0.25).abs() < 0.0097, "{format}: {share}");
        let kept = rounder.round([-3.0; LANES], random(1, 1));
        assert_eq!(kept, [-3.0; LANES], "{format}");
        assert_eq!(rounder.round([0.0; LANES], random(1, 2)), [0.0; LANES]);
    }
}

#[test]
fn the_ends_of_a_format_are_kept() {
    let rounder = |text: &str| {
        let format = text.parse().expect("it is a format");
        Rounder::new(format).expect("it is narrow")
    };
    let f16 = rounder("f16");
    let least = 2f64.powi(-24);
    for slot in 0..50 {
        let small = f16.round([1.5 * least; LANES], random(3, slot));
        assert!(small.iter().all(|&x| x == least || x == 2.0 * least));
        let large = f16.round([65_519.0; LANES], random(3, slot));
        assert!(large.iter().all(|&x| x == 65_504.0 || x == f64::INFINITY));
    }
    let flush = rounder("float(5,10,flush)");
    assert_eq!(flush.round([-1e-5; LANES], random(3, 1)), [0.0; LANES]);
    let fixed = rounder("fixed(3,4)");
    assert_eq!(
        fixed.round([9.0; LANES], random(3, 1)),
        [8.0 - 0.0625; LANES]
    );
    assert_eq!(
        fixed.round([f64::NEG_INFINITY; LANES], random(3, 1)),
        [-8.0; LANES]
    );
    assert!(Rounder::new(Format::BINARY64).is_err());
}

#[test]
fn three_sigma_hold_almost_always_and_sigma_is_no_waste() {
    let module = module(
        "function f equations {
  in q[1..9]
  out c[1..4]
  c[1] = (q[1]*q[2] - q[3]*q[4])*q[5] + 0.1*q[6]
  c[2] = sin(q[1] + q[2])*cos(q[3]) - q[7]*q[8]*q[9]
  c[3] = q[1]*q[2]*q[3]*q[4]*q[5]*q[6]*q[7]*q[8]*q[9]
  c[4] = (q[1] + q[2] + q[3] + q[4] + q[5])/(3.0 + cos(q[6]))
}",
    );
    let view = module.tables.view(&module.functions[0]);
    let tape = Tape::new(view.function);
    let slots: Vec<usize> = (0..tape.outputs()).map(|i| tape.output_slot(i)).collect();
    let (mut beyond, mut total, mut squares) = (0u32, 0u32, 0.0);
    for state in 0..2000 {
        let inputs = States::new(9).draw(view, state);
        let run = AdjointRun::new(&tape, &Binary32, Format::BINARY32, &inputs);
        let sampled =
            stochastic(&tape, Format::BINARY32, &inputs, 7, &slots).expect("f32 is narrow");
        for (output, sampled) in sampled.iter().enumerate() {
            let ratio = run.errors()[tape.output_slot(output)] / sampled.sigma;
            beyond += u32::from(ratio.abs() > 3.0);
            squares += ratio * ratio;
            total += 1;
        }
    }
    assert!(
        f64::from(beyond) <= 0.001 * f64::from(total),
        "{beyond} of {total}"
    );
    let mean_square = squares / f64::from(total);
    assert!((0.2..0.6).contains(&mean_square), "{mean_square}");
}

#[test]
fn samples_depend_on_the_seed_alone() {
    let module =
        module("function f equations {\n  in q[1..2]\n  out c[1..1]\n  c[1] = q[1]*q[2]\n}");
    let tape = Tape::new(&module.functions[0]);
    let slots = [tape.output_slot(0)];
    let at = |seed| {
        stochastic(&tape, Format::BINARY32, &[0.1, 0.3], seed, &slots).expect("f32 is narrow")
    };
    assert_eq!(at(1), at(1));
    assert_ne!(at(1), at(2));
}
