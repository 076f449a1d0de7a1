//! C with superwords, compiled, against the evaluator, bit for bit.

use crate::codegen_c;
use crate::support::programs::robovec;
use robovec_analysis::slice::live;
use robovec_cgen::c::{self, Options, Real, Signature, Sines};
use robovec_cgen::superword::SuperwordLanes;
use robovec_framework::manager::{self, Config};
use robovec_ir::parse::parse_module;
use robovec_ir::{Machine, Module};
use robovec_num::random::Random;
use robovec_passes::registry::REGISTRY;
use std::fmt::Write;

/// A mechanism of limbs as text: equations of a base, of every limb with other
/// numbers, signs and orders of operands, sums of all limbs at the base, and
/// equations of the limbs that read these.
struct Limbs {
    limbs: usize,
    /// Joints of the base, of a limb, and of what follows the limbs.
    joints: [usize; 3],
    /// Operations of a limb in each of its two recursions.
    operations: usize,
    /// The same joint of all limbs in turn, not limb by limb.
    in_turn: bool,
}

/// An operand in the equations of every limb.
#[derive(Clone, Copy)]
enum LimbOperand {
    /// An element of an input array: of a joint of the limb.
    Input(&'static str, usize),
    /// A variable of the limb, or of the base.
    Limb(usize),
    Base(usize),
    Constant,
}

impl Limbs {
    fn joint(&self, limb: usize, joint: usize) -> usize {
        let place = match self.in_turn {
            true => joint * self.limbs + limb,
            false => limb * self.joints[1] + joint,
        };
        self.joints[0] + place + 1
    }

    fn text(&self, random: &mut Random) -> String {
        let count = self.joints[0] + self.limbs * self.joints[1] + self.joints[2];
        let mut text = String::from("// robovec 1\n\nfunction f equations {\n");
        for array in ["q", "qd", "Qq"] {
            let _ = writeln!(text, "  in {array}[1..{count}]");
        }
        let outputs = self.limbs * 4 + 4;
        let _ = writeln!(text, "  out y[1..{outputs}]\n");
        let mut base = 0;
        for joint in 1..=self.joints[0] {
            let _ = writeln!(text, "  %B{base} = sin(q[{joint}])*qd[{joint}]");
            base += 1;
        }
        let mut known = Vec::new();
        for recursion in 0..2 {
            let first = recursion * self.operations;
            for number in first..first + self.operations {
                self.operation(&mut text, random, number, base, &mut known);
            }
            for _ in 0..3 {
                let read = first + random.below(self.operations);
                let limbs = (0..self.limbs).map(|limb| format!("%L{limb}_{read}"));
                let mut sum = String::from("0.5");
                for limb in limbs {
                    let sign = if random.below(4) == 0 { "-" } else { "+" };
                    let _ = write!(sum, " {sign} {limb}");
                }
                let _ = writeln!(text, "  %B{base} = {sum}");
                base += 1;
            }
        }
        let mut output = 0;
        for place in 1..=4 {
            for limb in 0..self.limbs {
                output += 1;
                let read = 2 * self.operations - place;
                let _ = writeln!(text, "  y[{output}] = %L{limb}_{read}");
            }
        }
        for place in 1..=4 {
            output += 1;
            let _ = writeln!(text, "  y[{output}] = %B{}", base - place.min(base));
        }
        text + "}\n"
    }

    /// An operation of every limb.
    fn operation(
        &self,
        text: &mut String,
        random: &mut Random,
        number: usize,
        base: usize,
        known: &mut Vec<usize>,
    ) {
        let mut pick = || match random.below(8) {
            0 | 1 => {
                let array = ["q", "qd", "Qq"][random.below(3)];
                LimbOperand::Input(array, random.below(self.joints[1]))
            }
            2 if base > 0 => LimbOperand::Base(random.below(base)),
            3 => LimbOperand::Constant,
            _ => match known.len() {
                0 => LimbOperand::Input("q", random.below(self.joints[1])),
                count => LimbOperand::Limb(known[count - 1 - random.below(count.min(12))]),
            },
        };
        let (left, right) = (pick(), pick());
        let kind = random.below(12);
        for limb in 0..self.limbs {
            let word = |operand, random: &mut Random| match operand {
                LimbOperand::Input(array, joint) => {
                    format!("{array}[{}]", self.joint(limb, joint))
                }
                LimbOperand::Limb(read) => format!("%L{limb}_{read}"),
                LimbOperand::Base(read) => format!("%B{read}"),
                LimbOperand::Constant => format!("{:?}", 0.25 + random.below(7) as f64 / 8.0),
            };
            let [mut a, mut b] = [word(left, random), word(right, random)];
            if kind < 9 && random.below(3) == 0 {
                std::mem::swap(&mut a, &mut b);
            }
            let operation = match kind {
                0..5 => format!("{a}*{b}"),
                5..9 if random.below(4) == 0 => format!("{a} - {b}"),
                5..9 => format!("{a} + {b}"),
                9 => format!("{a}/(1.5 + {b}*{b})"),
                10 => format!("cos(q[{}])", self.joint(limb, number % self.joints[1])),
                _ => format!("sqrt(2.0 + {a}*{a})"),
            };
            let _ = writeln!(text, "  %L{limb}_{number} = {operation}");
        }
        known.push(number);
    }
}

/// The options of plain C whose results are the evaluator's.
fn options(superwords: SuperwordLanes, real: Real) -> Options {
    Options {
        signature: Signature::Plain,
        real,
        sines: Sines::Library,
        part: 60,
        superwords,
        ..Options::default()
    }
}

/// Compares C with the evaluator; gives the share of the operations that are in
/// vectors.
fn check(module: &Module, random: &mut Random, superwords: SuperwordLanes) -> f64 {
    let function = &module.functions[0];
    let inputs: Vec<f64> = (0..function.input_len()).map(|_| random.signed()).collect();
    codegen_c::check(module, &inputs, |real| options(superwords, real));
    let lanes = match superwords {
        SuperwordLanes::Three => 3.0,
        SuperwordLanes::Four => 4.0,
        _ => 2.0,
    };
    let operations = live(function).iter().filter(|live| **live).count() as f64;
    c::vector_operations(function, &options(superwords, Real::Double)) as f64 * lanes / operations
}

/// Random mechanisms with limbs of every arrangement.
#[test]
fn limbs_are_computed_side_by_side() {
    let mut random = Random::new(61);
    let cases = [
        (2, [3, 4, 0], 150, false, SuperwordLanes::Two),
        (4, [6, 3, 0], 120, false, SuperwordLanes::Four),
        (4, [0, 3, 2], 80, true, SuperwordLanes::Four),
        (4, [2, 2, 1], 60, false, SuperwordLanes::Two),
        (3, [1, 4, 0], 60, true, SuperwordLanes::Three),
        (3, [2, 3, 0], 60, false, SuperwordLanes::Two),
        (2, [1, 1, 5], 40, false, SuperwordLanes::Auto),
    ];
    for (limbs, joints, operations, in_turn, superwords) in cases {
        let limbs = Limbs {
            limbs,
            joints,
            operations,
            in_turn,
        };
        let text = limbs.text(&mut random);
        let module = parse_module("limbs", &text).expect("it is the text form");
        let share = check(&module, &mut random, superwords);
        if superwords != SuperwordLanes::Auto
            && (limbs.limbs != 3 || superwords != SuperwordLanes::Two)
        {
            assert!(share > 0.4, "{share} of {joints:?}");
        }
    }
}

/// Mechanisms with sides after the passes for processors: a quadruped, a biped
/// with loops, a car and a bogie.
#[test]
fn limbs_and_wheels_are_computed_side_by_side() {
    let mut random = Random::new(62);
    let mechanisms = [
        (
            "examples/robots/quadruped.urdf",
            "accelred",
            SuperwordLanes::Four,
            0.6,
        ),
        (
            "examples/robots/biped.xml",
            "accelred",
            SuperwordLanes::Two,
            0.8,
        ),
        (
            "examples/models/wishbone-car.mbs",
            "dirdyna",
            SuperwordLanes::Two,
            0.8,
        ),
        (
            "examples/models/bogie.mbs",
            "dirdyna",
            SuperwordLanes::Two,
            0.7,
        ),
    ];
    for (model, function, superwords, least) in mechanisms {
        let base: &[&str] = match model.ends_with(".urdf") {
            true => &["--base", "floating"],
            false => &[],
        };
        let folder = tempfile::tempdir().expect("a temporary directory");
        let path = folder.path().join("f.rvir");
        let file = path.to_str().expect("a name");
        let arguments = [
            "gen",
            model,
            "--numbers",
            "--no-forces",
            "--function",
            function,
        ];
        let made = robovec(&[&arguments, base, &["-o", file]].concat());
        assert!(made.status.success(), "{model}");
        let text = std::fs::read_to_string(&path).expect("it was written");
        let mut module = parse_module(model, &text).expect("it is the text form");
        module.functions[0].name = "f".to_owned();
        let pipeline = REGISTRY.pipeline("$cpu").expect("a preset");
        let machine = Machine::built_in("thesis").expect("it ships");
        let mut log = std::io::sink();
        manager::run(&mut module, &pipeline, Config::new(&machine, &mut log)).expect("it runs");
        let share = check(&module, &mut random, superwords);
        assert!(share > least, "{model}: {share}");
    }
}
