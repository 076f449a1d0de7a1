//! A function together with its Jacobians, where separate recursions give these
//! with fewer operations than the derivative of the function has.
//!
//! | function | Jacobians | from |
//! |---|---|---|
//! | `invdyna` | `Qq_q`, `Qq_qd` | `invdyna_d` |
//! | | `Qq_qdd` | the mass matrix of `dirdyna` |
//! | `accelred` without loops | `qdd_q`, `qdd_qd`, `qdd_Qq` | `accel_d` |

use super::{Formulation, GenerateError, GenerationRequest, generate_into};
use robovec_framework::rewrite::without_dead;
use robovec_ir::{
    Array, Assignment, Function, Input, Level, Module, Node, Operand, OperandKind, Output, Symbol,
};
use robovec_model::Model;
use robovec_robotran::FunctionKind;

/// A function of a model with its Jacobians as further outputs, named as the
/// pass `differentiate` names them: `Qq_q`. Functions without a recursion for
/// their Jacobians are as [`generate`](super::generate) makes them.
pub fn with_jacobians(model: &Model, request: &GenerationRequest) -> Result<Module, GenerateError> {
    let mut module = Module::new();
    with_jacobians_into(&mut module, model, request)?;
    Ok(module)
}

/// Does as [`with_jacobians`], and adds the function to a module.
pub fn with_jacobians_into(
    module: &mut Module,
    model: &Model,
    request: &GenerationRequest,
) -> Result<(), GenerateError> {
    let first = module.functions.len();
    generate_into(module, model, request)?;
    let (further, renamed): (&[_], _) = match request.function {
        FunctionKind::Invdyna => (
            &[
                (FunctionKind::InvdynaD, request.formulation),
                (FunctionKind::Dirdyna, Formulation::Composite),
            ],
            Some(("M", "Qq_qdd")),
        ),
        FunctionKind::Accelred if model.cuts.is_empty() => {
            (&[(FunctionKind::AccelD, request.formulation)], None)
        }
        _ => return Ok(()),
    };
    for &(function, formulation) in further {
        let request = GenerationRequest {
            function,
            formulation,
            options: request.options.clone(),
        };
        generate_into(module, model, &request)?;
    }
    join(module, first, renamed);
    Ok(())
}

/// Makes the functions of a module from a first one on one with the name of the
/// first. Inputs of the same name are one; outputs of the others are kept whose
/// names begin with one of the first's and `_`, after one is renamed.
fn join(module: &mut Module, first: usize, renamed: Option<(&str, &str)>) {
    let symbols = &mut module.tables.symbols;
    let renamed = renamed.map(|(old, new)| (symbols.intern(old), symbols.intern(new)));
    let mut functions = module.functions.drain(first..);
    let mut whole = functions.next().expect("a function was generated");
    let own: Vec<String> = whole
        .outputs()
        .iter()
        .map(|array| symbols.text(array.name).to_owned())
        .collect();
    let is_jacobian = |name: Symbol| {
        let name = symbols.text(name);
        own.iter().any(|own| {
            name.strip_prefix(own.as_str())
                .is_some_and(|rest| rest.starts_with('_'))
        })
    };
    let name = |array: &Array| match renamed {
        Some((old, new)) if array.name == old => new,
        _ => array.name,
    };
    for function in functions.by_ref() {
        let kept = function.outputs().iter().copied();
        let kept: Vec<Array> = kept.filter(|array| is_jacobian(name(array))).collect();
        whole = appended(whole, &function, &kept, name);
    }
    drop(functions);
    module.functions.push(without_dead(whole));
}

/// A function and, after it, another one, of which some outputs are kept.
fn appended(
    mut whole: Function,
    other: &Function,
    kept: &[Array],
    name: impl Fn(&Array) -> Symbol,
) -> Function {
    assert!(
        whole.level == Level::Equations && other.level == Level::Equations,
        "both are generated"
    );
    let places: Vec<u32> = (other.inputs().iter())
        .map(|input| {
            let known = whole
                .inputs()
                .iter()
                .find(|known| known.name == input.name)
                .copied();
            let array = known.unwrap_or_else(|| whole.add_input(input.name, input.shape));
            assert_eq!(
                array.shape, input.shape,
                "arrays of one name have one shape"
            );
            array.offset
        })
        .collect();
    let first = whole.nodes().len() as u32;
    let mut names = whole.fresh_names();
    let operand = |whole: &mut Function, operand: Operand| match operand.kind() {
        OperandKind::Input(input) => {
            let array = other.input_array(input);
            Input(places[array] + input.0 - other.inputs()[array].offset).into()
        }
        OperandKind::Constant(constant) => whole.constant(other.constant_number(constant)).into(),
        OperandKind::Value(value) => robovec_ir::Value(value.0 + first).into(),
        OperandKind::None => operand,
    };
    for node in other.nodes() {
        let name = match node.name.is_none() {
            true => node.name,
            false => names.fresh(node.name.base),
        };
        let operands = node.operands.map(|old| operand(&mut whole, old));
        whole.push(Node {
            name,
            operands,
            ..*node
        });
    }
    for array in kept {
        let made = whole.add_output(name(array), array.shape);
        let elements = array.offset..array.offset + array.shape.len() as u32;
        for set in other
            .assignments
            .iter()
            .filter(|set| elements.contains(&set.output.0))
        {
            let operand = operand(&mut whole, set.operand);
            whole.assignments.push(Assignment {
                output: Output(set.output.0 - array.offset + made.offset),
                operand,
                ..*set
            });
        }
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use robovec_framework::manager::{self, Config};
    use robovec_ir::Machine;
    use robovec_ir::evaluate::evaluate;
    use robovec_model::family;
    use robovec_num::arithmetic::Binary64;
    use robovec_num::random::Random;
    use robovec_passes::registry::REGISTRY;

    /// The output arrays of a function at a state, by their names.
    fn arrays(module: &Module, inputs: &[f64]) -> Vec<(String, Vec<f64>)> {
        let function = &module.functions[0];
        let mut numbers = vec![0.0; function.output_len()];
        let found = evaluate(function, &Binary64, inputs);
        for (set, number) in function.assignments.iter().zip(found) {
            numbers[set.output.index()] = number;
        }
        let arrays = function.outputs().iter().map(|array| {
            let first = array.offset as usize;
            let name = module.tables.symbols.text(array.name).to_owned();
            (name, numbers[first..first + array.shape.len()].to_vec())
        });
        arrays.collect()
    }

    /// The Jacobians are those that the function has as it is differentiated.
    #[test]
    fn jacobians_of_recursions_are_derivatives_of_the_function() {
        let machine = Machine::built_in("thesis").expect("it ships");
        let passes = REGISTRY.pipeline("atomise,differentiate").expect("passes");
        let mut random = Random::new(5);
        let mut compared = 0;
        for name in [
            "double-pendulum",
            "quarter-car",
            "leg",
            "serial-5",
            "semi-serial-9",
        ] {
            let model = family::built_in(name).expect("it ships");
            for function in [FunctionKind::Invdyna, FunctionKind::Accelred] {
                let request = GenerationRequest::new(function);
                let whole = with_jacobians(&model, &request).expect("it is generated");
                let mut plain = super::super::generate(&model, &request).expect("it is generated");
                let mut log = std::io::sink();
                let config = Config::new(&machine, &mut log);
                manager::run(&mut plain, &passes, config).expect("it is differentiated");
                let symbols = |module: &Module| -> Vec<String> {
                    let inputs = module.functions[0].inputs().iter();
                    inputs
                        .map(|array| module.tables.symbols.text(array.name).to_owned())
                        .collect()
                };
                assert_eq!(symbols(&whole), symbols(&plain), "{name}");
                let inputs: Vec<f64> = (0..whole.functions[0].input_len())
                    .map(|_| 0.5 + random.unit())
                    .collect();
                let wanted = arrays(&plain, &inputs);
                for (array, found) in arrays(&whole, &inputs) {
                    let (_, wanted) = wanted
                        .iter()
                        .find(|(known, _)| *known == array)
                        .expect("it is there");
                    let size = wanted
                        .iter()
                        .fold(1.0, |most: f64, number| most.max(number.abs()));
                    for (a, b) in found.iter().zip(wanted) {
                        assert!((a - b).abs() <= 1e-9 * size, "{name} {array}: {a} {b}");
                    }
                    compared += 1;
                }
            }
        }
        // Values and three Jacobians each; the leg has loops, which leave accelerations alone.
        assert_eq!(compared, 37);
    }
}
