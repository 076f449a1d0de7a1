//! Place of every value: once for all states, by the kernel of sines and
//! cosines, or in which part.

use super::Options;
use crate::emit::crossing::{Crossing, PartValues};
use crate::emit::order::{CodeStep, by_registers};
use hashbrown::{HashMap, HashSet};
use robovec_analysis::slice::live;
use robovec_ir::{Function, Input, Operand, OperandKind, Operation, Value, View};
use rustc_hash::FxBuildHasher;

/// Vector registers that the order reckons with; compilers need a few of the
/// 32 themselves.
const REGISTERS: usize = 28;

/// The place where an operand is read.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum OperandPlace {
    /// A variable of a part.
    Variable(Value),
    /// A sine or cosine: the number of its angle.
    Circular(Operation, u32),
    /// A number that is the same for all states.
    Prepared(u32),
    /// An input element that differs from state to state.
    Input(Input),
    /// A literal.
    Literal(f64),
}

/// Some angles whose sines and cosines are computed in one loop.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct AngleGroup {
    /// The input array they lie in, or none for computed ones.
    pub(super) array: Option<usize>,
    /// The number of the first.
    pub(super) first: u32,
    pub(super) angles: Vec<Operand>,
}

/// Items of a batch in their order.
#[derive(Clone, Debug)]
pub(super) enum BatchItem {
    /// Sines and cosines of a group of angles.
    Circular(AngleGroup),
    /// The operations of a part, by number.
    Part(usize),
}

/// The plan of batch code.
pub(super) struct BatchPlan {
    /// For each input array a flag: true when all states share it.
    pub(super) shared: Vec<bool>,
    /// For each value whether it is the same for all states.
    pub(super) uniform: Vec<bool>,
    /// The numbers prepared for all states.
    pub(super) prepared: Vec<Operand>,
    prepared_places: HashMap<Operand, u32, FxBuildHasher>,
    /// Angles of all groups.
    pub(super) angles: u32,
    angle_numbers: HashMap<Operand, u32, FxBuildHasher>,
    /// Consecutive steps that are in their own function.
    pub(super) parts: Vec<Vec<CodeStep>>,
    pub(super) items: Vec<BatchItem>,
    /// Values that travel from part to part.
    pub(super) crossing: Crossing,
}

impl BatchPlan {
    /// Plans a function.
    pub(super) fn new(view: View<'_>, options: &Options) -> BatchPlan {
        let function = view.function;
        let name = |index: usize| view.tables.symbols.text(function.inputs()[index].name);
        let shared: Vec<bool> = (0..function.inputs().len())
            .map(|index| options.shared.iter().any(|shared| shared == name(index)))
            .collect();
        let live = live(function);
        let uniform = uniform(function, &shared);
        let lanes: Vec<bool> = (0..live.len())
            .map(|index| live[index] && !uniform[index])
            .collect();
        let stages = stages(function, &uniform);
        let computed: Vec<bool> = function
            .values()
            .map(|(value, node)| lanes[value.index()] && !node.operation.is_trigonometric())
            .collect();
        let mut plan = BatchPlan {
            shared,
            uniform,
            prepared: Vec::new(),
            prepared_places: HashMap::default(),
            angles: 0,
            angle_numbers: HashMap::default(),
            parts: Vec::new(),
            items: Vec::new(),
            crossing: Crossing::new(0, &[], 0, |_| 0..0),
        };
        plan.prepare(function, &lanes);
        let steps = by_registers(function, &computed, REGISTERS);
        let last = stages.iter().fold(0, |last, &stage| last.max(stage));
        let mut by_stage: Vec<Vec<CodeStep>> = vec![Vec::new(); last as usize + 1];
        for step in steps {
            by_stage[plan.stage(function, &stages, step) as usize].push(step);
        }
        for (stage, steps) in (0..).zip(by_stage) {
            plan.circular(function, &lanes, &stages, stage);
            plan.cut(steps, options.part.max(1) as usize);
        }
        plan.crossing = plan.cross(function);
        plan
    }

    /// The stage a step belongs to.
    fn stage(&self, function: &Function, stages: &[u32], step: CodeStep) -> u32 {
        match step {
            CodeStep::Define(value) => stages[value.index()],
            CodeStep::Assign(index) => {
                let operand = function.assignments[index as usize].operand;
                let value = operand.value();
                let value = value.filter(|value| !self.uniform[value.index()]);
                value.map_or(0, |value| stages[value.index()])
            }
        }
    }

    /// The groups of angles at the head of a stage.
    fn circular(&mut self, function: &Function, lanes: &[bool], stages: &[u32], stage: u32) {
        let mut groups: Vec<AngleGroup> = Vec::new();
        let mut found: HashSet<Operand, FxBuildHasher> = HashSet::default();
        for (value, node) in function.values() {
            let wanted = lanes[value.index()] && stages[value.index()] == stage;
            let angle = node.operands[0];
            let known = self.angle_numbers.contains_key(&angle);
            if !wanted || !node.operation.is_trigonometric() || known || !found.insert(angle) {
                continue;
            }
            let array = angle.input().map(|input| function.input_array(input));
            match groups.iter_mut().find(|group| group.array == array) {
                Some(group) => group.angles.push(angle),
                None => groups.push(AngleGroup {
                    array,
                    first: 0,
                    angles: vec![angle],
                }),
            }
        }
        for mut group in groups {
            group.first = self.angles;
            for (number, &angle) in (self.angles..).zip(&group.angles) {
                self.angle_numbers.insert(angle, number);
            }
            self.angles += group.angles.len() as u32;
            self.items.push(BatchItem::Circular(group));
        }
    }

    /// Cuts the steps of a stage into parts.
    fn cut(&mut self, steps: Vec<CodeStep>, size: usize) {
        let mut steps = steps.into_iter().peekable();
        while steps.peek().is_some() {
            let mut part = Vec::new();
            let mut count = 0;
            while count < size
                && let Some(step) = steps.next()
            {
                count += usize::from(matches!(step, CodeStep::Define(_)));
                part.push(step);
                // The outputs of the last value stand with it.
                if count == size {
                    while let Some(&step @ CodeStep::Assign(_)) = steps.peek() {
                        part.push(step);
                        steps.next();
                    }
                }
            }
            self.items.push(BatchItem::Part(self.parts.len()));
            self.parts.push(part);
        }
    }

    /// Finds the values that cross from part to part.
    fn cross(&self, function: &Function) -> Crossing {
        let traffic = self.parts.iter().map(|steps| {
            let mut traffic = PartValues::default();
            for step in steps {
                for &operand in step.reads(function) {
                    if let OperandPlace::Variable(value) = self.place(function, operand) {
                        traffic.read.push(value);
                    }
                }
                if let CodeStep::Define(value) = *step {
                    traffic.defined.push(value);
                }
            }
            traffic
        });
        let traffic: Vec<PartValues> = traffic.collect();
        Crossing::new(function.nodes().len(), &traffic, 0, |_| 0..0)
    }

    /// Gives a place to every number that all states share and that a part
    /// reads.
    fn prepare(&mut self, function: &Function, lanes: &[bool]) {
        let nodes = function.values().filter(|(value, _)| lanes[value.index()]);
        let reads = nodes.flat_map(|(_, node)| node.operands().iter().copied());
        let outputs = function.assignments.iter();
        for operand in reads.chain(outputs.map(|assignment| assignment.operand)) {
            self.share(function, operand);
        }
    }

    /// Prepares an operand, if it is the same for all states and no literal.
    pub(super) fn share(&mut self, function: &Function, operand: Operand) {
        let uniform = match operand.kind() {
            OperandKind::Value(value) => self.uniform[value.index()],
            OperandKind::Input(input) => self.shared[function.input_array(input)],
            OperandKind::Constant(_) | OperandKind::None => false,
        };
        if uniform && !self.prepared_places.contains_key(&operand) {
            let place = self.prepared.len() as u32;
            self.prepared_places.insert(operand, place);
            self.prepared.push(operand);
        }
    }

    /// The place where the code for lanes reads an operand.
    pub(super) fn place(&self, function: &Function, operand: Operand) -> OperandPlace {
        if let Some(place) = self.prepared_place(operand) {
            return OperandPlace::Prepared(place);
        }
        match operand.kind() {
            OperandKind::Value(value) => {
                let node = function.node(value);
                match self.angle_numbers.get(&node.operands[0]) {
                    Some(&angle) if node.operation.is_trigonometric() => {
                        OperandPlace::Circular(node.operation, angle)
                    }
                    _ => OperandPlace::Variable(value),
                }
            }
            OperandKind::Input(input) => OperandPlace::Input(input),
            OperandKind::Constant(constant) => {
                OperandPlace::Literal(function.constant_number(constant))
            }
            OperandKind::None => unreachable!("an operation has all its operands"),
        }
    }

    /// The place of a number that is the same for all states.
    pub(super) fn prepared_place(&self, operand: Operand) -> Option<u32> {
        self.prepared_places.get(&operand).copied()
    }

    /// The number of a computed angle.
    pub(super) fn angle(&self, value: Value) -> Option<u32> {
        self.angle_numbers.get(&Operand::from(value)).copied()
    }

    /// True when some angles are computed.
    pub(super) fn has_computed_angles(&self) -> bool {
        self.items.iter().any(|item| match item {
            BatchItem::Circular(group) => group.array.is_none(),
            BatchItem::Part(_) => false,
        })
    }
}

/// The nodes that depend on nothing but shared arrays and literals.
fn uniform(function: &Function, shared: &[bool]) -> Vec<bool> {
    let mut uniform: Vec<bool> = Vec::with_capacity(function.nodes().len());
    for node in function.nodes() {
        let own = node.operands().iter().all(|operand| match operand.kind() {
            OperandKind::Value(value) => uniform[value.index()],
            OperandKind::Input(input) => shared[function.input_array(input)],
            OperandKind::Constant(_) | OperandKind::None => true,
        });
        uniform.push(own);
    }
    uniform
}

/// For each value the number of sines or cosines of computed angles on the
/// longest chain before it.
fn stages(function: &Function, uniform: &[bool]) -> Vec<u32> {
    let mut stages: Vec<u32> = Vec::with_capacity(uniform.len());
    for (value, node) in function.values() {
        let operands = node.operands().iter().filter_map(|operand| operand.value());
        let operands = operands.filter(|operand| !uniform[operand.index()]);
        let before = operands.map(|operand| stages[operand.index()]).max();
        let own = match before {
            Some(stage) if node.operation.is_trigonometric() => stage + 1,
            Some(stage) => stage,
            None => 0,
        };
        stages.push(if uniform[value.index()] { 0 } else { own });
    }
    stages
}
