//! A seeded synthetic program of any size, in the syntax of several tools.
//!
//! One operation per equation: 60 % multiplications, 40 % additions and
//! subtractions; operands 70 % from the last 200 values and 30 % from
//! anywhere; every tenth equation repeats an earlier one exactly. Values
//! nothing has used yet are preferred among those from anywhere, so nothing
//! is dead.

use robovec_num::random::Random;
use std::fmt::Write;

/// Operand of an equation.
#[derive(Clone, Copy)]
enum Operand {
    /// An input, from 1.
    Input(usize),
    /// An earlier equation, from 0.
    Value(usize),
}

#[derive(Clone, Copy)]
struct Equation {
    sign: char,
    left: Operand,
    right: Operand,
}

pub(crate) struct Program {
    equations: Vec<Equation>,
}

/// Number of inputs.
const INPUTS: usize = 64;
/// Number of outputs: the last values.
const OUTPUTS: usize = 256;
/// Maximum distance of a near operand.
const NEAR: usize = 200;

impl Program {
    /// The program of a size and seed.
    pub(crate) fn new(operations: usize, seed: u64) -> Program {
        let mut random = Random::new(seed);
        let mut equations: Vec<Equation> = Vec::with_capacity(operations);
        let mut used = vec![false; operations];
        let mut oldest_unused = 0;
        for index in 0..operations {
            let equation = if index > NEAR && random.below(10) == 0 {
                equations[index - 1 - random.below(NEAR)]
            } else {
                let mut operand = |random: &mut Random| {
                    if random.below(10) < 7 || index < NEAR {
                        let near = random.below(NEAR.min(index + INPUTS));
                        return if near < index {
                            Operand::Value(index - 1 - near)
                        } else {
                            Operand::Input(1 + near - index)
                        };
                    }
                    while oldest_unused < index && used[oldest_unused] {
                        oldest_unused += 1;
                    }
                    if oldest_unused + NEAR < index {
                        used[oldest_unused] = true;
                        return Operand::Value(oldest_unused);
                    }
                    Operand::Value(random.below(index))
                };
                Equation {
                    left: operand(&mut random),
                    right: operand(&mut random),
                    sign: ['*', '*', '*', '+', '-'][random.below(5)],
                }
            };
            for operand in [equation.left, equation.right] {
                if let Operand::Value(value) = operand {
                    used[value] = true;
                }
            }
            equations.push(equation);
        }
        Program { equations }
    }

    fn outputs(&self) -> std::ops::Range<usize> {
        self.equations.len().saturating_sub(OUTPUTS)..self.equations.len()
    }

    /// As a Robotran C file.
    pub(crate) fn c(&self) -> String {
        let mut text = format!(
            "//\n//\t==> Project name: synthetic\n//\n//\t==> Number of joints: {INPUTS}\n//\n\
             //\t==> Function: F1 - Recursive Direct Dynamics of tree-like MBS\n//\n\n\
             #include <math.h>\n\n#include \"mbs_data.h\"\n\n\
             void mbs_dirdyna(double **M, double *c,\nMbsData *s, double tsim)\n{{\n\
             #include \"mbs_dirdyna_synthetic.h\"\n\ndouble *q;\n\nq = s->q;\n\n"
        );
        let name = |operand| match operand {
            Operand::Input(input) => format!("q[{input}]"),
            Operand::Value(value) => format!("V{value}"),
        };
        for (index, equation) in self.equations.iter().enumerate() {
            let _ = writeln!(
                text,
                "V{index} = {}{}{};",
                name(equation.left),
                equation.sign,
                name(equation.right)
            );
        }
        for (output, value) in self.outputs().enumerate() {
            let _ = writeln!(text, "c[{}] = V{value};", output + 1);
        }
        text.push_str("\n// Number of continuation lines = 0\n\n}\n");
        text.replace("double **M, ", "")
    }

    /// As MLIR of the arith and func dialects.
    pub(crate) fn mlir(&self) -> String {
        let inputs: Vec<String> = (1..=INPUTS).map(|i| format!("%q{i}: f64")).collect();
        let types = vec!["f64"; self.outputs().len()].join(", ");
        let mut text = format!("func.func @f({}) -> ({types}) {{\n", inputs.join(", "));
        for (index, equation) in self.equations.iter().enumerate() {
            let operation = match equation.sign {
                '*' => "arith.mulf",
                '+' => "arith.addf",
                _ => "arith.subf",
            };
            let _ = writeln!(
                text,
                "  %v{index} = {operation} {}, {} : f64",
                percent(equation.left),
                percent(equation.right)
            );
        }
        let results: Vec<String> = self.outputs().map(|value| format!("%v{value}")).collect();
        let _ = writeln!(text, "  return {} : {types}\n}}", results.join(", "));
        text
    }

    /// As LLVM IR with fast-math flags.
    pub(crate) fn llvm(&self) -> String {
        let inputs: Vec<String> = (1..=INPUTS).map(|i| format!("double %q{i}")).collect();
        let mut text = format!("define void @f({}, ptr %out) {{\n", inputs.join(", "));
        for (index, equation) in self.equations.iter().enumerate() {
            let operation = match equation.sign {
                '*' => "fmul",
                '+' => "fadd",
                _ => "fsub",
            };
            let _ = writeln!(
                text,
                "  %v{index} = {operation} fast double {}, {}",
                percent(equation.left),
                percent(equation.right)
            );
        }
        for (output, value) in self.outputs().enumerate() {
            let _ = writeln!(
                text,
                "  %p{output} = getelementptr double, ptr %out, i64 {output}\n  \
                 store double %v{value}, ptr %p{output}"
            );
        }
        text.push_str("  ret void\n}\n");
        text
    }
}

fn percent(operand: Operand) -> String {
    match operand {
        Operand::Input(input) => format!("%q{input}"),
        Operand::Value(value) => format!("%v{value}"),
    }
}
