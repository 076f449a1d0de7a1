//! The arrays of a function: their extents, and one number for every element.
//!
//! In C and Python `s->frc`, the parameter `frc` and a local alias are the
//! same memory, so one array stands for all of them. In Matlab `frc = s.frc`
//! is a copy: `s.frc` is an array of its own that keeps its first values.

use super::Language;
use super::conventions::known_extent;
use super::explain::refusal;
use super::syntax::{
    FunctionHeader, LeafKind, StatementKind, SyntaxLeaf, SyntaxStatement, SyntaxTree,
};
use super::token::{RobotranName, SourceSpan};
use hashbrown::{HashMap, HashSet};
use robovec_ir::diagnostic::Diagnostic;
use robovec_ir::{Shape, Symbol, Symbols};
use rustc_hash::FxBuildHasher;
use std::ops::Range;

/// The rank in [`ArrayUse`] of what a pointer points at.
const POINTED_AT: u32 = 3;

/// More elements than this are taken for a slip in an index.
const LARGEST_STORAGE: u64 = 4_000_000;

/// What an element holds before the function writes it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Initial {
    /// What the caller put there: the same element of the input array of this
    /// name.
    Input(Symbol),
    /// Zero: `M = zeros(6,6)`.
    Zero,
    /// Nothing: a local array of C.
    Nothing,
}

/// An array.
#[derive(Clone, Copy, Debug)]
pub(super) struct StoredArray {
    pub(super) name: RobotranName,
    pub(super) shape: Shape,
    /// The number of its first element.
    pub(super) offset: u32,
    pub(super) initial: Initial,
    /// True when only the function itself sees it.
    pub(super) local: bool,
    /// Rows and columns that hold something from the start, where `initial`
    /// is zero.
    pub(super) held: (u32, u32),
    /// False for an array that nothing says where its numbers come from.
    pub(super) known: bool,
}

/// The arrays of a function, in order of first appearance.
#[derive(Clone, Default, Debug)]
pub(super) struct Storage {
    pub(super) arrays: Vec<StoredArray>,
    /// How many elements they have together.
    pub(super) len: usize,
    names: Vec<RobotranName>,
    numbers: HashMap<RobotranName, u32, FxBuildHasher>,
    /// Other names of an array (`Qq = phi`).
    aliases: HashMap<RobotranName, RobotranName, FxBuildHasher>,
    /// Matlab's `frc = s.frc`: the statement, the copy and the original.
    copies: Vec<(usize, RobotranName, RobotranName)>,
    /// Arrays that a statement of the prologue names.
    bound: HashMap<RobotranName, RobotranName, FxBuildHasher>,
    /// The arrays of the structure that are used under its name (`s->q`), and
    /// those that the prologue or a call gives.
    members: HashSet<Symbol, FxBuildHasher>,
    /// Pointers that are declared without an array, with the statement.
    pointers: HashMap<RobotranName, usize, FxBuildHasher>,
    given: HashSet<RobotranName, FxBuildHasher>,
    /// The extents of the input arrays; several arrays may begin as the same
    /// one (Matlab's `frc` and `s.frc`).
    input_shapes: HashMap<Symbol, Shape, FxBuildHasher>,
    joined: bool,
}

impl Storage {
    /// The name under which an array is stored.
    pub(super) fn canonical(&self, name: RobotranName) -> RobotranName {
        // `s->qd` is the array of the structure whatever `qd` means.
        if self.joined && name.is_of_data() {
            return RobotranName::local(name.symbol());
        }
        self.aliases.get(&name).copied().unwrap_or(name)
    }

    /// The number of an array.
    pub(super) fn find(&self, name: RobotranName) -> Option<u32> {
        self.numbers.get(&self.canonical(name)).copied()
    }

    /// The array and the indices of an element.
    pub(super) fn element(&self, slot: u32) -> (&StoredArray, [u32; 2], usize) {
        let after = self.arrays.partition_point(|array| array.offset <= slot);
        let array = &self.arrays[after - 1];
        let (indices, rank) = array.shape.indices(slot - array.offset);
        (array, indices, rank)
    }
}

/// Names that are arrays even where no element of them is used.
fn is_array_name(name: &str) -> bool {
    known_extent(name, 0).is_some()
        || matches!(name, "h" | "Jdqd" | "lrod" | "Z" | "Zd" | "Flink" | "Flnk")
}

/// True where one of Robotran's arrays has another number of indices: one
/// index into a matrix means another element in Matlab and a row in Python.
fn is_known_otherwise(name: &str, rank: u32) -> bool {
    match name {
        "q" | "qd" | "qdd" | "Qq" | "c" | "m" => rank == 2,
        "M" | "Jac" | "l" | "In" | "frc" | "trq" | "dpt" | "sens.R" | "sens.J" => rank == 1,
        _ => false,
    }
}

/// Builds the storage of a function and replaces, in its elements, the column
/// by the array's number and the row by the number of the element.
pub(super) struct StorageBuilder<'a> {
    pub(super) syntax: &'a mut SyntaxTree,
    pub(super) symbols: &'a Symbols,
    pub(super) language: Language,
    pub(super) head: Option<&'a FunctionHeader>,
    pub(super) statements: Range<usize>,
    pub(super) elements: Range<usize>,
    pub(super) joints: u32,
    /// Not written by robovec, whose functions may have any arrays.
    pub(super) foreign: bool,
    /// Extents the header states.
    pub(super) extents: &'a [(String, u32, u32)],
    pub(super) errors: Vec<Diagnostic>,
    pub(super) warnings: Vec<Diagnostic>,
}

#[derive(Clone, Copy, Default)]
struct ArrayUse {
    rank: u32,
    rows: u32,
    columns: u32,
}

impl StorageBuilder<'_> {
    /// The storage, of use only without errors; these and the warnings are
    /// left in the builder.
    pub(super) fn build(&mut self) -> Storage {
        let mut storage = Storage {
            joined: self.language != Language::Matlab,
            ..Storage::default()
        };
        self.find_aliases(&mut storage);
        let uses = self.collect_uses(&mut storage);
        self.lay_out(&mut storage, &uses);
        if !self.errors.is_empty() {
            return storage;
        }
        self.replace_elements(&mut storage);
        self.find_initials(&mut storage);
        self.find_input_shapes(&mut storage, &uses);
        storage
    }

    /// Whole-array assignments of the prologue: `q = s->q;`, `Qq = phi`.
    fn find_aliases(&mut self, storage: &mut Storage) {
        let mut first_uses: HashMap<RobotranName, u32, FxBuildHasher> = HashMap::default();
        let mut arrays: HashSet<Symbol, FxBuildHasher> = HashSet::default();
        for index in self.elements.clone().rev() {
            let name = self.syntax.elements[index].name;
            first_uses.insert(name, index as u32);
            arrays.insert(name.symbol());
        }
        let statements = self.statements.clone();
        storage.pointers = (statements.clone())
            .filter_map(|index| match self.syntax.statements[index].kind {
                StatementKind::Pointer(name) => Some((name, index)),
                _ => None,
            })
            .collect();
        let first_writings = match storage.joined {
            true => HashMap::default(),
            false => self.first_writings(),
        };
        let symbols = self.symbols;
        let is_array = |name: RobotranName| {
            arrays.contains(&name.symbol()) || is_array_name(symbols.text(name.symbol()))
        };
        for index in self.statements.clone() {
            let statement = self.syntax.statements[index];
            let StatementKind::Equation { target, root, .. } = statement.kind else {
                continue;
            };
            let (LeafKind::Scalar(target), LeafKind::Scalar(root)) = (target.kind(), root.kind())
            else {
                continue;
            };
            let whole_array = is_array(target) || (root.is_of_data() && is_array(root));
            if !whole_array {
                continue;
            }
            self.syntax.statements[index].kind = StatementKind::Prologue;
            let used = |name: RobotranName| {
                let first = first_uses.get(&name);
                first.is_some_and(|&first| first < statement.elements)
            };
            let original = storage.canonical(root);
            let same = storage.joined && target.symbol() == root.symbol();
            let again = storage.bound.insert(target, original);
            if storage.joined {
                let changed = again.is_some_and(|before| before != original);
                let own = same && !storage.pointers.contains_key(&target);
                if changed || target.is_of_data() || (!own && used(target)) {
                    self.late_meaning(target, statement.span);
                }
            } else {
                // The copy, or the original, has other numbers by now.
                let written = first_writings.get(&root);
                if used(target) || written.is_some_and(|&first| first < index) {
                    self.late_meaning(target, statement.span);
                }
                storage.copies.push((index, target, root));
                continue;
            }
            let parameter = self
                .head
                .is_some_and(|head| head.parameters.contains(&root));
            if root.is_of_data() || parameter || storage.given.contains(&original) {
                storage.given.insert(original);
                storage.given.insert(target);
            }
            if same {
                continue;
            }
            if parameter && !is_array_name(symbols.text(root.symbol())) {
                storage.aliases.insert(root, target);
            } else {
                storage.aliases.insert(target, original);
            }
        }
    }

    /// For every array the statement that first sets an element of it.
    fn first_writings(&self) -> HashMap<RobotranName, usize, FxBuildHasher> {
        let mut first = HashMap::default();
        for index in self.statements.clone() {
            if let StatementKind::Equation { target, .. } = self.syntax.statements[index].kind
                && let LeafKind::Element(element) = target.kind()
            {
                let name = self.syntax.elements[element as usize].name;
                first.entry(name).or_insert(index);
            }
        }
        first
    }

    fn late_meaning(&mut self, name: RobotranName, span: SourceSpan) {
        let text = self.symbols.text(name.symbol());
        self.errors.push(refusal(
            &format!("`{text}` means another array from here on"),
            span,
            "its elements are used before, or it has a meaning already",
            "give every array one name, before its first element is used",
        ));
    }

    fn collect_uses(&mut self, storage: &mut Storage) -> Vec<ArrayUse> {
        let mut uses: Vec<ArrayUse> = Vec::new();
        let mut last = (RobotranName::local(Symbol(u32::MAX >> 1)), 0);
        for index in self.elements.clone() {
            let element = self.syntax.elements[index];
            if element.name != last.0 && element.name.is_of_data() {
                storage.members.insert(element.name.symbol());
            }
            let number = if element.name == last.0 {
                last.1
            } else {
                storage.number(element.name, &mut uses)
            };
            last = (element.name, number);
            let rank = match (element.row, element.column) {
                (0, 0) => POINTED_AT,
                (_, 0) => 1,
                _ => 2,
            };
            let used = &mut uses[number as usize];
            if used.rank != 0 && used.rank != rank {
                self.wrong_rank(index, element.name);
                continue;
            }
            used.rank = rank;
            used.rows = used.rows.max(element.row);
            used.columns = used.columns.max(element.column);
        }
        self.check_extents(storage, &uses);
        for statement in self.statements.clone() {
            if let StatementKind::Extent(extent) = self.syntax.statements[statement].kind {
                let extent = self.syntax.extents[extent as usize];
                if let Some(number) = storage.find(extent.name) {
                    let used = &mut uses[number as usize];
                    used.rows = used.rows.max(extent.rows);
                    if used.rank == 2 {
                        used.columns = used.columns.max(extent.columns);
                    }
                }
            }
        }
        self.add_results(storage, &mut uses);
        uses
    }

    /// Refuses declarations that C and Python would take for other arrays
    /// than one per name, elements outside them, and `zeros` that come late.
    fn check_extents(&mut self, storage: &Storage, uses: &[ArrayUse]) {
        let mut first_uses: HashMap<RobotranName, u32, FxBuildHasher> = HashMap::default();
        for index in self.elements.clone().rev() {
            first_uses.insert(self.syntax.elements[index].name, index as u32);
        }
        let mut declared: HashSet<RobotranName, FxBuildHasher> = HashSet::default();
        for statement in self.statements.clone() {
            let SyntaxStatement {
                kind: StatementKind::Extent(extent),
                span,
                elements,
            } = self.syntax.statements[statement]
            else {
                continue;
            };
            let extent = self.syntax.extents[extent as usize];
            let first = first_uses.get(&extent.name);
            let late = first.is_some_and(|&first| first < elements);
            let twice = !declared.insert(extent.name);
            let of_data = RobotranName::of_data(extent.name.symbol());
            let hides = storage.joined
                && (storage.bound.contains_key(&extent.name)
                    || first_uses.contains_key(&of_data)
                    || (self.language == Language::Python
                        && self
                            .head
                            .is_some_and(|head| head.parameters.contains(&extent.name))));
            if late || (twice && storage.joined) || hides {
                self.late_meaning(extent.name, span);
                continue;
            }
            let outside = storage.find(extent.name).is_some_and(|number| {
                let used = uses[number as usize];
                used.rows > extent.rows || (used.rank == 2 && used.columns > extent.columns)
            });
            if outside && storage.joined {
                let text = self.symbols.text(extent.name.symbol());
                self.errors.push(refusal(
                    &format!("an element outside the array `{text}` is used"),
                    span,
                    "the array is declared here",
                    "declare the array large enough, or correct the index",
                ));
            }
        }
    }

    /// The result of an external force has nine numbers.
    fn add_results(&mut self, storage: &mut Storage, uses: &mut Vec<ArrayUse>) {
        for statement in self.statements.clone() {
            if let StatementKind::Call(call) = self.syntax.statements[statement].kind
                && let call = self.syntax.calls[call as usize]
                && let Some(LeafKind::Scalar(target)) = call.target.map(SyntaxLeaf::kind)
            {
                let target = storage.canonical(target);
                storage.given.insert(target);
            }
        }
        for statement in self.statements.clone() {
            if let StatementKind::Call(call) = self.syntax.statements[statement].kind
                && let call = self.syntax.calls[call as usize]
                && let Some(LeafKind::Scalar(target)) = call.target.map(SyntaxLeaf::kind)
                && matches!(
                    self.symbols.text(call.callee.symbol()),
                    "user_ExtForces" | "user_call_ExtForces" | "usrfun.fext"
                )
            {
                let number = storage.number(target, uses);
                let used = &mut uses[number as usize];
                used.rank = used.rank.max(1);
                used.rows = used.rows.max(9);
            }
        }
    }

    fn lay_out(&mut self, storage: &mut Storage, uses: &[ArrayUse]) {
        let mut total = 0u64;
        for (name, used) in storage.names.clone().into_iter().zip(uses) {
            let text = self.symbols.text(name.symbol());
            if self.foreign && self.language != Language::C && is_known_otherwise(text, used.rank) {
                self.unknown_rank(storage, name);
            }
            let mut stated = self.extents.iter();
            let known = match stated.find(|(name, _, _)| name == text) {
                Some(&(_, rows, columns)) => Some((rows, columns)),
                None => known_extent(text, self.joints),
            };
            let (rows, columns) = known.unwrap_or((0, 0));
            self.check_joints(text, used);
            let rows = rows.max(used.rows).max(1);
            let columns = columns.max(used.columns).max(1);
            let shape = match used.rank {
                2 => Shape::Matrix(rows, columns),
                POINTED_AT => Shape::Scalar,
                _ => Shape::Vector(rows),
            };
            storage.arrays.push(StoredArray {
                name,
                shape,
                offset: total.min(LARGEST_STORAGE) as u32,
                initial: Initial::Nothing,
                local: false,
                held: (0, 0),
                known: true,
            });
            total = total.saturating_add(shape.len() as u64);
            if total > LARGEST_STORAGE {
                self.too_large(name, used);
                storage.len = 0;
                return;
            }
        }
        storage.len = total as usize;
    }

    /// Warns when the equations know more joints than the header.
    fn check_joints(&mut self, text: &str, used: &ArrayUse) {
        let joint = match text {
            "q" | "qd" | "qdd" | "m" | "c" | "Qq" => used.rows,
            "l" | "In" | "frc" | "trq" => used.columns,
            _ => 0,
        };
        if self.joints > 0 && joint > self.joints {
            self.warnings.push(
                Diagnostic::warning()
                    .with_message(format!(
                        "the header says {} joints, but joint {joint} of `{text}` is used",
                        self.joints
                    ))
                    .with_note(
                        "header and equations come from different models; generate the file again",
                    ),
            );
        }
    }

    fn replace_elements(&mut self, storage: &mut Storage) {
        let mut last = (RobotranName::local(Symbol(u32::MAX >> 1)), 0);
        for index in self.elements.clone() {
            let element = self.syntax.elements[index];
            if element.name != last.0 {
                last = (element.name, storage.find(element.name).unwrap_or(0));
            }
            let array = storage.arrays[last.1 as usize];
            let column = element.column;
            let indices = [element.row, column];
            let rank = match (element.row, column) {
                (0, 0) => 0,
                (_, 0) => 1,
                _ => 2,
            };
            // Extents cover every use; a use of the wrong rank is an error
            // reported before.
            let offset = array.shape.offset(&indices[..rank]).unwrap_or(0);
            let replaced = &mut self.syntax.elements[index];
            replaced.row = array.offset + offset;
            replaced.column = last.1;
        }
    }

    fn find_initials(&mut self, storage: &mut Storage) {
        for number in 0..storage.arrays.len() {
            let name = storage.arrays[number].name;
            storage.arrays[number].initial = Initial::Input(name.symbol());
            storage.arrays[number].known = self.is_known(storage, name);
            let declared = storage.pointers.get(&name);
            if let Some(&declared) = declared
                && !storage.given.contains(&name)
                && !storage.bound.contains_key(&name)
            {
                let text = self.symbols.text(name.symbol());
                self.errors.push(refusal(
                    &format!("the pointer `{text}` points at no array"),
                    self.syntax.statements[declared].span,
                    "declared here",
                    "let it point at an array of the structure before its first use: `q = s->q;`",
                ));
            }
        }
        let mut copies = std::mem::take(&mut storage.copies).into_iter().peekable();
        for index in self.statements.clone() {
            let statement = self.syntax.statements[index];
            if let Some((_, copy, original)) = copies.next_if(|&(at, _, _)| at == index)
                && let Some(copy) = storage.find(copy)
            {
                let begins = match storage.find(original) {
                    Some(known) if !original.is_of_data() => storage.arrays[known as usize].initial,
                    Some(_) | None => Initial::Input(original.symbol()),
                };
                storage.arrays[copy as usize].initial = begins;
                storage.arrays[copy as usize].known = true;
            }
            if let StatementKind::Extent(extent) = statement.kind
                && let extent = self.syntax.extents[extent as usize]
                && let Some(number) = storage.find(extent.name)
            {
                let local = !self.is_visible(extent.name);
                let array = &mut storage.arrays[number as usize];
                array.held = (extent.rows, extent.columns.max(1));
                array.local = local;
                array.initial = match extent.zeroed {
                    true => Initial::Zero,
                    false => Initial::Nothing,
                };
            }
        }
        if self.language == Language::Matlab {
            // The structure `s` is a copy of the caller's; what is written to
            // it is lost at the end.
            for number in 0..storage.arrays.len() {
                let name = storage.arrays[number].name;
                let returned = self.head.is_none_or(|head| head.outputs.is_empty());
                let visible = returned || self.is_visible(name);
                storage.arrays[number].local = name.is_of_data() || !visible;
            }
        }
    }

    /// True for an array whose first numbers are the caller's: one of
    /// Robotran's, a parameter, one that the prologue or a call gives.
    fn is_known(&self, storage: &Storage, name: RobotranName) -> bool {
        let text = self.symbols.text(name.symbol());
        let structure = text.split_once('.').map(|(structure, _)| structure);
        let of_data = storage.members.contains(&name.symbol());
        self.head.is_none()
            || name.is_of_data()
            || of_data
            || structure.is_none() && is_array_name(text)
            || self.is_visible(name)
            || storage.given.contains(&name)
    }

    fn find_input_shapes(&mut self, storage: &mut Storage, uses: &[ArrayUse]) {
        for (number, used) in uses.iter().enumerate() {
            let array = storage.arrays[number];
            let Initial::Input(name) = array.initial else {
                continue;
            };
            if used.rank == 0 {
                continue;
            }
            let known = storage.input_shapes.entry(name).or_insert(array.shape);
            *known = match (*known, array.shape) {
                (Shape::Scalar, Shape::Scalar) => Shape::Scalar,
                (Shape::Vector(a), Shape::Vector(b)) => Shape::Vector(a.max(b)),
                (Shape::Matrix(a, b), Shape::Matrix(c, d)) => Shape::Matrix(a.max(c), b.max(d)),
                _ => {
                    let mut elements = self.elements.clone();
                    let first =
                        elements.find(|&index| self.syntax.elements[index].column == number as u32);
                    self.wrong_rank(first.unwrap_or(0), array.name);
                    return;
                }
            };
        }
    }

    /// True for an array the caller sees: a parameter or a result.
    fn is_visible(&self, name: RobotranName) -> bool {
        let Some(head) = self.head else {
            return true;
        };
        let text = self.symbols.text(name.symbol());
        let structure = text.split('.').next().unwrap_or(text);
        let mut visible = head.parameters.iter().chain(&head.outputs);
        visible.any(|parameter| {
            *parameter == name || self.symbols.text(parameter.symbol()) == structure
        })
    }

    fn too_large(&mut self, name: RobotranName, used: &ArrayUse) {
        let mut elements = self.elements.clone();
        let largest = elements.find(|&index| {
            let element = self.syntax.elements[index];
            let extreme = element.row == used.rows || element.column == used.columns;
            element.name.symbol() == name.symbol() && extreme
        });
        let element = largest.unwrap_or(0) as u32;
        let span = statement_of_element(self.syntax, self.statements.clone(), element);
        let text = self.symbols.text(name.symbol());
        self.errors.push(refusal(
            &format!("`{text}` makes the arrays larger than any model needs"),
            span,
            "uses an extreme index",
            &format!("together they may have {LARGEST_STORAGE} elements; correct the index"),
        ));
    }

    fn unknown_rank(&mut self, storage: &Storage, name: RobotranName) {
        let mut elements = self.elements.clone();
        let first =
            elements.find(|&index| storage.canonical(self.syntax.elements[index].name) == name);
        let element = first.unwrap_or(0) as u32;
        let span = statement_of_element(self.syntax, self.statements.clone(), element);
        let text = self.symbols.text(name.symbol());
        self.errors.push(refusal(
            &format!("Robotran's array `{text}` has another number of indices"),
            span,
            "used here",
            "a vector has one index, a matrix two",
        ));
    }

    fn wrong_rank(&mut self, element: usize, name: RobotranName) {
        let span = statement_of_element(self.syntax, self.statements.clone(), element as u32);
        let name = self.symbols.text(name.symbol());
        self.errors.push(refusal(
            &format!("`{name}` is used with one index and with two"),
            span,
            "differs from an earlier use",
            "an array has one number of indices; correct the odd one",
        ));
    }
}

impl Storage {
    /// The extent of an input array.
    pub(super) fn input_shape(&self, name: Symbol) -> Option<Shape> {
        self.input_shapes.get(&name).copied()
    }

    fn number(&mut self, name: RobotranName, uses: &mut Vec<ArrayUse>) -> u32 {
        let name = self.canonical(name);
        let next = uses.len() as u32;
        let number = *self.numbers.entry(name).or_insert(next);
        if number == next {
            uses.push(ArrayUse::default());
            self.names.push(name);
        }
        number
    }
}

/// The statement that holds an element: for messages only.
fn statement_of_element(syntax: &SyntaxTree, statements: Range<usize>, element: u32) -> SourceSpan {
    for statement in &syntax.statements[statements.clone()] {
        let StatementKind::Equation {
            target,
            root,
            first,
            end,
        } = statement.kind
        else {
            continue;
        };
        let nodes = &syntax.nodes[first as usize..end as usize];
        let mut leaves = nodes
            .iter()
            .flat_map(|node| node.operands())
            .chain([&target, &root]);
        if leaves.any(|leaf| leaf.kind() == LeafKind::Element(element)) {
            return statement.span;
        }
    }
    let first = syntax.statements.get(statements.start);
    first.map_or(SourceSpan { start: 0, end: 0 }, |statement| statement.span)
}
