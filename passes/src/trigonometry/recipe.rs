//! The recipe for the sine and cosine of one angle: a small function.
//!
//! A recipe is a function of one input, the angle, at the atomic level and
//! without names. The code that evaluates, times and bounds functions works
//! with recipes; the pass writes their nodes into the program, with names.

use super::builder::RecipeBuilder;
use super::options::Scheme;
use super::scheme::{OperationCycles, PolynomialPlan};
use robovec_analysis::slice::needed;
use robovec_ir::{Function, Level, Machine, Node, Operand, Operation};
use robovec_num::format::Format;
use robovec_num::trigonometry::{Circular, Halved, Polynomial};

/// The computation of an angle's sine and cosine.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// The operations; input 0 is the angle.
    pub function: Function,
    /// The sine and the cosine, [`Operand::NONE`] for an unneeded one.
    pub results: [Operand; 2],
    /// The number of reads of each node, by nodes and results.
    pub uses: Vec<u32>,
    /// The number of reads of the angle.
    pub angle_uses: u32,
}

impl Recipe {
    /// The operations that give the wanted ones of sine and cosine from
    /// polynomials for the angle divided by a power of two.
    pub fn new(halved: &Halved, wanted: [bool; 2], machine: &Machine, scheme: Scheme) -> Recipe {
        let mut builder = RecipeBuilder::new();
        let cycles = OperationCycles {
            add: machine.weight(Operation::Add),
            multiply: machine.weight(Operation::Mul),
        };
        let format = machine.number;
        let results = builder.write(halved, cycles, scheme, format);
        builder.finish(results, wanted)
    }

    /// The number of operations.
    pub fn operations(&self) -> usize {
        self.function.nodes().len()
    }
}

impl RecipeBuilder {
    fn write(
        &mut self,
        halved: &Halved,
        cycles: OperationCycles,
        scheme: Scheme,
        format: Format,
    ) -> [Operand; 2] {
        let polynomials = [&halved.sine, &halved.cosine];
        let absorbed = polynomials.map(|polynomial| absorbed(polynomial, halved.halvings));
        let fits = absorbed
            .iter()
            .all(|polynomial| is_normal(polynomial, format));
        if !fits {
            let scale = self.constant(2f64.powi(-(halved.halvings as i32)));
            self.angle = self.push(Operation::Mul, scale, self.angle);
        }
        let mut results = [0, 1].map(|which| {
            let polynomial = if fits {
                &absorbed[which]
            } else {
                polynomials[which]
            };
            PolynomialPlan::new(polynomial, cycles, scheme).build(self)
        });
        // Back to the whole angle: `sin 2x = 2 sin x cos x` and
        // `cos 2x = 1 - 2 sin^2 x`, with `2 sin x` by what is quicker.
        for _ in 0..halved.halvings {
            let [sine, cosine] = results;
            let double = if cycles.multiply <= cycles.add {
                let two = self.constant(2.0);
                self.push(Operation::Mul, two, sine)
            } else {
                self.push(Operation::Add, sine, sine)
            };
            let one = self.constant(1.0);
            let square = self.push(Operation::Mul, double, sine);
            results = [
                self.push(Operation::Mul, double, cosine),
                self.push(Operation::Sub, one, square),
            ];
        }
        results
    }

    /// Keeps the operations that the requested results need.
    fn finish(self, results: [Operand; 2], wanted: [bool; 2]) -> Recipe {
        let old = self.function;
        let roots = results.into_iter().zip(wanted);
        let roots = roots.filter_map(|(result, wanted)| wanted.then_some(result));
        let needed = needed(&old, roots, |_| false);
        let mut rewriter = robovec_framework::rewrite::Rewriter::new(&old, Level::Atomic);
        for (value, node) in old.values() {
            if needed[value.index()] {
                let operands = rewriter.translate_operands(node);
                rewriter.keep(Node { operands, ..*node });
            } else {
                rewriter.record(Operand::NONE);
            }
        }
        let mut kept = [Operand::NONE; 2];
        for index in 0..2 {
            if wanted[index] {
                kept[index] = rewriter.translate(results[index]);
            }
        }
        let function = rewriter.finish();
        let mut uses = vec![0; function.nodes().len()];
        let mut angle_uses = 0;
        let reads = function.nodes().iter().flat_map(|node| node.operands());
        for operand in reads.chain(&kept) {
            if let Some(value) = operand.value() {
                uses[value.index()] += 1;
            }
            angle_uses += u32::from(operand.input().is_some());
        }
        Recipe {
            function,
            results: kept,
            uses,
            angle_uses,
        }
    }
}

/// The polynomial of the whole angle that equals one of the angle divided by
/// a power of two: its coefficients are divided by powers of two.
fn absorbed(polynomial: &Polynomial, halvings: u32) -> Polynomial {
    let first = polynomial.of.first_power();
    let coefficients = polynomial.coefficients.iter().enumerate();
    Polynomial {
        of: polynomial.of,
        coefficients: coefficients
            .map(|(k, &coefficient)| {
                let power = (2 * k as u32 + first) * halvings;
                coefficient * 2f64.powi(-(power as i32))
            })
            .collect(),
    }
}

/// Tests whether a format holds all coefficients as normal numbers, so that
/// dividing them by powers of two was exact.
fn is_normal(polynomial: &Polynomial, format: Format) -> bool {
    let least = match format {
        Format::Float(float) => 2f64.powi(float.smallest_exponent()),
        Format::Fixed(_) => 1.0,
    };
    let mut coefficients = polynomial.coefficients.iter();
    coefficients.all(|&number| number == 0.0 || number.abs() >= least)
}

/// The index in [`Recipe::results`] that belongs to a function.
pub(super) fn place(of: Circular) -> usize {
    match of {
        Circular::Sine => 0,
        Circular::Cosine => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_analysis::critical_path::critical_path;
    use robovec_ir::evaluate::evaluate_nodes;
    use robovec_num::arithmetic::{Arithmetic, Binary32};
    use robovec_num::double_double::{Double, DoubleDouble};

    fn machine(name: &str) -> Machine {
        Machine::built_in(name).expect("it ships")
    }

    fn results<A: Arithmetic>(recipe: &Recipe, arithmetic: &A, angle: f64) -> [A::Number; 2] {
        let angle = arithmetic.literal(angle);
        let values = evaluate_nodes(&recipe.function, arithmetic, &[angle]);
        recipe.results.map(|operand| {
            let constant = operand.constant();
            match (operand.value(), constant) {
                (Some(value), _) => values[value.index()],
                (None, Some(constant)) => {
                    arithmetic.literal(recipe.function.constant_number(constant))
                }
                (None, None) => angle,
            }
        })
    }

    #[test]
    fn recipes_compute_their_polynomials_in_every_scheme() {
        for scheme in [Scheme::Horner, Scheme::Shortest] {
            for (order, halvings) in [(1, 0), (2, 1), (5, 0), (9, 2), (15, 0), (31, 0)] {
                let halved = Halved {
                    sine: Polynomial::taylor(Circular::Sine, order),
                    cosine: Polynomial::taylor(Circular::Cosine, order),
                    halvings,
                };
                let recipe = Recipe::new(&halved, [true; 2], &machine("thesis"), scheme);
                for angle in [-2.5, -0.3, 0.0, 0.1, 1.7] {
                    let exact = halved.at(Double::from(angle));
                    let found = results(&recipe, &DoubleDouble, angle);
                    for (exact, found) in exact.into_iter().zip(found) {
                        assert!((exact - found).high.abs() < 1e-25, "order {order}");
                    }
                }
            }
        }
    }

    #[test]
    fn rounding_stays_below_its_bound_and_near_it() {
        let machine = machine("thesis");
        for (order, halvings, range) in [(5, 0, 1.0), (7, 0, 0.5), (9, 0, 3.0), (5, 3, 3.0)] {
            let of = |of| Polynomial::minimax(of, order, range, Some(Format::BINARY32));
            let halved = Halved {
                sine: of(Circular::Sine),
                cosine: of(Circular::Cosine),
                halvings,
            };
            for scheme in [Scheme::Horner, Scheme::Shortest] {
                let recipe = Recipe::new(&halved, [true; 2], &machine, scheme);
                let bounds = recipe.rounding_errors(range, Format::BINARY32);
                let mut worst = [0.0f64; 2];
                for sample in 0..2000 {
                    let angle = range * f64::from(sample) / 2000.0;
                    let angle = f64::from(angle as f32);
                    let exact = halved.at(Double::from(angle));
                    let found = results(&recipe, &Binary32, angle);
                    for index in 0..2 {
                        let error = exact[index].distance(f64::from(found[index]));
                        worst[index] = worst[index].max(error);
                    }
                }
                for (worst, bound) in worst.into_iter().zip(bounds) {
                    assert!(worst <= bound, "order {order}: {worst} above {bound}");
                    assert!(
                        bound < 12.0 * worst,
                        "order {order}: {worst} far below {bound}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_shortest_scheme_is_never_longer_and_horner_has_the_fewest_operations() {
        for name in ["thesis", "pipeline-3-3", "fused"] {
            let machine = machine(name);
            let mut shorter = 0;
            for order in 1..=15 {
                let halved = Halved {
                    sine: Polynomial::taylor(Circular::Sine, order),
                    cosine: Polynomial::taylor(Circular::Cosine, order),
                    halvings: 0,
                };
                let of = |scheme| Recipe::new(&halved, [true; 2], &machine, scheme);
                let (short, horner) = (of(Scheme::Shortest), of(Scheme::Horner));
                let path = |recipe: &Recipe| critical_path(&recipe.function, &machine).asap_cycle;
                assert!(path(&short) <= path(&horner));
                assert!(short.operations() >= horner.operations());
                shorter += u32::from(path(&short) < path(&horner));
            }
            assert!(shorter > 10, "{name}: {shorter}");
        }
    }

    #[test]
    fn only_what_is_wanted_is_computed() {
        let halved = Halved {
            sine: Polynomial::taylor(Circular::Sine, 5),
            cosine: Polynomial::taylor(Circular::Cosine, 5),
            halvings: 0,
        };
        let machine = machine("thesis");
        let operations = |wanted| {
            let recipe = Recipe::new(&halved, wanted, &machine, Scheme::Horner);
            assert_eq!(
                recipe.results.map(Operand::is_none),
                wanted.map(|wanted| !wanted)
            );
            recipe.operations()
        };
        // The square; two products and two sums for each; the sine's factor.
        assert_eq!(operations([true, true]), 10);
        assert_eq!(operations([true, false]), 6);
        assert_eq!(operations([false, true]), 5);
    }

    #[test]
    fn small_formats_divide_the_angle_instead_of_coefficients() {
        let mut machine = machine("thesis");
        machine.number = "f16".parse().expect("a format");
        let halved = Halved {
            sine: Polynomial::taylor(Circular::Sine, 5),
            cosine: Polynomial::taylor(Circular::Cosine, 5),
            halvings: 3,
        };
        let recipe = Recipe::new(&halved, [true; 2], &machine, Scheme::Horner);
        assert!(recipe.function.constants().contains(&0.125));
        let exact = halved.at(Double::from(2.0));
        let found = results(&recipe, &DoubleDouble, 2.0);
        assert!((exact[0] - found[0]).high.abs() < 1e-28);
    }
}
