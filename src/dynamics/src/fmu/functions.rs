//! Generated functions of an FMU: from and to variables, with derivatives.

use super::variables::{FmuVariables, NumberPlace, VariableRole};
use crate::generate::{Formulation, GenerationRequest, Options, generate};
use crate::kinematics::StateError;
use crate::motion::MotionError;
use robovec_cgen::c::{self, ElementOrder, Layout, Real, Signature};
use robovec_framework::manager::{self, Config};
use robovec_framework::rewrite::without_dead;
use robovec_ir::{Array, Assignment, Function, Input, Machine, Module, Output, Shape, View};
use robovec_model::Model;
use robovec_passes::registry::REGISTRY;
use robovec_robotran::FunctionKind;

/// A part of a step. The order is that of the kinds in `types.c`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct StepPart {
    name: &'static str,
    function: FunctionKind,
    /// First letters of its outputs.
    outputs: &'static [&'static str],
}

/// Number of the kinds that a step consists of; those of sensed frames follow.
pub(super) const KINDS: usize = PARTS.len();

/// Motions of sensed frames, of sensors and of links by name.
const SENSED: [StepPart; 2] = [
    StepPart {
        name: "sensor",
        function: FunctionKind::Sensor,
        outputs: &["sens.P", "sens.R", "sens.V", "sens.OM"],
    },
    StepPart {
        name: "frame",
        function: FunctionKind::Frame,
        outputs: &["position", "rotation", "velocity", "angular_velocity"],
    },
];

const PARTS: [StepPart; 7] = [
    StepPart {
        name: "positions",
        function: FunctionKind::LoopPositions,
        outputs: &["q", "h"],
    },
    StepPart {
        name: "velocities",
        function: FunctionKind::LoopVelocities,
        outputs: &["qd"],
    },
    StepPart {
        name: "lengths",
        function: FunctionKind::Link,
        outputs: &["Z", "Zd"],
    },
    StepPart {
        name: "link_loads",
        function: FunctionKind::Link,
        outputs: &["frc", "trq"],
    },
    StepPart {
        name: "points",
        function: FunctionKind::Extforces,
        outputs: &["PxF", "VxF", "OMxF", "RxF"],
    },
    StepPart {
        name: "point_loads",
        function: FunctionKind::Extforces,
        outputs: &["frc", "trq"],
    },
    StepPart {
        name: "accelerations",
        function: FunctionKind::Accelred,
        outputs: &["qdd"],
    },
];

#[derive(Clone, PartialEq, Debug)]
pub(super) struct FmuFunction {
    /// Place among the kinds.
    pub(super) kind: usize,
    /// It computes derivatives along a direction.
    pub(super) along: bool,
    pub(super) name: String,
    pub(super) source: String,
    pub(super) from: Vec<NumberPlace>,
    /// Number of inputs before those that are parameters.
    pub(super) moving: usize,
    pub(super) to: Vec<NumberPlace>,
}

/// Name of the vector of outputs.
const RESULTS: &str = "results";

/// Passes over a function, and over its derivative.
const SHORTEN: &str = "$cpu";

/// The functions of a model's steps, and of its sensed frames.
pub(super) fn functions(
    variables: &mut FmuVariables<'_>,
    formulation: Formulation,
) -> Result<Vec<FmuFunction>, MotionError> {
    let model = variables.model;
    let mut functions = Vec::new();
    for (kind, part) in PARTS.iter().enumerate() {
        let is_there = match part.function {
            FunctionKind::Link => !model.links.is_empty(),
            FunctionKind::Extforces => !model.forces.is_empty(),
            FunctionKind::Accelred => true,
            _ => !model.cuts.is_empty(),
        };
        if is_there {
            let module = generated(model, part.function, formulation)?;
            add(&mut functions, variables, part, (module, 0), kind)?;
        }
    }
    let counts = [model.sensors.len(), model.frames.len()];
    let mut kind = KINDS;
    for (part, count) in SENSED.iter().zip(counts).filter(|(_, count)| *count > 0) {
        let module = generated(model, part.function, formulation)?;
        for case in 0..count {
            add(
                &mut functions,
                variables,
                part,
                (module.clone(), case),
                kind,
            )?;
            kind += 1;
        }
    }
    Ok(functions)
}

fn generated(
    model: &Model,
    function: FunctionKind,
    formulation: Formulation,
) -> Result<Module, MotionError> {
    let request = GenerationRequest {
        function,
        formulation,
        options: Options::default(),
    };
    Ok(generate(model, &request)?)
}

fn add(
    functions: &mut Vec<FmuFunction>,
    variables: &mut FmuVariables<'_>,
    part: &StepPart,
    (module, case): (Module, usize),
    kind: usize,
) -> Result<(), MotionError> {
    let frame = kind.saturating_sub(KINDS) as u32;
    let (module, places) = part.equations(variables, module, case, frame);
    let along = directions(&module);
    for (is_along, passes) in [(false, Some(SHORTEN.to_owned())), (true, along)] {
        let Some(passes) = passes else { continue };
        let mut made = module.clone();
        run(&mut made, &passes)?;
        let name = match is_along {
            true => format!("{}_{kind}_along", part.name),
            false => format!("{}_{kind}", part.name),
        };
        let place = |set: &Assignment| NumberPlace {
            along: is_along,
            ..places[set.output.index()]
        };
        let to = made.functions[0].assignments.iter().map(place).collect();
        functions.push(FmuFunction {
            kind,
            along: is_along,
            ..flat(&mut made, variables, &name, to)?
        });
    }
    Ok(())
}

impl StepPart {
    /// One of the functions of a module with the outputs of the part alone, as one
    /// vector, and their places. `frame` is the number of a sensed frame, from 0.
    fn equations(
        &self,
        variables: &FmuVariables<'_>,
        mut module: Module,
        case: usize,
        frame: u32,
    ) -> (Module, Vec<NumberPlace>) {
        let old = module.functions.swap_remove(case);
        module.functions.clear();
        let mut places = Vec::new();
        let mut moved = vec![None; old.output_len()];
        for set in &old.assignments {
            let (array, indices, rank) = old.output_element(set.output);
            let name = module.tables.symbols.text(array.name);
            let word = name.trim_end_matches(|letter: char| letter.is_ascii_digit());
            // Numbers that are no arrays are arguments of user functions.
            if rank > 0 && self.outputs.contains(&word) {
                moved[set.output.index()] = Some(Output(places.len() as u32));
                places.push(variables.output(word, (name, frame), &indices[..rank]));
            }
        }
        let results = module.tables.symbols.intern(RESULTS);
        let new = Function::new(&old.name, old.level).with_arrays(
            old.inputs().iter().map(Array::declaration),
            [(results, Shape::Vector(places.len() as u32))],
        );
        let function = old.moved_into(new, |input| input, |output| moved[output.index()]);
        module.functions.push(without_dead(function));
        (module, places)
    }
}

/// The passes that derive along all inputs that move; `None` where none does.
fn directions(module: &Module) -> Option<String> {
    let moves = |name: &str| {
        matches!(name, "q" | "qd" | "qdd" | "Qq" | "frc" | "trq")
            || ["Flink", "Flnk", "SWr"]
                .iter()
                .any(|word| name.starts_with(word))
    };
    let inputs = module.functions[0].inputs().iter();
    let names = inputs.map(|array| module.tables.symbols.text(array.name));
    let names: Vec<&str> = names.filter(|name| moves(name)).collect();
    let by = names.join("+");
    let differentiate = format!("differentiate{{result=direction by={by} values=false}}");
    (!names.is_empty()).then(|| format!("atomise,{differentiate},fold,cse,dce,{SHORTEN}"))
}

fn run(module: &mut Module, passes: &str) -> Result<(), MotionError> {
    let pipeline = REGISTRY.pipeline(passes).expect("made of known passes");
    let machine = Machine::built_in("thesis").expect("it ships");
    // Remarks are about functions that nobody sees.
    let mut silent = std::io::sink();
    let outcome = manager::run(module, &pipeline, Config::new(&machine, &mut silent));
    outcome.map_err(|error| MotionError::Passes(error.to_string()))?;
    Ok(())
}

/// The function with one vector of inputs, parameters last, as C.
fn flat(
    module: &mut Module,
    variables: &mut FmuVariables<'_>,
    name: &str,
    to: Vec<NumberPlace>,
) -> Result<FmuFunction, MotionError> {
    let function = &module.functions[0];
    let symbols = &module.tables.symbols;
    let read = function.nodes().iter().flat_map(|node| node.operands());
    let set = function.assignments.iter().map(|set| &set.operand);
    let mut used: Vec<Input> = read
        .chain(set)
        .filter_map(|operand| operand.input())
        .collect();
    used.sort_unstable();
    used.dedup();
    let mut placed = Vec::with_capacity(used.len());
    for input in used {
        let (array, indices, rank) = function.input_element(input);
        let place = variables.input(symbols.text(array.name), &indices[..rank]);
        let place = place.map_err(|element| StateError::Element {
            function: function.name.clone(),
            element,
        })?;
        placed.push((place, input));
    }
    let is_fixed =
        |place: &NumberPlace| variables.list[place.slot as usize].role == VariableRole::Parameter;
    placed.sort_by_key(|(place, _)| is_fixed(place));
    let moving = placed.iter().filter(|(place, _)| !is_fixed(place)).count();
    let [numbers, results] = ["numbers", RESULTS].map(|word| module.tables.symbols.intern(word));
    let vector = |length: usize| Shape::Vector(length.max(1) as u32);
    let new = Function::new(&format!("robovec_{name}"), function.level).with_arrays(
        [(numbers, vector(placed.len()))],
        [(results, vector(to.len()))],
    );
    let mut inputs = vec![Input(0); function.input_len()];
    for (place, (_, input)) in placed.iter().enumerate() {
        inputs[input.index()] = Input(place as u32);
    }
    let mut outputs = vec![None; function.output_len()];
    for (place, set) in function.assignments.iter().enumerate() {
        outputs[set.output.index()] = Some(Output(place as u32));
    }
    let input = |input: Input| inputs[input.index()];
    let new = function.moved_into(new, input, |output| outputs[output.index()]);
    let view = View {
        tables: &module.tables,
        function: &new,
    };
    Ok(FmuFunction {
        kind: 0,
        along: false,
        name: new.name.clone(),
        source: c_source(view),
        from: placed.into_iter().map(|(place, _)| place).collect(),
        moving,
        to,
    })
}

fn c_source(view: View<'_>) -> String {
    let options = c::Options {
        signature: Signature::Plain,
        real: Real::Double,
        is_local: true,
        layout: Layout::FromZero {
            order: ElementOrder::Row,
            is_sparse: false,
        },
        ..c::Options::default()
    };
    let files = c::files(view, &options);
    let [(_, source), _header] = files.expect("every function has a plain signature");
    source
}
