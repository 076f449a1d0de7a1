//! Aliases, copies and initial values of arrays.

use super::{Initial, Storage, StorageBuilder, is_array_name};
use crate::Language;
use crate::explain::refusal;
use crate::syntax::{LeafKind, StatementKind};
use crate::token::RobotranName;
use hashbrown::{HashMap, HashSet};
use robovec_ir::Symbol;
use rustc_hash::FxBuildHasher;

impl StorageBuilder<'_> {
    /// Whole-array assignments of the prologue: `q = s->q;`, `Qq = phi`.
    pub(super) fn find_aliases(&mut self, storage: &mut Storage) {
        let mut first_uses: HashMap<RobotranName, u32, FxBuildHasher> = HashMap::default();
        let mut arrays: HashSet<Symbol, FxBuildHasher> = HashSet::default();
        for index in self.elements.clone().rev() {
            let name = self.syntax.elements[index].name;
            first_uses.insert(name, index as u32);
            arrays.insert(name.symbol());
        }
        storage.pointers = self
            .statements
            .clone()
            .filter_map(|index| match self.syntax.statements[index].kind {
                StatementKind::Pointer(name) => Some((name, index)),
                _ => None,
            })
            .collect();
        let first_writings = if storage.joined {
            HashMap::default()
        } else {
            self.first_writings()
        };
        for (index, target, root) in self.whole_arrays(&arrays) {
            self.syntax.statements[index].kind = StatementKind::Prologue;
            let statement = self.syntax.statements[index];
            let first_use = first_uses.get(&target);
            let is_used = first_use.is_some_and(|&first| first < statement.elements);
            let is_late = if storage.joined {
                self.bind_alias(storage, (target, root), is_used)
            } else {
                let original = storage.canonical(root);
                storage.bound.insert(target, original);
                storage.copies.push((index, target, root));
                // An element of the copy was used, or one of the original set,
                // before this statement.
                let written = first_writings.get(&root);
                is_used || written.is_some_and(|&first| first < index)
            };
            if is_late {
                self.late_meaning(target, statement.span);
            }
        }
    }

    /// Assignments of arrays as a whole: place, target and root.
    fn whole_arrays(
        &self,
        arrays: &HashSet<Symbol, FxBuildHasher>,
    ) -> Vec<(usize, RobotranName, RobotranName)> {
        let is_array = |name: RobotranName| {
            let symbol = name.symbol();
            arrays.contains(&symbol) || is_array_name(self.symbols.text(symbol))
        };
        let whole_array = |index: usize| {
            let StatementKind::Equation { target, root, .. } = self.syntax.statements[index].kind
            else {
                return None;
            };
            let (LeafKind::Scalar(target), LeafKind::Scalar(root)) = (target.kind(), root.kind())
            else {
                return None;
            };
            let is_whole = is_array(target) || (root.is_of_data() && is_array(root));
            is_whole.then_some((index, target, root))
        };
        self.statements.clone().filter_map(whole_array).collect()
    }

    /// Makes the target another name of the array; true if it meant others.
    fn bind_alias(
        &self,
        storage: &mut Storage,
        (target, root): (RobotranName, RobotranName),
        is_used: bool,
    ) -> bool {
        let original = storage.canonical(root);
        let previous = storage.bound.insert(target, original);
        let is_same = target.symbol() == root.symbol();
        let head = self.head.as_ref();
        let is_parameter = head.is_some_and(|head| head.parameters.contains(&root));
        if root.is_of_data() || is_parameter || storage.given.contains(&original) {
            storage.given.insert(original);
            storage.given.insert(target);
        }
        if is_parameter && !is_same && !is_array_name(self.symbols.text(root.symbol())) {
            storage.aliases.insert(root, target);
        } else if !is_same {
            storage.aliases.insert(target, original);
        }
        let is_rebound = previous.is_some_and(|previous| previous != original);
        let is_own = is_same && !storage.pointers.contains_key(&target);
        is_rebound || target.is_of_data() || (!is_own && is_used)
    }

    /// The first statement that sets an element, for every array.
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
}

impl StorageBuilder<'_> {
    pub(super) fn find_initials(&mut self, storage: &mut Storage) {
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
                array.initial = if extent.zeroed {
                    Initial::Zero
                } else {
                    Initial::Nothing
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

    /// True for an array whose initial numbers come from the caller: one of
    /// Robotran's, a parameter, one that the prologue or a call sets.
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
}
