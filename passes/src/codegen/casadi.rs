//! The functions of CasADi's interface: the function with vectors in place of
//! matrices, and its derivatives.

use robovec_cgen::c::Options;
use robovec_cgen::c::layout::{self, ElementOrder};
use robovec_cgen::casadi::{CasadiArray, CasadiFunction, CasadiRole};
use robovec_framework::manager::{self, Config};
use robovec_framework::option_words;
use robovec_framework::pass::{Artifact, Context, PassError};
use robovec_framework::rewrite::without_dead;
use robovec_ir::{Array, Function, Input, Level, Module, Output, Shape, Tables, places_by_name};

option_words! {
    /// Derivatives that are written beside a function.
    pub enum DerivativeOrder {
        /// None.
        None = "none",
        /// Jacobian, and its products from either side.
        First = "first",
        /// Those of the first order, and the same of the product with weights.
        Second = "second",
    }
}

/// Writes the file for CasADi.
pub(super) fn file(
    function: &Function,
    order: DerivativeOrder,
    options: &Options,
    context: &mut Context<'_>,
) -> Result<Artifact, PassError> {
    let symbols = &context.tables.symbols;
    let arrays = |arrays: &[Array]| -> Vec<CasadiArray> {
        let array = |array: &Array| CasadiArray {
            name: symbols.text(array.name).to_owned(),
            extents: layout::extents(array.shape),
        };
        arrays.iter().map(array).collect()
    };
    let given = GivenJacobians::new(function, context.tables);
    let is_block = |array: &Array| {
        let mut outputs = function.outputs().iter().zip(&given.is_block);
        outputs.any(|(output, is_block)| output.name == array.name && *is_block)
    };
    let plain = only(function, |output| !is_block(output));
    let (inputs, outputs) = (arrays(plain.inputs()), arrays(plain.outputs()));
    let values = column_vectors(&plain, &vec![false; outputs.len()]);
    let mut parts = Vec::new();
    let has_derivatives = plain.input_len() > 0 && plain.output_len() > 0;
    if order != DerivativeOrder::None && has_derivatives {
        let whole = column_vectors(function, &given.is_block);
        let jacobian = jacobian(context, &whole, &given)?;
        let forward = derivative(context, &values, "direction")?;
        let adjoint = derivative(context, &values, "gradient")?;
        if order == DerivativeOrder::Second {
            let along = with_other_directions(&forward, values.inputs(), context.tables);
            for (role, of, result) in [
                (CasadiRole::AdjointJacobian, &adjoint, "jacobian"),
                (CasadiRole::AdjointForward, &adjoint, "direction"),
                (CasadiRole::JacobianForward, &jacobian, "direction"),
                (CasadiRole::JacobianAdjoint, &jacobian, "gradient"),
                (CasadiRole::ForwardForward, &along, "direction"),
                (CasadiRole::ForwardAdjoint, &along, "gradient"),
            ] {
                parts.push((role, derivative(context, of, result)?));
            }
        }
        parts.push((CasadiRole::Jacobian, jacobian));
        parts.push((CasadiRole::Forward, forward));
        parts.push((CasadiRole::Adjoint, adjoint));
    }
    parts.push((CasadiRole::Values, values));
    parts.sort_by_key(|(role, _)| *role);
    let file = CasadiFunction {
        name: function.name.clone(),
        inputs,
        outputs,
        parts,
    };
    let (name, text) = file.file(context.tables, options);
    Ok(Artifact { name, text })
}

/// The outputs of a function that are Jacobians of others, named as
/// `differentiate` names them: `F_x`.
struct GivenJacobians {
    /// For every output array: true if it is a Jacobian.
    is_block: Vec<bool>,
    /// The inputs by which every other output has one.
    by: Vec<usize>,
}

impl GivenJacobians {
    fn new(function: &Function, tables: &Tables) -> GivenJacobians {
        let text = |array: &Array| tables.symbols.text(array.name);
        let (inputs, outputs) = (function.inputs(), function.outputs());
        let named = |y: &Array, x: &Array| {
            let name = format!("{}_{}", text(y), text(x));
            let shape = match (y.shape, x.shape) {
                (Shape::Vector(rows), Shape::Vector(columns)) => Shape::Matrix(rows, columns),
                _ => return None,
            };
            outputs
                .iter()
                .position(|block| text(block) == name && block.shape == shape)
        };
        let mut is_block = vec![false; outputs.len()];
        for (y, x) in outputs
            .iter()
            .flat_map(|y| inputs.iter().map(move |x| (y, x)))
        {
            if let Some(block) = named(y, x) {
                is_block[block] = true;
            }
        }
        let plain = || {
            outputs
                .iter()
                .zip(&is_block)
                .filter(|(_, is_block)| !**is_block)
        };
        let given = |x: &Array| plain().count() > 0 && plain().all(|(y, _)| named(y, x).is_some());
        let by = (0..inputs.len()).filter(|&x| given(&inputs[x])).collect();
        GivenJacobians { is_block, by }
    }
}

/// The derivative of all outputs by all inputs, without the outputs.
fn derivative(
    context: &mut Context<'_>,
    function: &Function,
    result: &str,
) -> Result<Function, PassError> {
    let step = format!("atomise,differentiate{{result={result} values=false}}");
    made(context, function.clone(), &format!("{step},{SHORTEN}"))
}

/// The Jacobian: the blocks that the function gives, and derivatives of its
/// outputs by the other inputs.
fn jacobian(
    context: &mut Context<'_>,
    function: &Function,
    given: &GivenJacobians,
) -> Result<Function, PassError> {
    let text = |array: &Array| context.tables.symbols.text(array.name).to_owned();
    let outputs = function.outputs().iter().zip(&given.is_block);
    let of = outputs.filter(|(_, is_block)| !**is_block);
    let of: Vec<String> = of.map(|(array, _)| text(array)).collect();
    let by: Vec<String> = function.inputs().iter().map(text).collect();
    let missing = (0..by.len()).filter(|x| !given.by.contains(x));
    let missing: Vec<&str> = missing.map(|x| by[x].as_str()).collect();
    // A block that only some outputs have is made anew.
    let is_kept = |output: &Array| {
        let name = text(output);
        let is_given = |x: &usize| of.iter().any(|y| name == format!("{y}_{}", by[*x]));
        of.contains(&name) || given.by.iter().any(is_given)
    };
    let mut whole = only(function, is_kept);
    if !missing.is_empty() {
        let (of, by) = (of.join("+"), missing.join("+"));
        let step = format!("atomise,differentiate{{of={of} by={by}}}");
        whole = made(context, whole, &step)?;
    }
    let blocks = of
        .iter()
        .flat_map(|y| by.iter().map(move |x| format!("{y}_{x}")));
    let symbols = &context.tables.symbols;
    let ordered = blocks.map(|name| {
        let mut outputs = whole.outputs().iter();
        let found = outputs.find(|output| symbols.text(output.name) == name);
        *found.expect("every block is given or made")
    });
    let ordered = with_outputs(&whole, &ordered.collect::<Vec<Array>>());
    made(context, ordered, SHORTEN)
}

/// The function after a pipeline of the registry of which every step is proved.
fn made(
    context: &mut Context<'_>,
    function: Function,
    passes: &str,
) -> Result<Function, PassError> {
    let pipeline = context.registry.pipeline(passes);
    let pipeline = pipeline.map_err(|error| PassError::new(error.to_string()))?;
    let mut module = Module {
        tables: std::mem::take(context.tables),
        functions: vec![function],
    };
    let mut log = std::io::sink();
    let config = Config {
        rules: Some(context.rules),
        check_each: Some(POINTS),
        remarks: false,
        records: false,
        ..Config::new(context.machine, &mut log)
    };
    let outcome = manager::run(&mut module, &pipeline, config);
    *context.tables = module.tables;
    outcome.map_err(|error| PassError::new(error.to_string()))?;
    Ok(module.functions.remove(0))
}

/// Points at which every step of a derivative is checked.
const POINTS: u32 = 2;

/// The passes that shorten a derivative.
const SHORTEN: &str = "fold,cse,dce,$cpu";

/// The function with the output arrays that are wanted, and what they need.
fn only(function: &Function, is_wanted: impl Fn(&Array) -> bool) -> Function {
    let outputs = function.outputs().iter().copied();
    let outputs: Vec<Array> = outputs.filter(is_wanted).collect();
    with_outputs(function, &outputs)
}

/// The function with some of its output arrays, in this order.
fn with_outputs(function: &Function, outputs: &[Array]) -> Function {
    let inputs = function.inputs().iter().map(Array::declaration);
    let new = header(function).with_arrays(inputs, outputs.iter().map(Array::declaration));
    let places = places_by_name(function.outputs(), new.outputs());
    let place = |output: Output| places[output.index()].map(Output);
    without_dead(function.moved_into(new, |input| input, place))
}

/// The function with vectors for all arrays but Jacobians: matrices column by
/// column, scalars as one element.
fn column_vectors(function: &Function, is_block: &[bool]) -> Function {
    let vector = |array: &Array| (array.name, Shape::Vector(array.shape.len() as u32));
    let outputs = function.outputs().iter().zip(is_block);
    let outputs = outputs.map(|(array, is_block)| match is_block {
        true => array.declaration(),
        false => vector(array),
    });
    let new = header(function).with_arrays(function.inputs().iter().map(vector), outputs);
    let moved = |array: &Array, element: u32| {
        array.offset + layout::place(array, element - array.offset, ElementOrder::Column)
    };
    function.moved_into(
        new,
        |input| Input(moved(function.input_element(input).0, input.0)),
        |output| match function.output_array(output) {
            array if is_block[array] => Some(output),
            array => Some(Output(moved(&function.outputs()[array], output.0))),
        },
    )
}

/// The function with other names for the inputs after those of a function, which
/// are directions, so that it has directions again.
fn with_other_directions(function: &Function, inputs: &[Array], tables: &mut Tables) -> Function {
    let named = function.inputs().iter().enumerate().map(|(number, array)| {
        let name = match number < inputs.len() {
            true => array.name,
            false => {
                let name = format!("{}_first", tables.symbols.text(array.name));
                tables.symbols.intern(&name)
            }
        };
        (name, array.shape)
    });
    let outputs = function.outputs().iter().map(Array::declaration);
    let new = header(function).with_arrays(named, outputs);
    function.moved_into(new, |input| input, Some)
}

/// The start of the function with other arrays; a schedule is gone.
fn header(function: &Function) -> Function {
    function.header(function.level.min(Level::Atomic))
}
