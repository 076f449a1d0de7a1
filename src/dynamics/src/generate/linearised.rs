//! Derivatives of accelerations with closed loops, and the linear system near
//! a state.
//!
//! With loops, accelerations are written as a function of independent joints:
//! the positions of dependent joints after one round of Newton's method, their
//! velocities, then the reduced accelerations. Where the loops are closed the
//! round changes nothing, and its derivative by the dependent positions is
//! zero, so that the derivative of the whole by the independent joints is that
//! along the motions that the loops allow: `dq_v = -Jv^-1 Ju dq_u`, exactly. It
//! is taken by the pass `differentiate`. Without loops [`super::sensitivity`]
//! has closed formulas.

use super::closing::Closing;
use super::constraints::ConstraintPart;
use super::equations::Equations;
use super::frames::ModelFrames;
use super::lower::Extents;
use super::parameters::ModelParameters;
use super::{
    GenerateError, GenerationRequest, formulation, independent_joints, parameters, sensitivity,
};
use hashbrown::HashSet;
use robovec_framework::differentiation;
use robovec_framework::manager::{self, Config};
use robovec_ir::{
    Array, Assignment, Function, Input, Machine, Module, Name, Operand, Output, Shape, SourceSet,
    Symbol, Value, places_by_name,
};
use robovec_model::Model;
use robovec_passes::registry::REGISTRY;
use robovec_robotran::FunctionKind;

/// Inputs that accelerations are differentiated by.
const INPUTS: [&str; 3] = ["q", "qd", "Qq"];

/// Names of their derivatives.
const DERIVATIVES: [&str; 3] = ["qdd_q", "qdd_qd", "qdd_Qq"];

/// Writes the derivatives of accelerations of an open model, or the
/// accelerations of one with loops.
pub(super) fn write(
    equations: &mut Equations,
    frames: &ModelFrames<'_>,
    parameters: &ModelParameters<'_>,
    request: &GenerationRequest,
) -> Result<(), GenerateError> {
    let options = &request.options;
    if options.user_constraints > 0 {
        return Err(GenerateError::UserDerivatives {
            function: request.function.name(),
        });
    }
    if frames.source.cuts.is_empty() {
        return sensitivity::forward(equations, parameters, options);
    }
    let part = ConstraintPart::Position;
    let closing = Closing::new(equations, parameters, options, part)?;
    for (joint, position) in closing.positions(equations)? {
        equations.bind("q", &[joint + 1], position);
    }
    let closed = parameters::of(frames, request, equations);
    let closing = Closing::new(equations, &closed, options, part)?;
    for (joint, velocity) in closing.velocities(equations)? {
        equations.bind("qd", &[joint + 1], velocity);
    }
    let moving = parameters::of(frames, request, equations);
    formulation::accelerations(equations, &moving, request)
}

/// Makes the function that was requested of the one that [`write`] gave, the
/// last of a module.
pub(super) fn finish(
    module: &mut Module,
    model: &Model,
    request: &GenerationRequest,
) -> Result<(), GenerateError> {
    let is_linear = request.function == FunctionKind::Linear;
    if model.cuts.is_empty() && !is_linear {
        return Ok(());
    }
    // Passes run over a module that holds nothing else.
    let mut own = Module::new();
    std::mem::swap(&mut own.tables, &mut module.tables);
    let function = module.functions.pop();
    own.functions.extend(function);
    let result = differentiated(&mut own, model, request, is_linear);
    std::mem::swap(&mut own.tables, &mut module.tables);
    module.functions.append(&mut own.functions);
    result
}

fn differentiated(
    own: &mut Module,
    model: &Model,
    request: &GenerationRequest,
    is_linear: bool,
) -> Result<(), GenerateError> {
    let inputs = own.functions[0].inputs().iter();
    let inputs: Vec<&str> = inputs
        .map(|array| own.tables.symbols.text(array.name))
        .filter(|name| INPUTS.contains(name))
        .collect();
    // What depends on none of them has no derivatives.
    let derivative = if model.cuts.is_empty() || inputs.is_empty() {
        String::new()
    } else {
        format!(
            ",fold,cse,differentiate{{of=qdd by={} values=false}}",
            inputs.join("+")
        )
    };
    run(own, &format!("atomise{derivative}"))?;
    let free = independent_joints(model, &request.options)?;
    if free.is_empty() {
        return Err(GenerateError::Motionless(model.name.clone()));
    }
    let outputs = LinearOutputs {
        model,
        free: &free,
        is_linear,
    };
    own.functions[0] = outputs.of(own);
    run(own, "fold,cse,dce,inline{operations=12}")?;
    name_plainly(own);
    own.functions[0] = with_read_inputs(own, model);
    Ok(())
}

/// The function with the inputs that it still reads, of the extents that the
/// reader of Robotran's files gives them.
fn with_read_inputs(own: &Module, model: &Model) -> Function {
    let old = &own.functions[0];
    let read = old.nodes().iter().flat_map(|node| node.operands());
    let set = old.assignments.iter().map(|set| &set.operand);
    let mut used = vec![None; old.inputs().len()];
    for input in read.chain(set).filter_map(|operand| operand.input()) {
        let (_, [row, column], _) = old.input_element(input);
        let most = used[old.input_array(input)].get_or_insert((0, 0));
        *most = (most.0.max(row), most.1.max(column));
    }
    let text = |array: &Array| own.tables.symbols.text(array.name);
    let points = old.inputs().iter().zip(&used);
    let points = points.filter(|(array, _)| text(array) == "dpt");
    let extents = Extents {
        joints: model.joints.len() as u32,
        points: points.filter_map(|(_, used)| Some((*used)?.1)).sum(),
        columns: 0,
    };
    let inputs = old.inputs().iter().zip(&used).filter_map(|(array, used)| {
        let (_, rank) = array.shape.indices(0);
        let shape = extents.shape(text(array), rank, (*used)?);
        Some((array.name, shape))
    });
    let outputs = old.outputs().iter().map(Array::declaration);
    let new = old.header(old.level).with_arrays(inputs, outputs);
    let places = places_by_name(old.inputs(), new.inputs());
    let place = |input: Input| Input(places[input.index()].expect("extents cover what is read"));
    old.moved_into(new, place, Some)
}

/// Gives the values that passes made names as the generator gives them, which
/// Robotran's languages can write.
fn name_plainly(own: &mut Module) {
    let (function, symbols) = (&mut own.functions[0], &mut own.tables.symbols);
    let names = function.nodes().iter().map(|node| node.name);
    let mut taken: HashSet<Symbol> = names
        .filter(|name| name.suffix == 0)
        .map(|name| name.base)
        .collect();
    for index in 0..function.nodes().len() {
        let node = function.node_mut(Value(index as u32));
        if node.name.is_none() || node.name.suffix == 0 {
            continue;
        }
        let mut text = format!("{}_{}", symbols.text(node.name.base), node.name.suffix);
        let mut symbol = symbols.intern(&text);
        while !taken.insert(symbol) {
            text.push('d');
            symbol = symbols.intern(&text);
        }
        node.name = Name::plain(symbol);
    }
}

fn run(own: &mut Module, text: &str) -> Result<(), GenerateError> {
    let pipeline = REGISTRY.pipeline(text).expect("made of known passes");
    let machine = Machine::built_in("ideal").expect("it ships");
    let mut silent = std::io::sink();
    let config = Config {
        verify_each: false,
        ..Config::new(&machine, &mut silent)
    };
    match manager::run(own, &pipeline, config) {
        Ok(_) => Ok(()),
        Err(error) => Err(GenerateError::Derivative(error.to_string())),
    }
}

/// The outputs of a function that gives `qdd_q`, `qdd_qd` and `qdd_Qq`: these,
/// without the columns of joints that follow from others, or `A` and `B`.
struct LinearOutputs<'a> {
    model: &'a Model,
    /// Joints that move freely, from 0, ascending.
    free: &'a [usize],
    is_linear: bool,
}

impl LinearOutputs<'_> {
    fn of(&self, module: &mut Module) -> Function {
        let (old, tables) = (&module.functions[0], &mut module.tables);
        let mut new = old.header(old.level);
        new.metadata.retain(|(key, _)| key != differentiation::KEY);
        let (joints, states) = (self.model.joints.len() as u32, 2 * self.free.len() as u32);
        let arrays: &[(&str, Shape)] = if self.is_linear {
            &[
                ("A", Shape::Matrix(states, states)),
                ("B", Shape::Matrix(states, joints)),
            ]
        } else {
            &[
                ("qdd_q", Shape::Matrix(joints, joints)),
                ("qdd_qd", Shape::Matrix(joints, joints)),
                ("qdd_Qq", Shape::Matrix(joints, joints)),
            ]
        };
        let outputs = arrays
            .iter()
            .map(|(name, shape)| (tables.symbols.intern(name), *shape));
        new = new.with_arrays(old.inputs().iter().map(Array::declaration), outputs);
        if self.is_linear {
            let numbers: Vec<String> = self.free.iter().map(|j| (j + 1).to_string()).collect();
            new.metadata.push(("state".to_owned(), numbers.join(" ")));
        }
        let made = new.outputs().to_vec();
        let mut function = old.moved_into(
            new,
            |input| input,
            |output| {
                let (array, indices, _) = old.output_element(output);
                let name = tables.symbols.text(array.name);
                let is_derivative = DERIVATIVES.contains(&name);
                let (place, indices) = is_derivative.then(|| self.place(name, indices))??;
                Some(Output(
                    made[place].offset + made[place].shape.offset(&indices)?,
                ))
            },
        );
        self.constants(&mut function);
        function.sort_assignments();
        function
    }

    /// New array, by its place, and indices of an element of the derivatives.
    fn place(&self, name: &str, [row, column]: [u32; 2]) -> Option<(usize, [u32; 2])> {
        let at = |joint: u32| self.free.binary_search(&(joint as usize - 1)).ok();
        let count = self.free.len() as u32;
        Some(match (self.is_linear, name) {
            (true, "qdd_Qq") => (1, [count + at(row)? as u32 + 1, column]),
            (true, "qdd_q") => {
                let indices = [count + at(row)? as u32 + 1, at(column)? as u32 + 1];
                (0, indices)
            }
            (true, _) => {
                let row = count + at(row)? as u32 + 1;
                (0, [row, count + at(column)? as u32 + 1])
            }
            (false, "qdd_Qq") => (2, [row, column]),
            (false, _) => {
                let driven = self.model.joints[column as usize - 1].nature;
                let moves = at(column).is_some() || driven == robovec_model::Nature::Driven;
                let array = usize::from(name == "qdd_qd");
                (array, moves.then_some([row, column])?)
            }
        })
    }

    /// Velocities are the derivatives of positions. And every array has an
    /// element, if only a zero: the last one where only its indices show a
    /// reader how large the array is.
    fn constants(&self, function: &mut Function) {
        let set = |function: &mut Function, output: u32, operand: Operand| {
            function.assignments.push(Assignment {
                output: Output(output),
                operand,
                sources: SourceSet::EMPTY,
            });
        };
        let one = Operand::from(function.constant(1.0));
        if self.is_linear {
            let count = self.free.len() as u32;
            for state in 0..count {
                set(function, state * 2 * count + count + state, one);
            }
        }
        let zero = Operand::from(function.constant(0.0));
        let outputs = function.outputs().to_vec();
        for array in outputs {
            let last = array.offset + array.shape.len() as u32 - 1;
            let (wanted, element) = if self.is_linear {
                (last..last + 1, last)
            } else {
                (array.offset..last + 1, array.offset)
            };
            let mut outputs = function.assignments.iter().map(|set| set.output.0);
            if !outputs.any(|output| wanted.contains(&output)) {
                set(function, element, zero);
            }
        }
    }
}
