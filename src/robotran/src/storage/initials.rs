//! Values of arrays before the function writes them.

use super::{Initial, Storage, StorageBuilder, is_array_name};
use crate::Language;
use crate::explain::refusal;
use crate::syntax::StatementKind;
use crate::token::RobotranName;

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
