//! Aliases and copies of arrays.

use super::{Storage, StorageBuilder, is_array_name};
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
            let previous = storage.bound.insert(target, original);
            if storage.joined {
                let changed = previous.is_some_and(|previous| previous != original);
                let own = same && !storage.pointers.contains_key(&target);
                if changed || target.is_of_data() || (!own && used(target)) {
                    self.late_meaning(target, statement.span);
                }
            } else {
                // An element of the copy was used, or one of the original set,
                // before this statement.
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
