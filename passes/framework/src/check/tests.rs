//! The check accepts equal functions and detects different ones.

mod poles;

use super::*;
use robovec_ir::states::{Ranges, States};
use robovec_ir::{
    Function, Input, Level, Name, Node, Operand, Operation, Shape, SourceSet, Tables, Value,
    ValueFormats,
};
use std::sync::Arc;

/// Builds a function of inputs `x[1..4]` and outputs `y[1..4]`; every value
/// is named `v`, `v.1`, `v.2` … in order.
struct Builder {
    tables: Tables,
    function: Function,
}

impl Builder {
    fn new() -> Builder {
        let mut tables = Tables::default();
        let mut function = Function::new("sample", Level::Atomic);
        function.add_input(tables.symbols.intern("x"), Shape::Vector(4));
        function.add_output(tables.symbols.intern("y"), Shape::Vector(4));
        Builder { tables, function }
    }

    fn x(number: u32) -> Operand {
        Input(number - 1).into()
    }

    fn constant(&mut self, number: f64) -> Operand {
        self.function.constant(number).into()
    }

    fn unary(&mut self, operation: Operation, a: Operand) -> Operand {
        self.binary(operation, a, Operand::NONE)
    }

    fn binary(&mut self, operation: Operation, a: Operand, b: Operand) -> Operand {
        let name = Name {
            base: self.tables.symbols.intern("v"),
            suffix: self.function.nodes().len() as u32,
        };
        let node = Node {
            name,
            sources: SourceSet::EMPTY,
            operands: Operand::list([a, b]),
            operation,
        };
        self.function.push(node).into()
    }

    fn output(&mut self, number: u32, operand: Operand) {
        self.function
            .assign(Output(number - 1), operand, SourceSet::EMPTY);
    }

    fn view(&self) -> View<'_> {
        self.tables.view(&self.function)
    }
}

/// A function with the output `y[1]`, the result of `body`.
fn single(body: impl FnOnce(&mut Builder) -> Operand) -> Builder {
    let mut builder = Builder::new();
    let result = body(&mut builder);
    builder.output(1, result);
    builder
}

use Operation::{Add, Cos, Div, Mul, Neg, Sin, Sqrt, Sub};

fn verdict(before: &Builder, after: &Builder, class: NumericClass) -> CheckVerdict {
    check(before.view(), after.view(), class, &States::new(11), 3)
}

fn holds(before: &Builder, after: &Builder, class: NumericClass) -> bool {
    verdict(before, after, class).holds()
}

/// `(x1 + x2) + x3` and `x1 + (x2 + x3)`.
fn associated() -> [Builder; 2] {
    let left = single(|b| {
        let sum = b.binary(Add, Builder::x(1), Builder::x(2));
        b.binary(Add, sum, Builder::x(3))
    });
    let right = single(|b| {
        let sum = b.binary(Add, Builder::x(2), Builder::x(3));
        b.binary(Add, Builder::x(1), sum)
    });
    [left, right]
}

#[test]
fn reassociation_is_real_and_not_exact() {
    let [left, right] = associated();
    assert!(holds(&left, &right, NumericClass::Real));
    assert!(holds(&left, &right, NumericClass::RealTrig));
    assert!(holds(&left, &left, NumericClass::Exact));
    let verdict = check(
        left.view(),
        right.view(),
        NumericClass::Exact,
        &States::new(11),
        20,
    );
    let failure = verdict.failure.expect("some of 20 states round otherwise");
    assert!(matches!(failure.kind, FailureKind::Bits { .. }));
    assert_eq!(failure.name, "y[1]");
}

#[test]
fn operands_in_the_wrong_order_are_caught() {
    for operation in [Sub, Div] {
        let before = single(|b| b.binary(operation, Builder::x(1), Builder::x(2)));
        let after = single(|b| b.binary(operation, Builder::x(2), Builder::x(1)));
        assert!(!holds(&before, &after, NumericClass::Real));
    }
    let before = single(|b| b.binary(Mul, Builder::x(1), Builder::x(2)));
    let after = single(|b| b.binary(Mul, Builder::x(2), Builder::x(1)));
    assert!(holds(&before, &after, NumericClass::Exact));
}

#[test]
fn a_dropped_term_is_caught_and_the_culprit_named() {
    let body = |b: &mut Builder, complete: bool| {
        let product = b.binary(Mul, Builder::x(1), Builder::x(2));
        let third = if complete {
            Builder::x(3)
        } else {
            b.constant(0.0)
        };
        let sum = b.binary(Add, product, third);
        b.binary(Mul, sum, sum)
    };
    let before = single(|b| body(b, true));
    let after = single(|b| body(b, false));
    let verdict = verdict(&before, &after, NumericClass::Real);
    let failure = verdict.failure.as_ref().expect("a term is missing");
    assert_eq!(failure.slice_after.len(), 3);
    let (old, new) = failure.first_difference.as_ref().expect("the sum differs");
    assert_eq!(old, "%v.1 = %v + x[3]");
    assert_eq!(new, "%v.1 = %v + 0.0");
    assert!(verdict.to_string().contains("y[1] is another function"));
    assert!(verdict.errors.is_none());
}

#[test]
fn a_wrong_sign_is_caught_and_a_moved_one_accepted() {
    let before = single(|b| {
        let minus = b.unary(Neg, Builder::x(1));
        b.binary(Add, minus, Builder::x(2))
    });
    let moved = single(|b| b.binary(Sub, Builder::x(2), Builder::x(1)));
    let wrong = single(|b| b.binary(Add, Builder::x(2), Builder::x(1)));
    assert!(holds(&before, &moved, NumericClass::Exact));
    assert!(!holds(&before, &wrong, NumericClass::Real));
}

#[test]
fn zeros_of_either_sign_are_equal() {
    let zero_times = |negative: bool| {
        single(move |b| {
            let zero = b.constant(0.0);
            let product = b.binary(Mul, Builder::x(1), zero);
            if negative {
                b.unary(Neg, product)
            } else {
                b.binary(Sub, zero, product)
            }
        })
    };
    assert!(holds(
        &zero_times(true),
        &zero_times(false),
        NumericClass::Exact
    ));
}

#[test]
fn what_is_nan_may_become_a_number_and_not_the_reverse() {
    let nothing = |rooted: bool| {
        single(move |b| {
            let (zero, one) = (b.constant(0.0), b.constant(-9.0));
            let negative = b.binary(Add, Builder::x(1), one);
            let root = b.unary(Sqrt, negative);
            let product = b.binary(Mul, root, zero);
            let zero = if rooted { product } else { zero };
            b.binary(Add, Builder::x(2), zero)
        })
    };
    assert!(holds(&nothing(true), &nothing(false), NumericClass::Exact));
    assert!(!holds(&nothing(false), &nothing(true), NumericClass::Exact));
}

#[test]
fn the_circle_is_used_only_when_allowed() {
    let before = single(|b| {
        let sine = b.unary(Sin, Builder::x(1));
        let cosine = b.unary(Cos, Builder::x(1));
        let squares = [b.binary(Mul, sine, sine), b.binary(Mul, cosine, cosine)];
        b.binary(Add, squares[0], squares[1])
    });
    let after = single(|b| b.constant(1.0));
    assert!(!holds(&before, &after, NumericClass::Real));
    assert!(holds(&before, &after, NumericClass::RealTrig));
}

#[test]
fn division_by_zero_may_disappear_and_not_appear() {
    let quotient = |above: u32| {
        single(move |b| {
            let zero = b.binary(Sub, Builder::x(2), Builder::x(2));
            b.binary(Div, Builder::x(above), zero)
        })
    };
    let verdict = verdict(&quotient(1), &quotient(3), NumericClass::Real);
    assert!(verdict.holds());
    assert_eq!(verdict.undefined, 1);
    // One over infinity is a number again, and must be the same one.
    let inverse = |offset: f64| {
        single(move |b| {
            let zero = b.binary(Sub, Builder::x(2), Builder::x(2));
            let infinity = b.binary(Div, Builder::x(1), zero);
            let nothing = b.binary(Div, Builder::x(1), infinity);
            let offset = b.constant(offset);
            b.binary(Add, nothing, offset)
        })
    };
    assert!(holds(&inverse(1.0), &inverse(1.0), NumericClass::Real));
    assert!(!holds(&inverse(1.0), &inverse(2.0), NumericClass::Real));
    let defined = single(|b| b.binary(Mul, Builder::x(1), Builder::x(2)));
    assert!(holds(&quotient(1), &defined, NumericClass::Real));
    assert!(!holds(&defined, &quotient(1), NumericClass::Real));
}

#[test]
fn square_roots_are_equal_for_equal_arguments_only() {
    let root = |order: [u32; 2]| {
        single(move |b| {
            let sum = b.binary(Add, Builder::x(order[0]), Builder::x(order[1]));
            b.unary(Sqrt, sum)
        })
    };
    assert!(holds(&root([1, 2]), &root([2, 1]), NumericClass::Exact));
    assert!(!holds(&root([1, 2]), &root([1, 3]), NumericClass::Real));
}

#[test]
fn roots_of_squares_of_constants_are_their_sizes() {
    let product = |number: f64, squared: bool| {
        single(move |b| {
            let constant = b.constant(number);
            let factor = if squared {
                let negative = b.unary(Neg, constant);
                let square = b.binary(Mul, negative, negative);
                b.unary(Sqrt, square)
            } else {
                constant
            };
            b.binary(Mul, Builder::x(1), factor)
        })
    };
    for number in [0.1, 0.3, 0.7, 5.0, 11.0, 13.0, 9.81] {
        let [before, after] = [true, false].map(|squared| product(number, squared));
        let found = verdict(&before, &after, NumericClass::Real);
        assert!(found.holds(), "{number}: {:?}", found.failure);
        let [before, after] = [true, false].map(|squared| product(-number, squared));
        assert!(!holds(&before, &after, NumericClass::Real), "{number}");
    }
}

#[test]
fn roots_of_constants_multiply() {
    // 0.1 and 3 are squares modulo one prime in two; 0.2 is twice 0.1.
    let product = |numbers: [f64; 2]| {
        single(move |b| {
            let [first, second] = numbers.map(|number| b.constant(number));
            let roots = [first, second].map(|constant| b.unary(Sqrt, constant));
            let product = b.binary(Mul, roots[0], roots[1]);
            b.binary(Mul, product, Builder::x(1))
        })
    };
    let times = |number: f64| {
        single(move |b| {
            let constant = b.constant(number);
            b.binary(Mul, constant, Builder::x(1))
        })
    };
    let twice_root = single(|b| {
        let [two, three] = [2.0, 3.0].map(|number| b.constant(number));
        let root = b.unary(Sqrt, three);
        let product = b.binary(Mul, two, root);
        b.binary(Mul, product, Builder::x(1))
    });
    assert!(holds(&product([0.1, 0.1]), &times(0.1), NumericClass::Real));
    assert!(holds(&product([3.0, 3.0]), &times(3.0), NumericClass::Real));
    assert!(holds(&product([3.0, 4.0]), &twice_root, NumericClass::Real));
    assert!(!holds(
        &product([3.0, 2.0]),
        &times(2.0),
        NumericClass::Real
    ));
    assert!(!holds(
        &product([3.0, 3.0]),
        &times(-3.0),
        NumericClass::Real
    ));
}

#[test]
fn what_sinks_below_the_range_differs_from_nothing_else() {
    // A square of 10^-289 is zero in binary64, and not once it is multiplied
    // by 10^308: what is left of it must not be taken for a number.
    let chain = |large_first: bool| {
        single(move |b| {
            let [small, large] = [1e-289, 1e308].map(|number| b.constant(number));
            let x = b.binary(Mul, small, Builder::x(1));
            let rest = if large_first { large } else { x };
            let last = if large_first { x } else { large };
            let first = b.binary(Mul, x, rest);
            let scaled = b.binary(Mul, first, Builder::x(2));
            b.binary(Mul, scaled, last)
        })
    };
    assert!(holds(&chain(false), &chain(true), NumericClass::Real));
}

#[test]
fn what_a_promise_allows_beyond_the_range_is_not_lost() {
    // A cosine near one may be off by a half, and 1.06*1.7e308 overflows.
    let scaled = |series: bool| {
        single(move |b| {
            let [large, near] = [1.7e308, 1.06].map(|number| b.constant(number));
            let cosine = if series {
                b.binary(Mul, near, Builder::x(2))
            } else {
                let cosine = b.unary(Cos, Builder::x(1));
                b.binary(Mul, cosine, Builder::x(2))
            };
            b.binary(Mul, cosine, large)
        })
    };
    let mut ranges = Ranges::default();
    ranges.set("x", [1, 0], -0.1, 0.1);
    ranges.set("x", [2, 0], 1.0, 1.0);
    let promise = Promise::Waves {
        ranges: Arc::new(ranges),
        errors: [0.5; 2],
    };
    let [before, after] = [false, true].map(scaled);
    let claim = (NumericClass::Approximating, Some(&promise));
    let verdict = check_promise(before.view(), after.view(), claim, &States::new(1), 2);
    assert!(verdict.holds(), "{:?}", verdict.failure);
}

#[test]
fn holes_and_lost_values_are_differences() {
    let x = || single(|b| b.binary(Mul, Builder::x(1), Builder::x(2)));
    // (x1*x2)*(2*x3 - 1)/(2*x3 - 1) has a hole at a half.
    let hole = single(|b| {
        let [one, two] = [1.0, 2.0].map(|number| b.constant(number));
        let double = b.binary(Mul, two, Builder::x(3));
        let divisor = b.binary(Sub, double, one);
        let product = b.binary(Mul, Builder::x(1), Builder::x(2));
        let product = b.binary(Mul, product, divisor);
        b.binary(Div, product, divisor)
    });
    let found = verdict(&x(), &hole, NumericClass::Real);
    let failure = found.failure.expect("a hole is a difference");
    let kind = &failure.kind;
    assert!(
        matches!(kind, FailureKind::Pole(_) | FailureKind::Hole(_)),
        "{failure:?}"
    );
    // x1*x2 + 0*sqrt(x3) is lost for negative x3.
    let lost = single(|b| {
        let zero = b.constant(0.0);
        let root = b.unary(Sqrt, Builder::x(3));
        let nothing = b.binary(Mul, zero, root);
        let product = b.binary(Mul, Builder::x(1), Builder::x(2));
        b.binary(Add, product, nothing)
    });
    assert!(!holds(&x(), &lost, NumericClass::Real));
    // x1*x2/(x3 - x3) is defined nowhere.
    let nowhere = single(|b| {
        let nothing = b.binary(Sub, Builder::x(3), Builder::x(3));
        let product = b.binary(Mul, Builder::x(1), Builder::x(2));
        b.binary(Div, product, nothing)
    });
    assert!(!holds(&x(), &nowhere, NumericClass::Real));
}

#[test]
fn the_fields_alone_see_what_is_defined_nowhere() {
    let product = single(|b| b.binary(Mul, Builder::x(1), Builder::x(2)));
    let nowhere = single(|b| {
        let nothing = b.binary(Sub, Builder::x(3), Builder::x(3));
        let product = b.binary(Mul, Builder::x(1), Builder::x(2));
        b.binary(Div, product, nothing)
    });
    let pairs = Pairs::new(product.view(), nowhere.view())
        .ok()
        .expect("they pair");
    let found = field::compare::<PrimeField>(&pairs, 8, 3);
    assert!(!matches!(found, FieldComparison::Equal { .. }));
}

#[test]
fn primes_follow_the_constants_of_both_versions() {
    let with = |number: f64| {
        single(move |b| {
            let constant = b.constant(number);
            b.binary(Mul, constant, Builder::x(1))
        })
    };
    let primes = |before: &Builder, after: &Builder| {
        let pairs = Pairs::new(before.view(), after.view())
            .ok()
            .expect("they pair");
        pairs.primes(3)
    };
    let usual = primes(&with(2.5), &with(2.5));
    assert_eq!(usual, primes(&with(2.5), &with(2.5)));
    assert_ne!(usual, primes(&with(2.5), &with(3.5)));
    assert_ne!(usual, primes(&with(3.5), &with(2.5)));
}

#[test]
fn formats_of_values_are_compared_in_every_class() {
    let product = |format: Option<&str>| {
        let mut product = single(|b| b.binary(Mul, Builder::x(1), Builder::x(2)));
        if let Some(format) = format {
            let mut formats = ValueFormats::new(1);
            formats.set(Value(0), Some(format.parse().expect("it is one")));
            product.function.formats = Some(formats);
        }
        product
    };
    let plain = product(None);
    for class in [NumericClass::Exact, NumericClass::Real] {
        assert!(holds(&product(Some("f16")), &product(Some("f16")), class));
        assert!(!holds(&product(Some("f16")), &product(Some("f32")), class));
        assert!(!holds(&plain, &product(Some("f16")), class));
    }
}

#[test]
fn an_approximation_is_measured() {
    let before = single(|b| b.unary(Cos, Builder::x(1)));
    let after = single(|b| {
        let (one, half) = (b.constant(1.0), b.constant(0.5));
        let square = b.binary(Mul, Builder::x(1), Builder::x(1));
        let half = b.binary(Mul, half, square);
        b.binary(Sub, one, half)
    });
    assert!(!holds(&before, &after, NumericClass::RealTrig));
    let verdict = check(
        before.view(),
        after.view(),
        NumericClass::Approximating,
        &States::new(1),
        20,
    );
    let deviation = verdict.deviation.expect("approximations are measured");
    // Inputs called `x` lie within ±1, where the series is off by x⁴/24.
    assert!(deviation.worst_relative < 0.1 && deviation.worst_relative > 1e-4);
    assert_eq!(deviation.output, Some(Output(0)));
    assert!(verdict.holds());
}

#[test]
fn other_signatures_and_missing_outputs_are_refused() {
    let one = single(|_| Builder::x(1));
    let mut two = single(|_| Builder::x(1));
    two.output(2, Builder::x(2));
    let reason =
        |before: &Builder, after: &Builder| verdict(before, after, NumericClass::Real).to_string();
    assert_eq!(reason(&two, &one), "not real: y[2] is no longer set");
    assert!(reason(&one, &two).contains("y[2] is set, and was not before"));
    let mut other = single(|_| Builder::x(1));
    let symbol = other.tables.symbols.intern("z");
    other.function.add_input(symbol, Shape::Scalar);
    assert!(reason(&one, &other).contains("the input array z"));
}

#[test]
fn errors_are_reported_before_and_after() {
    // Subtracting a large number from two sums of which one has absorbed it.
    let sum = |large_first: bool| {
        single(move |b| {
            let large = b.constant(1e6);
            let small = b.binary(Add, Builder::x(1), Builder::x(2));
            if large_first {
                let sum = b.binary(Add, small, large);
                b.binary(Sub, sum, large)
            } else {
                let zero = b.binary(Sub, large, large);
                b.binary(Add, small, zero)
            }
        })
    };
    let verdict = verdict(&sum(true), &sum(false), NumericClass::Real);
    let [narrow, wide] = verdict.errors.expect("the functions are equal");
    assert!(narrow.before.worst_normwise > 1e-3 && narrow.after.worst_normwise < 1e-7);
    assert!(wide.before.worst_normwise < 1e-8 && wide.after.worst_normwise == 0.0);
}

#[test]
fn rounding_a_constant_of_an_angle_is_a_difference() {
    // sin(2^60 - x) for a small x is another number for the rounded constant,
    // and one that differs by rounding alone for 0.1 + 0.2.
    let function = |[a, b]: [f64; 2], known: bool| {
        single(move |builder| {
            let [a, b] = [a, b].map(|number| builder.constant(number));
            let angle = if known {
                let (a, b) = (builder.function.number(a), builder.function.number(b));
                let sum = a.zip(b).map(|(a, b)| a + b).expect("constants");
                builder.constant(sum)
            } else {
                builder.binary(Add, a, b)
            };
            let sine = builder.unary(Sin, angle);
            builder.binary(Mul, Builder::x(1), sine)
        })
    };
    let verdict = |constants| {
        let [witness, after] = [false, true].map(|known| function(constants, known));
        let subject = Specialised {
            before: witness.view(),
            witness: witness.view(),
            after: after.view(),
            scene: None,
        };
        check_specialised(subject, NumericClass::Real, &States::new(3), 4)
    };
    let moved = verdict([0.1, 0.2]).moved.expect("a constant was rounded");
    assert!(moved > 0.0 && moved < 1e-15, "{moved:e}");
    let failure = verdict([60f64.exp2(), -0.7]).failure.expect("it moves far");
    assert!(
        matches!(failure.kind, FailureKind::Constants { .. }),
        "{failure}"
    );
}
