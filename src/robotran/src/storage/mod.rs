//! The arrays of a function: their extents, and one number for every element.
//!
//! In C and Python `s->frc`, the parameter `frc` and a local alias are the
//! same memory, so one array represents all of them. In Matlab `frc = s.frc`
//! is a copy: `s.frc` is its own array that keeps its first values.

mod aliases;
mod layout;
mod uses;

use super::Language;
use super::conventions::known_extent;
use super::syntax::{FunctionHeader, SyntaxTree};
use super::token::RobotranName;
use hashbrown::{HashMap, HashSet};
use robovec_ir::diagnostic::Diagnostic;
use robovec_ir::{Shape, Symbol, Symbols};
use rustc_hash::FxBuildHasher;
use std::ops::Range;

/// The rank in [`ArrayUse`] of the target of a pointer.
const POINTED_AT: u32 = 3;

/// More elements than this are taken for a slip in an index.
const LARGEST_STORAGE: u64 = 4_000_000;

/// Value of an element before the function writes it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Initial {
    /// Value from the caller: the same element of the input array of this name.
    Input(Symbol),
    /// Zero: `M = zeros(6,6)`.
    Zero,
    /// No origin: a local array of C.
    Nothing,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct StoredArray {
    pub(super) name: RobotranName,
    pub(super) shape: Shape,
    /// The number of its first element.
    pub(super) offset: u32,
    pub(super) initial: Initial,
    /// True when only the function itself sees it.
    pub(super) local: bool,
    /// Rows and columns with initial values, where `initial` is zero.
    pub(super) held: (u32, u32),
    /// False for an array without a known source of its numbers.
    pub(super) known: bool,
}

/// The arrays of a function, in order of first appearance.
#[derive(Clone, Default, Debug)]
pub(super) struct Storage {
    pub(super) arrays: Vec<StoredArray>,
    /// Total number of elements.
    pub(super) len: usize,
    names: Vec<RobotranName>,
    numbers: HashMap<RobotranName, u32, FxBuildHasher>,
    /// Other names of an array (`Qq = phi`).
    aliases: HashMap<RobotranName, RobotranName, FxBuildHasher>,
    /// Matlab's `frc = s.frc`: the statement, the copy and the original.
    copies: Vec<(usize, RobotranName, RobotranName)>,
    /// Arrays that a statement of the prologue names.
    bound: HashMap<RobotranName, RobotranName, FxBuildHasher>,
    /// Arrays of the structure used by its name (`s->q`), or set by a call.
    members: HashSet<Symbol, FxBuildHasher>,
    /// Pointers that are declared without an array, with the statement.
    pointers: HashMap<RobotranName, usize, FxBuildHasher>,
    given: HashSet<RobotranName, FxBuildHasher>,
    /// The extents of the input arrays, of which several may be one.
    pub(super) input_shapes: HashMap<Symbol, Shape, FxBuildHasher>,
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

    pub(super) fn find(&self, name: RobotranName) -> Option<u32> {
        self.numbers.get(&self.canonical(name)).copied()
    }

    /// The number of the array of an element.
    pub(super) fn array_of(&self, slot: u32) -> usize {
        debug_assert!((slot as usize) < self.len, "an element lies in an array");
        self.arrays.partition_point(|array| array.offset <= slot) - 1
    }

    /// The array and the indices of an element.
    pub(super) fn element(&self, slot: u32) -> (&StoredArray, [u32; 2], usize) {
        let array = &self.arrays[self.array_of(slot)];
        let (indices, rank) = array.shape.indices(slot - array.offset);
        (array, indices, rank)
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

/// Names that are arrays even where no element of them is used.
fn is_array_name(name: &str) -> bool {
    known_extent(name, 0).is_some()
        || matches!(name, "h" | "Jdqd" | "lrod" | "Z" | "Zd" | "Flink" | "Flnk")
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
    /// The storage, of use only without errors, which are left in the builder.
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

    /// True for an array the caller sees: a parameter or a result.
    fn is_visible(&self, name: RobotranName) -> bool {
        let Some(head) = self.head else {
            return true;
        };
        let text = self.symbols.text(name.symbol());
        let structure = text.split('.').next();
        let structure = structure.expect("a text has a first part");
        let mut visible = head.parameters.iter().chain(&head.outputs);
        visible.any(|parameter| {
            *parameter == name || self.symbols.text(parameter.symbol()) == structure
        })
    }
}
