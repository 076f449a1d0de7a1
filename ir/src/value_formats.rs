//! Number formats of single values, for programs of mixed precision.
//!
//! Kept beside the nodes, two bytes per value and a table of the formats that
//! occur: most programs have none, and those that do have two or three.

use crate::entity::Value;
use robovec_num::format::Format;

/// The formats of a function's values. A value without one is computed in the
/// format of the run: the machine's, or the one that is requested.
#[derive(Clone, Default, Debug)]
pub struct ValueFormats {
    table: Vec<Format>,
    /// One for every node: a place in the table, counted from 1, or 0.
    values: Vec<u16>,
}

impl ValueFormats {
    /// No format yet for any of this number of values.
    pub fn new(values: usize) -> ValueFormats {
        ValueFormats {
            table: Vec::new(),
            values: vec![0; values],
        }
    }

    /// The number of values there is room for: the nodes of the function.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// True when there is no room for any value.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Makes room for this number of values, or takes it away; new ones have no
    /// format.
    pub fn resize(&mut self, values: usize) {
        self.values.resize(values, 0);
    }

    /// The format of a value that has one.
    #[inline]
    pub fn get(&self, value: Value) -> Option<Format> {
        let index = self.index(value).checked_sub(1)?;
        Some(self.table[index])
    }

    /// Sets or removes the format of a value.
    ///
    /// # Panics
    ///
    /// Panics when there is no room for the value.
    pub fn set(&mut self, value: Value, format: Option<Format>) {
        self.values[value.index()] = format.map_or(0, |format| self.number(format));
    }

    /// The formats that values may refer to, those of no value included.
    pub fn table(&self) -> &[Format] {
        &self.table
    }

    /// The place of a value's format in the table, counted from 1; 0 without
    /// one.
    #[inline]
    pub fn index(&self, value: Value) -> usize {
        usize::from(self.values[value.index()])
    }

    /// The formats of all values, in program order.
    pub fn iter(&self) -> impl Iterator<Item = Option<Format>> + '_ {
        (0..self.values.len() as u32).map(|index| self.get(Value(index)))
    }

    /// The number of a format, counted from 1. There are fewer than 2,000
    /// formats, so the numbers suffice.
    fn number(&mut self, format: Format) -> u16 {
        let known = self.table.iter().position(|known| *known == format);
        let index = known.unwrap_or_else(|| {
            self.table.push(format);
            self.table.len() - 1
        });
        u16::try_from(index + 1).expect("there are fewer formats than numbers for them")
    }
}

/// True when all values have the same formats; no table is as good as one
/// without entries.
pub(crate) fn same_formats(left: Option<&ValueFormats>, right: Option<&ValueFormats>) -> bool {
    let plain = |formats: Option<&ValueFormats>| {
        formats.is_none_or(|formats| formats.values.iter().all(|&index| index == 0))
    };
    match (left, right) {
        (Some(left), Some(right)) => left.iter().eq(right.iter()),
        _ => plain(left) && plain(right),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_compared_by_what_they_say() {
        let short: Format = "float(8,15)".parse().expect("a format");
        let mut left = ValueFormats::new(2);
        assert!(same_formats(Some(&left), None));
        left.set(Value(0), Some(Format::BINARY64));
        left.set(Value(0), None);
        left.set(Value(1), Some(short));
        assert_eq!(left.get(Value(1)), Some(short));
        let mut right = ValueFormats::new(2);
        assert!(!same_formats(Some(&left), Some(&right)) && !same_formats(None, Some(&left)));
        right.set(Value(1), Some(short));
        assert!(same_formats(Some(&left), Some(&right)));
        assert_ne!(left.index(Value(1)), right.index(Value(1)));
    }
}
