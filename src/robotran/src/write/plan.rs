//! Order of the statements.
//!
//! Definitions keep their order, so that reading the file gives the nodes in
//! the order they had. A call of a user function is before the first definition
//! that reads its result, and after the values that fill its arguments; outputs
//! are at the end. An element that an output overwrites and a later one reads
//! (`frc` comes and goes under one name) is kept in a temporary first.

use super::error::RobotranWriteError;
use super::names::is_word;
use crate::Language;
use hashbrown::{HashMap, HashSet};
use robovec_ir::{Array, Boundary, Function, Input, Operand, OperandKind, Symbol, Symbols, Value};
use rustc_hash::FxBuildHasher;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum WrittenStatement {
    /// Defines the temporary of a named value.
    Define(Value),
    /// Keeps an input element in a temporary before it is overwritten.
    Keep(Input),
    /// Sets an argument of a call: a place among the assignments.
    Argument(usize),
    /// Sets an output element: a place among the assignments.
    Output(usize),
    /// Calls a user function: a place among the boundaries.
    Call(usize),
}

/// The statements of a function, in order. `shared` is true if an output
/// and an input of one name are one memory, as in C and Python.
pub(super) fn plan(
    function: &Function,
    symbols: &Symbols,
    shared: bool,
) -> Result<Vec<WrittenStatement>, RobotranWriteError> {
    let calls = Calls::new(function, symbols);
    let mut statements = match calls.in_program_order() {
        Some(statements) => statements,
        None => calls.in_stages()?,
    };
    let kept = if shared {
        overwritten(function, &calls.passed)
    } else {
        Vec::new()
    };
    statements.extend(kept.into_iter().map(WrittenStatement::Keep));
    let left = (0..function.assignments.len()).filter(|&index| calls.passed[index].is_none());
    statements.extend(left.map(WrittenStatement::Output));
    Ok(statements)
}

/// The calls of a function, with their arguments and results.
struct Calls<'a> {
    function: &'a Function,
    /// Per input array: the call that fills it.
    results: HashMap<Symbol, usize, FxBuildHasher>,
    /// Per assignment: the first call that is given its output.
    passed: Vec<Option<usize>>,
    /// Per call: the assignments that fill its arguments, in order.
    arguments: Vec<Vec<usize>>,
}

impl<'a> Calls<'a> {
    fn new(function: &'a Function, symbols: &Symbols) -> Calls<'a> {
        let count = function.boundaries.len();
        let mut results = HashMap::default();
        let mut passed = vec![None; function.assignments.len()];
        let mut arguments = vec![Vec::new(); count];
        if count > 0 {
            let mut calls: HashMap<&str, usize, FxBuildHasher> = HashMap::default();
            let mut given: HashMap<&str, usize, FxBuildHasher> = HashMap::default();
            for (
                index,
                Boundary {
                    arguments, result, ..
                },
            ) in function.boundaries.iter().enumerate()
            {
                for argument in arguments {
                    calls.entry(argument).or_insert(index);
                }
                if let Some(result) = result {
                    given.entry(result).or_insert(index);
                }
            }
            for array in function.inputs() {
                if let Some(&call) = given.get(symbols.text(array.name)) {
                    results.insert(array.name, call);
                }
            }
            for (index, assignment) in function.assignments.iter().enumerate() {
                let (array, _, _) = function.output_element(assignment.output);
                passed[index] = calls.get(symbols.text(array.name)).copied();
                if let Some(call) = passed[index] {
                    arguments[call].push(index);
                }
            }
        }
        Calls {
            function,
            results,
            passed,
            arguments,
        }
    }

    /// One more than the last call whose result an operand needs, or `before`.
    fn stage(&self, operand: Operand, before: &[u32]) -> u32 {
        match operand.kind() {
            OperandKind::Value(value) => before[value.index()],
            OperandKind::Input(input) if !self.results.is_empty() => {
                let (array, _, _) = self.function.input_element(input);
                let call = self.results.get(&array.name);
                call.map_or(0, |&call| call as u32 + 1)
            }
            OperandKind::Input(_) | OperandKind::Constant(_) | OperandKind::None => 0,
        }
    }

    /// For every node the number of calls that must precede it.
    fn stages(&self) -> Vec<u32> {
        let mut stages = Vec::with_capacity(self.function.nodes().len());
        for node in self.function.nodes() {
            let needed = node.operands().iter();
            let needed = needed.map(|&operand| self.stage(operand, &stages));
            stages.push(needed.fold(0, u32::max));
        }
        stages
    }

    fn call(&self, call: usize, statements: &mut Vec<WrittenStatement>) {
        let arguments = self.arguments[call].iter();
        statements.extend(arguments.map(|&index| WrittenStatement::Argument(index)));
        statements.push(WrittenStatement::Call(call));
    }

    /// The definitions in program order, every call as late as possible.
    fn in_program_order(&self) -> Option<Vec<WrittenStatement>> {
        let mut statements = Vec::with_capacity(self.function.nodes().len());
        if self.function.boundaries.is_empty() {
            let named = self
                .function
                .values()
                .filter(|(_, node)| !node.name.is_none());
            statements.extend(named.map(|(value, _)| WrittenStatement::Define(value)));
            return Some(statements);
        }
        let stages = self.stages();
        let roots = self.roots();
        let mut called = 0;
        for (value, _) in self
            .function
            .values()
            .filter(|(_, node)| !node.name.is_none())
        {
            while called < stages[value.index()] as usize {
                // A tree of an argument may stand behind all definitions;
                // what counts is the last definition it reads.
                let ready = self.arguments[called].iter().all(|&index| {
                    let operand = self.function.assignments[index].operand;
                    self.stage(operand, &stages) as usize <= called
                        && roots[index].is_none_or(|last| last < value)
                });
                if !ready {
                    return None;
                }
                self.call(called, &mut statements);
                called += 1;
            }
            statements.push(WrittenStatement::Define(value));
        }
        for call in called..self.function.boundaries.len() {
            let mut arguments = self.arguments[call].iter();
            if !arguments.all(|&index| {
                self.stage(self.function.assignments[index].operand, &stages) as usize <= call
            }) {
                return None;
            }
            self.call(call, &mut statements);
        }
        Some(statements)
    }

    /// Per assignment: the last definition its expression reads.
    fn roots(&self) -> Vec<Option<Value>> {
        let nodes = self.function.nodes();
        let mut last: Vec<Option<Value>> = Vec::with_capacity(nodes.len());
        let of = |operand: Operand, last: &[Option<Value>]| {
            let value = operand.value()?;
            if nodes[value.index()].name.is_none() {
                last[value.index()]
            } else {
                Some(value)
            }
        };
        for node in nodes {
            let read = node.operands().iter();
            let read = read.filter_map(|&operand| of(operand, &last)).max();
            last.push(read);
        }
        let assignments = self.function.assignments.iter();
        assignments
            .map(|assignment| of(assignment.operand, &last))
            .collect()
    }

    /// The definitions in one run per call and one more, as early as needed.
    fn in_stages(&self) -> Result<Vec<WrittenStatement>, RobotranWriteError> {
        let stages = self.stages();
        let mut statements = Vec::with_capacity(self.function.nodes().len());
        let mut runs = vec![Vec::new(); self.function.boundaries.len() + 1];
        for (value, node) in self.function.values() {
            if !node.name.is_none() {
                runs[stages[value.index()] as usize].push(WrittenStatement::Define(value));
            }
        }
        for (call, run) in runs.into_iter().enumerate() {
            statements.extend(run);
            let Some(boundary) = self.function.boundaries.get(call) else {
                break;
            };
            let mut arguments = self.arguments[call].iter();
            if !arguments.all(|&index| {
                self.stage(self.function.assignments[index].operand, &stages) as usize <= call
            }) {
                return Err(RobotranWriteError::CallOrder {
                    function: self.function.name.clone(),
                    callee: boundary.callee.clone(),
                });
            }
            self.call(call, &mut statements);
        }
        Ok(statements)
    }
}

/// Input elements that an output overwrites while a later one reads them.
fn overwritten(function: &Function, passed: &[Option<usize>]) -> Vec<Input> {
    let given: HashMap<Symbol, Array, FxBuildHasher> = function
        .inputs()
        .iter()
        .map(|input| (input.name, *input))
        .collect();
    let mut kept = Vec::new();
    let mut outputs = function.outputs().iter();
    if !outputs.any(|output| given.contains_key(&output.name)) {
        return kept;
    }
    let mut written: HashSet<Input, FxBuildHasher> = HashSet::default();
    let mut known: HashSet<Input, FxBuildHasher> = HashSet::default();
    let mut open = Vec::new();
    assert_eq!(
        passed.len(),
        function.assignments.len(),
        "every output is passed to a call or not"
    );
    for (assignment, passed) in function.assignments.iter().zip(passed) {
        if passed.is_none() {
            open.push(assignment.operand);
        }
        while let Some(operand) = open.pop() {
            match operand.kind() {
                OperandKind::Input(input) => {
                    if written.contains(&input) && known.insert(input) {
                        kept.push(input);
                    }
                }
                OperandKind::Value(value) if function.node(value).name.is_none() => {
                    open.extend(function.node(value).operands().iter().rev());
                }
                OperandKind::Value(_) | OperandKind::Constant(_) | OperandKind::None => {}
            }
        }
        let (array, indices, rank) = function.output_element(assignment.output);
        let place = given.get(&array.name).and_then(|input| {
            let place = input.shape.offset(&indices[..rank])?;
            Some(Input(input.offset + place))
        });
        written.extend(place);
    }
    kept
}

/// The user function of a call by language: C's `user_ExtForces` is Matlab's
/// `usrfun.fext` and Python's `s.user_ExtForces`.
pub(super) fn callee(call: &Boundary, language: Language) -> Option<String> {
    let name = match call.callee.strip_prefix("usrfun.") {
        Some("fext") => "user_ExtForces".to_owned(),
        Some("flink") => "user_LinkForces".to_owned(),
        Some(other) if other.starts_with("user_") => other.to_owned(),
        Some(other) => format!("user_{other}"),
        None => call.callee.clone(),
    };
    let bare = name.strip_prefix("user_").filter(|bare| !bare.is_empty());
    if bare.is_none() || !is_word(&name) {
        return None;
    }
    // The C of the reduced accelerations calls through `user_call_…`.
    let plain = name.replacen("user_call_", "user_", 1);
    Some(match (language, plain.as_str()) {
        (Language::C, _) => name,
        (Language::Matlab, "user_ExtForces") => "usrfun.fext".to_owned(),
        (Language::Matlab, "user_LinkForces") => "usrfun.flink".to_owned(),
        (Language::Matlab, _) => format!("usrfun.{plain}"),
        (Language::Python, _) => format!("s.{plain}"),
    })
}

/// The statement of a call, without its end.
pub(super) fn call_statement(
    function: &Function,
    call: &Boundary,
    language: Language,
) -> Result<String, RobotranWriteError> {
    let refuse = || RobotranWriteError::Call {
        function: function.name.clone(),
        callee: call.callee.clone(),
    };
    let callee = callee(call, language).ok_or_else(refuse)?;
    let mut arguments = Vec::new();
    for argument in &call.arguments {
        let number = !argument.is_empty() && argument.bytes().all(|byte| byte.is_ascii_digit());
        if !is_word(argument) && !number {
            return Err(refuse());
        }
        arguments.push(argument.as_str());
    }
    let result = match &call.result {
        Some(result) if !is_word(result) => return Err(refuse()),
        Some(result) => format!("{result} = "),
        None => String::new(),
    };
    Ok(format!("{result}{callee}({})", arguments.join(",")))
}
