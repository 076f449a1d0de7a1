//! Number of indices of each array, and their largest values.

use super::{ArrayUse, POINTED_AT, Storage, StorageBuilder};
use crate::Language;
use crate::explain::refusal;
use crate::syntax::{LeafKind, StatementKind, SyntaxLeaf, SyntaxStatement};
use crate::token::RobotranName;
use hashbrown::{HashMap, HashSet};
use robovec_ir::Symbol;
use rustc_hash::FxBuildHasher;

impl StorageBuilder<'_> {
    pub(super) fn collect_uses(&mut self, storage: &mut Storage) -> Vec<ArrayUse> {
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
                self.wrong_rank(Some(index), element.name);
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
}
