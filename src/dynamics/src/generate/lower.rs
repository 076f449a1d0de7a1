//! From generated equations to a function of the representation.
//!
//! Only equations on which outputs depend are written: a backward sweep marks
//! them, a forward sweep appends the trees. Arrays get the extents and the
//! order that the reader of Robotran's files gives them, so that a function
//! does not change during the run through a file.

use super::algebra::{ProductFactor, Scalar, SignedProduct, Sum};
use super::equations::{Atom, Equations, RightHandSide};
use robovec_ir::{
    Array, Assignment, Function, Input, Module, Name, Node, Operand, Operation, Output, Shape,
    SourceSet, Symbol, Tables,
};
use robovec_robotran::conventions::{INPUT_ORDER, least_extent};

/// Parameters of Robotran's functions, in their order; others come after.
const OUTPUT_ORDER: [&str; 11] = [
    "M", "c", "Qq", "h", "Jac", "Jdqd", "frc", "trq", "Flink", "Z", "Zd",
];

pub(super) struct Extents {
    pub(super) joints: u32,
    /// The columns of `dpt`: the largest number of a point that is used.
    pub(super) points: u32,
    /// The columns of `Y` that are written; all when none.
    pub(super) columns: u32,
}

impl Extents {
    pub(super) fn shape(&self, array: &str, indices: usize, used: (u32, u32)) -> Shape {
        let (rows, columns) = least_extent(array, self.joints);
        let columns = match array {
            "dpt" => self.points,
            "Y" if self.columns > 0 => self.columns,
            _ => columns,
        };
        match indices {
            0 => Shape::Scalar,
            1 => Shape::Vector(rows.max(used.0)),
            _ => Shape::Matrix(rows.max(used.0), columns.max(used.1)),
        }
    }
}

/// The largest number of a point whose coordinates the outputs need.
pub(super) fn points(equations: &Equations) -> u32 {
    let needed = needed(equations);
    let atoms = equations.atoms.iter().zip(needed);
    atoms
        .filter_map(|(atom, needed)| match *atom {
            Atom::Input { array, indices } if needed => {
                (equations.arrays[array as usize].0 == "dpt").then_some(indices[1])
            }
            _ => None,
        })
        .fold(0, u32::max)
}

pub(super) fn lower(
    equations: &Equations,
    extents: &Extents,
    mut function: Function,
    module: &mut Module,
) {
    let needed = needed(equations);
    function.boundaries.clone_from(&equations.calls);
    let inputs = declare_inputs(
        equations,
        extents,
        &needed,
        &mut function,
        &mut module.tables,
    );
    let outputs = declare_outputs(equations, extents, &mut function, &mut module.tables);
    let mut writer = FunctionWriter {
        equations,
        function,
        tables: &mut module.tables,
        operands: vec![Operand::NONE; equations.atoms.len()],
        names: hashbrown::HashSet::new(),
    };
    for (index, atom) in equations.atoms.iter().enumerate() {
        writer.atom(index, *atom, &needed, &inputs);
    }
    // Outputs may have trees of their own (a sign); they stand behind all
    // definitions, in the order of the output elements.
    let mut ordered: Vec<(Output, Scalar)> = equations
        .outputs
        .iter()
        .map(|&(array, indices, value)| {
            let array = outputs[array as usize];
            let rank = usize::from(indices[0] > 0) + usize::from(indices[1] > 0);
            let offset = array.shape.offset(&indices[..rank]);
            let offset = offset.expect("an array is as large as its outputs need");
            (Output(array.offset + offset), value)
        })
        .collect();
    ordered.sort_by_key(|&(output, _)| output);
    for (output, value) in ordered {
        writer.output(output, value);
    }
    module.functions.push(writer.function);
}

/// Number of operations that the outputs need, leading signs not counted.
pub(super) fn operations(equations: &Equations) -> usize {
    let needed = needed(equations);
    let mut groups: Vec<usize> = Vec::with_capacity(equations.groups.len());
    for group in &equations.groups {
        let operations = operations_of(group, &groups);
        groups.push(operations);
    }
    let atoms = equations.atoms.iter().zip(&needed);
    let bodies = atoms.filter_map(|(atom, needed)| match *atom {
        Atom::Equation(equation) if *needed => Some(&equations.equations[equation as usize].body),
        _ => None,
    });
    let operations = bodies.map(|body| match body {
        RightHandSide::Sum(sum) => operations_of(sum, &groups),
        RightHandSide::Sqrt(_) | RightHandSide::Quotient(..) => 1,
        _ => 0,
    });
    operations.sum()
}

fn operations_of(sum: &Sum, groups: &[usize]) -> usize {
    let term = |term: &SignedProduct| {
        let inner = term.factors.iter().map(|factor| match *factor {
            ProductFactor::Group(group) => groups[group as usize],
            ProductFactor::Atom(_) => 0,
        });
        inner.sum::<usize>() + term.factors.len().saturating_sub(1)
    };
    sum.terms.iter().map(term).sum::<usize>() + sum.terms.len().saturating_sub(1)
}

/// Atoms that the outputs need.
fn needed(equations: &Equations) -> Vec<bool> {
    let mut needed = vec![false; equations.atoms.len()];
    let mut groups = vec![false; equations.groups.len()];
    for &(_, _, value) in &equations.outputs {
        needed[value.atom() as usize] = true;
    }
    // An equation reads only atoms before it, and a group only groups before it.
    let mut pending: Vec<u32> = Vec::new();
    for index in (0..equations.atoms.len()).rev() {
        let Atom::Equation(equation) = equations.atoms[index] else {
            continue;
        };
        if !needed[index] {
            continue;
        }
        match &equations.equations[equation as usize].body {
            RightHandSide::Sum(sum) => mark(sum, &mut needed, &mut pending),
            RightHandSide::Copy(a)
            | RightHandSide::Sin(a)
            | RightHandSide::Cos(a)
            | RightHandSide::Sqrt(a) => needed[a.atom() as usize] = true,
            RightHandSide::Quotient(a, b) => {
                needed[a.atom() as usize] = true;
                needed[b.atom() as usize] = true;
            }
        }
        while let Some(group) = pending.pop() {
            if !std::mem::replace(&mut groups[group as usize], true) {
                mark(&equations.groups[group as usize], &mut needed, &mut pending);
            }
        }
    }
    needed
}

fn mark(sum: &Sum, needed: &mut [bool], pending: &mut Vec<u32>) {
    for factor in sum.terms.iter().flat_map(|term| &term.factors) {
        match *factor {
            ProductFactor::Atom(atom) => needed[atom as usize] = true,
            ProductFactor::Group(group) => pending.push(group),
        }
    }
}

/// Declares the arrays that are read; returns each atom's flattened input.
fn declare_inputs(
    equations: &Equations,
    extents: &Extents,
    needed: &[bool],
    function: &mut Function,
    tables: &mut Tables,
) -> Vec<Option<Input>> {
    let mut used: Vec<Option<(u32, u32)>> = vec![None; equations.arrays.len()];
    for (index, atom) in equations.atoms.iter().enumerate() {
        if let (Atom::Input { array, indices }, true) = (*atom, needed[index]) {
            let most = used[array as usize].get_or_insert((0, 0));
            most.0 = most.0.max(indices[0]);
            most.1 = most.1.max(indices[1]);
        }
    }
    let mut order: Vec<usize> = (0..equations.arrays.len()).collect();
    order.sort_by_key(|&array| {
        let name = &equations.arrays[array].0;
        let before = INPUT_ORDER.iter().take_while(|known| *known != name);
        before.count()
    });
    let mut declared: Vec<Option<Array>> = vec![None; equations.arrays.len()];
    for array in order {
        let (name, indices) = &equations.arrays[array];
        if let Some(used) = used[array] {
            let shape = extents.shape(name, *indices, used);
            declared[array] = Some(function.add_input(tables.symbols.intern(name), shape));
        }
    }
    let element = |atom: &Atom| match *atom {
        Atom::Input { array, indices } => {
            let declared = declared[array as usize]?;
            let rank = equations.arrays[array as usize].1;
            let offset = declared.shape.offset(&indices[..rank])?;
            Some(Input(declared.offset + offset))
        }
        _ => None,
    };
    equations.atoms.iter().map(element).collect()
}

/// Declares the output arrays, in the order of [`Equations::results`].
fn declare_outputs(
    equations: &Equations,
    extents: &Extents,
    function: &mut Function,
    tables: &mut Tables,
) -> Vec<Array> {
    let mut used = vec![(0, 0); equations.results.len()];
    for &(array, indices, _) in &equations.outputs {
        let most: &mut (u32, u32) = &mut used[array as usize];
        most.0 = most.0.max(indices[0]);
        most.1 = most.1.max(indices[1]);
    }
    let rank = |name: &str| {
        let before = OUTPUT_ORDER.iter().take_while(|known| **known != name);
        before.count()
    };
    let mut order: Vec<usize> = (0..used.len()).collect();
    order.sort_by_key(|&array| rank(&equations.results[array]));
    let mut declared = vec![None; used.len()];
    for array in order {
        let (name, most) = (&equations.results[array], used[array]);
        let indices = usize::from(most.0 > 0) + usize::from(most.1 > 0);
        let shape = extents.shape(name, indices, most);
        declared[array] = Some(function.add_output(tables.symbols.intern(name), shape));
    }
    let declared = declared.into_iter();
    declared
        .map(|array| array.expect("every array is in the order"))
        .collect()
}

struct FunctionWriter<'a> {
    equations: &'a Equations,
    function: Function,
    tables: &'a mut Tables,
    /// The operand of every atom that was written.
    operands: Vec<Operand>,
    names: hashbrown::HashSet<Symbol>,
}

impl FunctionWriter<'_> {
    fn atom(&mut self, index: usize, atom: Atom, needed: &[bool], inputs: &[Option<Input>]) {
        self.operands[index] = match atom {
            _ if !needed[index] => Operand::NONE,
            Atom::Zero => self.function.constant(0.0).into(),
            Atom::One => self.function.constant(1.0).into(),
            Atom::Number(number) => self.function.constant(number).into(),
            Atom::Input { .. } => inputs[index].expect("what is needed is declared").into(),
            Atom::Equation(equation) => self.equation(equation),
        };
    }

    fn equation(&mut self, number: u32) -> Operand {
        let equation = &self.equations.equations[number as usize];
        let operand = match &equation.body {
            RightHandSide::Sum(sum) => self.sum(sum),
            RightHandSide::Copy(a) => {
                let operation = if a.is_negative() {
                    Operation::Neg
                } else {
                    Operation::Copy
                };
                let operand = self.operand(*a);
                self.node(operation, [operand, Operand::NONE])
            }
            RightHandSide::Sin(a) => self.unary(Operation::Sin, *a),
            RightHandSide::Cos(a) => self.unary(Operation::Cos, *a),
            RightHandSide::Sqrt(a) => self.unary(Operation::Sqrt, *a),
            RightHandSide::Quotient(a, b) => {
                let operands = [self.operand(*a), self.operand(*b)];
                self.node(Operation::Div, operands)
            }
        };
        let mut symbol = self.tables.symbols.intern(&equation.label.text());
        // Labels differ by construction; should two formulations ever share
        // one, the later gets a number.
        let mut number = 1;
        while !self.names.insert(symbol) {
            let text = format!("{}_{number}", equation.label.text());
            symbol = self.tables.symbols.intern(&text);
            number += 1;
        }
        if let Some(value) = operand.value() {
            self.function.node_mut(value).name = Name::plain(symbol);
        }
        operand
    }

    fn unary(&mut self, operation: Operation, scalar: Scalar) -> Operand {
        let operand = self.signed(scalar);
        self.node(operation, [operand, Operand::NONE])
    }

    fn operand(&self, scalar: Scalar) -> Operand {
        let operand = self.operands[scalar.atom() as usize];
        assert!(!operand.is_none(), "what is read was written before");
        operand
    }

    fn signed(&mut self, scalar: Scalar) -> Operand {
        let operand = self.operand(scalar);
        if scalar.is_negative() {
            self.node(Operation::Neg, [operand, Operand::NONE])
        } else {
            operand
        }
    }

    fn node(&mut self, operation: Operation, operands: [Operand; 2]) -> Operand {
        self.function
            .push(Node {
                name: Name::NONE,
                sources: SourceSet::EMPTY,
                operands: Operand::list(operands),
                operation,
            })
            .into()
    }

    /// A sum, from left to right; groups nest as deep as formulations write.
    fn sum(&mut self, sum: &Sum) -> Operand {
        let mut total = Operand::NONE;
        for term in &sum.terms {
            let product = self.term(term);
            total = match (total.is_none(), term.negative) {
                (true, false) => product,
                (true, true) => self.node(Operation::Neg, [product, Operand::NONE]),
                (false, false) => self.node(Operation::Add, [total, product]),
                (false, true) => self.node(Operation::Sub, [total, product]),
            };
        }
        total
    }

    fn term(&mut self, term: &SignedProduct) -> Operand {
        let mut product = Operand::NONE;
        for factor in &term.factors {
            let operand = match *factor {
                ProductFactor::Atom(atom) => self.operands[atom as usize],
                ProductFactor::Group(group) => {
                    let equations = self.equations;
                    self.sum(&equations.groups[group as usize])
                }
            };
            product = if product.is_none() {
                operand
            } else {
                self.node(Operation::Mul, [product, operand])
            };
        }
        if product.is_none() {
            self.function.constant(1.0).into()
        } else {
            product
        }
    }

    fn output(&mut self, output: Output, value: Scalar) {
        let operand = self.signed(value);
        self.function.assignments.push(Assignment {
            output,
            operand,
            sources: SourceSet::EMPTY,
        });
    }
}
