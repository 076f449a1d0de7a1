//! The example model obeys mechanics: its files agree with one another in all
//! languages, the two dynamics agree, and the derivatives are derivatives.

use robovec::robotran::{Language, read};
use robovec_ir::evaluate::evaluate;
use robovec_ir::print::print_output;
use robovec_ir::{Input, Module, View};
use robovec_num::arithmetic::Binary64;
use std::collections::BTreeMap;
use std::path::Path;

/// Numbers by element name: `q[3]`, `dpt[3,1]`.
type Numbers = BTreeMap<String, f64>;

const EXTENSIONS: [&str; 3] = ["c", "m", "py"];
const KINDS: [&str; 7] = [
    "dirdyna",
    "invdyna",
    "cons_hJ",
    "cons_jdqd",
    "link",
    "extforces",
    "sensor",
];

fn example(kind: &str, extension: &str) -> Module {
    let name = format!("mbs_{kind}_suspension.{extension}");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/suspension");
    let bytes = std::fs::read(folder.join(&name)).expect("the example exists");
    let read = read(&name, &bytes, None).expect("the example is good");
    assert!(read.warnings.is_empty(), "{}", read.warnings.render_plain());
    read.module
}

fn element(module: &Module, function: usize, input: u32) -> String {
    let (array, indices, rank) = module.functions[function].input_element(Input(input));
    let indices: Vec<String> = indices[..rank].iter().map(u32::to_string).collect();
    let name = module.tables.symbols.text(array.name);
    if rank == 0 {
        name.to_owned()
    } else {
        format!("{name}[{}]", indices.join(","))
    }
}

/// Evaluates all functions; an input without a number gets one that depends on
/// its name alone.
fn outputs(module: &Module, state: &Numbers) -> Numbers {
    let mut found = Numbers::new();
    for (index, function) in module.functions.iter().enumerate() {
        let inputs: Vec<f64> = (0..function.input_len() as u32)
            .map(|input| {
                let name = element(module, index, input);
                state.get(&name).copied().unwrap_or_else(|| invented(&name))
            })
            .collect();
        let view = View {
            tables: &module.tables,
            function,
        };
        let numbers = evaluate(function, &Binary64, &inputs);
        for (assignment, number) in function.assignments.iter().zip(numbers) {
            let name = format!(
                "{} {}",
                function.name,
                print_output(view, assignment.output)
            );
            found.insert(name, number);
        }
    }
    found
}

fn invented(name: &str) -> f64 {
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325, mix);
    0.25 + (hash >> 40) as f64 / f64::from(1 << 24)
}

fn get(numbers: &Numbers, name: &str) -> f64 {
    numbers.get(name).copied().unwrap_or(0.0)
}

fn close(left: f64, right: f64, tolerance: f64, what: &str) {
    assert!(
        (left - right).abs() <= tolerance * (1.0 + left.abs()),
        "{what}: {left} and {right}"
    );
}

#[test]
fn the_languages_agree_bit_for_bit() {
    for kind in KINDS {
        let all = EXTENSIONS.map(|extension| outputs(&example(kind, extension), &Numbers::new()));
        assert!(all[0].len() > 1, "{kind} computes something");
        for other in &all[1..] {
            assert_eq!(all[0].len(), other.len(), "{kind}");
            for ((left, a), (right, b)) in all[0].iter().zip(other) {
                assert_eq!((left, a.to_bits()), (right, b.to_bits()), "{kind}");
            }
        }
    }
}

#[test]
fn the_metadata_name_the_language() {
    for (extension, language) in EXTENSIONS.into_iter().zip(Language::ALL) {
        let named = example("dirdyna", extension);
        let metadata = named.functions[0].metadata("language");
        assert_eq!(metadata, Some(language.name()));
    }
}

#[test]
fn direct_and_inverse_dynamics_agree() {
    let state = Numbers::new();
    let direct = outputs(&example("dirdyna", "m"), &state);
    let inverse = outputs(&example("invdyna", "m"), &state);
    for i in 1..=5 {
        let inertia: f64 = (1..=5)
            .map(|j| get(&direct, &format!("dirdyna M[{i},{j}]")) * invented(&format!("qdd[{j}]")))
            .sum();
        let expected = inertia + get(&direct, &format!("dirdyna c[{i}]"));
        close(
            expected,
            get(&inverse, &format!("invdyna Qq[{i}]")),
            1e-13,
            &format!("Qq[{i}]"),
        );
    }
}

#[test]
fn the_mass_matrix_is_symmetric() {
    let direct = outputs(&example("dirdyna", "m"), &Numbers::new());
    for i in 1..=5 {
        for j in 1..i {
            let upper = get(&direct, &format!("dirdyna M[{j},{i}]"));
            let lower = get(&direct, &format!("dirdyna M[{i},{j}]"));
            assert_eq!(upper.to_bits(), lower.to_bits(), "M[{i},{j}]");
        }
    }
}

/// The state moved by `q += t qd`.
fn moved(t: f64) -> Numbers {
    let joint = |j: u32| {
        let position = invented(&format!("q[{j}]")) + t * invented(&format!("qd[{j}]"));
        (format!("q[{j}]"), position)
    };
    (1..=5).map(joint).collect()
}

#[test]
fn the_jacobian_is_the_derivative_of_the_constraints() {
    let module = example("cons_hJ", "c");
    let here = outputs(&module, &Numbers::new());
    let step = 1e-6;
    for j in 1..=5 {
        let name = format!("q[{j}]");
        let at = |t: f64| {
            outputs(
                &module,
                &Numbers::from([(name.clone(), invented(&name) + t)]),
            )
        };
        let (after, before) = (at(step), at(-step));
        for k in 1..=2 {
            let row = format!("cons_hJ h[{k}]");
            let difference = (get(&after, &row) - get(&before, &row)) / (2.0 * step);
            let entry = get(&here, &format!("cons_hJ Jac[{k},{j}]"));
            close(entry, difference, 1e-8, &format!("Jac[{k},{j}]"));
        }
    }
}

#[test]
fn the_quadratic_terms_are_the_second_derivative_of_the_constraints() {
    let constraints = example("cons_hJ", "py");
    let terms = outputs(&example("cons_jdqd", "py"), &Numbers::new());
    let step = 1e-4;
    let along = |t: f64| outputs(&constraints, &moved(t));
    let (before, here, after) = (along(-step), along(0.0), along(step));
    for k in 1..=2 {
        let row = format!("cons_hJ h[{k}]");
        let second = get(&before, &row) - 2.0 * get(&here, &row) + get(&after, &row);
        let expected = second / (step * step);
        close(
            get(&terms, &format!("cons_jdqd Jdqd[{k}]")),
            expected,
            1e-6,
            &format!("Jdqd[{k}]"),
        );
    }
}

#[test]
fn the_sensor_moves_as_its_jacobian_says() {
    let sensors = outputs(&example("sensor", "c"), &Numbers::new());
    for case in [1, 2] {
        for (rows, field) in [(1..=3, "V"), (4..=6, "OM")] {
            for row in rows {
                let velocity: f64 = (1..=5)
                    .map(|j| {
                        let entry = format!("sensor_{case} sens.J[{row},{j}]");
                        get(&sensors, &entry) * invented(&format!("qd[{j}]"))
                    })
                    .sum();
                let component = if row > 3 { row - 3 } else { row };
                let name = format!("sensor_{case} sens.{field}[{component}]");
                close(get(&sensors, &name), velocity, 1e-13, &name);
            }
        }
    }
}
