//! Several instances of a program in one, so that one fills the gaps of the
//! others.
//!
//! A schedule of a single program waits for its longest chain: on 16 + 16
//! elements most issue slots stay empty. Independent instances share the
//! elements, not the chain. They are one function with one schedule, so list
//! scheduling is fair to all of them already: operations of equal urgency of
//! all instances are side by side in its order, and operations that are late
//! become more urgent.

use hashbrown::HashMap;
use robovec_framework::declare_pass;
use robovec_framework::instances::{InstanceNames, Instances, KEY, MAX_INSTANCES, numbered};
use robovec_framework::pass::{Context, Gives, Pass, PassError};
use robovec_framework::rewrite::lay_out;
use robovec_ir::{
    Array, Boundary, Function, Input, Level, MAX_INPUT_ELEMENTS, MAX_OUTPUT_ELEMENTS, Name, Node,
    Operand, OperandKind, Output, Symbol, Tables, Value, ValueFormats,
};
use robovec_num::limits::NumberLimit;

declare_pass! {
    /// Puts several independent instances of a function into one.
    ///
    /// One evaluation alone waits for its longest chain; several at once fill
    /// the elements (finite differences, shooting nodes, parameter sweeps):
    /// `interleave{instances=4},place`.
    ///
    /// Array `A` becomes `A_1` for the first instance, `A_2` for the second,
    /// and so on. Input arrays named in `shared` stay as they are and are read
    /// by all instances: parameters such as masses and lengths, whose words are
    /// then loaded and kept once per memory. Constants are always shared.
    /// Values that depend on shared inputs alone are computed once when `cse`
    /// follows. Values get the same endings as arrays.
    ///
    /// The semantic check compares every instance with the original, at
    /// points at which the instances differ.
    pub struct Interleave("interleave") {
        /// Number of instances, from 1 to 64; one changes nothing.
        pub instances: u32 = 2 => NumberLimit::whole(
            1, MAX_INSTANCES as u64, "the function becomes this number of times larger"),
        /// Input arrays that all instances read, such as `m+l+In+g`.
        pub shared: InstanceNames = InstanceNames::default(),
    }
    takes: [Equations, Atomic],
    gives: Gives::Same,
    class: Exact,
    destroys: [Timed, Shared],
}

/// The maximum number of operations a function may get: the text of more is
/// larger than any file that is read.
const MAX_OPERATIONS: u64 = 1 << 24;

impl Pass for Interleave {
    fn run(&self, function: &mut Function, context: &mut Context<'_>) -> Result<(), PassError> {
        let instances = self.checked(function, context.tables)?;
        if instances.count == 1 {
            return Ok(());
        }
        let mut copier = Copier::new(function, &instances, context.tables);
        copier.arrays()?;
        copier.nodes();
        copier.assignments();
        let new = copier.finish();
        assert_eq!(
            new.nodes().len(),
            instances.count as usize * function.nodes().len(),
            "every instance has all operations"
        );
        *function = match new.level {
            Level::Equations => lay_out(&new),
            _ => new,
        };
        let count = u64::from(instances.count);
        context.count("instances", count);
        Ok(())
    }

    fn instances(&self) -> Option<Instances> {
        (self.instances > 1).then(|| Instances {
            count: self.instances,
            shared: self.shared.clone(),
        })
    }
}

impl Interleave {
    /// The options, if they suit the function.
    fn checked(&self, function: &Function, tables: &Tables) -> Result<Instances, PassError> {
        let count = self.instances;
        if !(1..=MAX_INSTANCES).contains(&count) {
            let message = format!("instances is {count}; it must be from 1 to {MAX_INSTANCES}");
            return Err(PassError::new(message));
        }
        if function.metadata(KEY).is_some() {
            return Err(PassError::new(
                "the function holds several instances already",
            ));
        }
        let name = |array: &Array| tables.symbols.text(array.name);
        let inputs = || function.inputs().iter().map(name);
        for shared in &self.shared.0 {
            if !inputs().any(|known| known == shared) {
                let known: Vec<&str> = inputs().collect();
                let message = format!("there is no input array '{shared}' to be shared");
                let help = format!("the input arrays are {}", known.join(", "));
                return Err(PassError::new(message).help(help));
            }
        }
        let sizes = [
            ("operations", function.nodes().len(), MAX_OPERATIONS),
            ("input elements", function.input_len(), MAX_INPUT_ELEMENTS),
            (
                "output elements",
                function.output_len(),
                MAX_OUTPUT_ELEMENTS,
            ),
        ];
        for (what, size, most) in sizes {
            let needed = size as u64 * u64::from(count);
            if needed > most {
                return Err(PassError::new(format!(
                    "{count} instances have {needed} {what}, and a function has at most {most}"
                ))
                .help(format!("at most {} instances fit", most / size as u64)));
            }
        }
        Ok(Instances {
            count,
            shared: self.shared.clone(),
        })
    }
}

/// Writes the instances.
struct Copier<'a> {
    old: &'a Function,
    instances: &'a Instances,
    tables: &'a mut Tables,
    new: Function,
    /// For every array of the old function and every instance, the offset of
    /// the new array's elements.
    inputs: Vec<u32>,
    outputs: Vec<u32>,
    /// Symbols of values that got an ending.
    endings: HashMap<(Symbol, u32), Symbol>,
}

impl<'a> Copier<'a> {
    fn new(old: &'a Function, instances: &'a Instances, tables: &'a mut Tables) -> Copier<'a> {
        let mut new = Function::new(&old.name, old.level);
        new.metadata.clone_from(&old.metadata);
        let entry = (KEY.to_owned(), instances.count.to_string());
        new.metadata.push(entry);
        new.reserve(old.nodes().len() * instances.count as usize);
        new.formats = old.formats.as_ref().map(|_| ValueFormats::new(0));
        Copier {
            old,
            instances,
            tables,
            new,
            inputs: Vec::new(),
            outputs: Vec::new(),
            endings: HashMap::new(),
        }
    }

    /// Declares the arrays of all instances, each instance's together.
    fn arrays(&mut self) -> Result<(), PassError> {
        let old = self.old;
        let count = self.instances.count;
        self.inputs = vec![0; old.inputs().len() * count as usize];
        self.outputs = vec![0; old.outputs().len() * count as usize];
        for instance in 1..=count {
            for (place, array) in old.inputs().iter().enumerate() {
                let index = place * count as usize + instance as usize - 1;
                let symbol = self.array_name(array, instance, true);
                self.inputs[index] = if symbol == array.name && instance > 1 {
                    self.inputs[place * count as usize]
                } else {
                    self.new.add_input(symbol, array.shape).offset
                };
            }
            for (place, array) in old.outputs().iter().enumerate() {
                let index = place * count as usize + instance as usize - 1;
                let symbol = self.array_name(array, instance, false);
                self.outputs[index] = self.new.add_output(symbol, array.shape).offset;
            }
            self.boundaries(instance);
        }
        let mut names: Vec<Symbol> = self.new.inputs().iter().map(|array| array.name).collect();
        names.sort_unstable();
        match names.windows(2).find(|pair| pair[0] == pair[1]) {
            None => Ok(()),
            Some(pair) => {
                let name = self.tables.symbols.text(pair[0]);
                let message =
                    format!("the shared input '{name}' has the name of an input of an instance");
                Err(PassError::new(message).help("rename it, or do not share it"))
            }
        }
    }

    fn array_name(&mut self, array: &Array, instance: u32, is_input: bool) -> Symbol {
        let name = self.tables.symbols.text(array.name);
        let name = self.instances.array(name, instance, is_input);
        self.tables.symbols.intern(&name)
    }

    /// Calls of the user's functions, once per instance; arguments that name
    /// an array name that of the instance.
    fn boundaries(&mut self, instance: u32) {
        let symbols = &self.tables.symbols;
        let named = |arrays: &[Array], text: &str| {
            let mut names = arrays.iter().map(|array| symbols.text(array.name));
            names.any(|name| name == text)
        };
        for boundary in &self.old.boundaries {
            let argument = |text: &String| {
                if named(self.old.outputs(), text) {
                    self.instances.array(text, instance, false)
                } else if named(self.old.inputs(), text) {
                    self.instances.array(text, instance, true)
                } else {
                    text.clone()
                }
            };
            let result = boundary.result.as_ref();
            self.new.boundaries.push(Boundary {
                arguments: boundary.arguments.iter().map(argument).collect(),
                result: result.map(|name| self.instances.array(name, instance, true)),
                ..boundary.clone()
            });
        }
    }

    /// Every operation for all instances, before the next operation.
    fn nodes(&mut self) {
        let old = self.old;
        let count = self.instances.count;
        for (value, node) in old.values() {
            let format = old.formats.as_ref().and_then(|formats| formats.get(value));
            for instance in 1..=count {
                let name = self.value_name(node.name, instance);
                let operands = node.operands.map(|operand| self.operand(operand, instance));
                let new = self.new.push(Node {
                    name,
                    operands,
                    ..*node
                });
                if let Some(formats) = &mut self.new.formats {
                    formats.resize(new.index() + 1);
                    formats.set(new, format);
                }
            }
        }
    }

    fn value_name(&mut self, name: Name, instance: u32) -> Name {
        if name.is_none() {
            return name;
        }
        let symbols = &mut self.tables.symbols;
        let ending = self.endings.entry((name.base, instance));
        let base = ending.or_insert_with(|| {
            let text = numbered(symbols.text(name.base), instance);
            symbols.intern(&text)
        });
        Name {
            base: *base,
            ..name
        }
    }

    fn operand(&mut self, operand: Operand, instance: u32) -> Operand {
        let count = self.instances.count;
        match operand.kind() {
            OperandKind::Value(value) => Value(value.0 * count + instance - 1).into(),
            OperandKind::Constant(constant) => {
                let number = self.old.constant_number(constant);
                self.new.constant(number).into()
            }
            OperandKind::Input(input) => {
                let place = self.old.input_array(input);
                let array = &self.old.inputs()[place];
                let offset = self.inputs[place * count as usize + instance as usize - 1];
                Input(offset + input.0 - array.offset).into()
            }
            OperandKind::None => operand,
        }
    }

    fn assignments(&mut self) {
        let old = self.old;
        let count = self.instances.count;
        for assignment in &old.assignments {
            let output = assignment.output.0;
            let place = old.output_array(assignment.output);
            let array = &old.outputs()[place];
            for instance in 1..=count {
                let offset = self.outputs[place * count as usize + instance as usize - 1];
                let operand = self.operand(assignment.operand, instance);
                self.new.assign(
                    Output(offset + output - array.offset),
                    operand,
                    assignment.sources,
                );
            }
        }
        self.new.sort_assignments();
    }

    fn finish(self) -> Function {
        self.new
    }
}
