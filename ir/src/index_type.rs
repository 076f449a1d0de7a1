//! Indices whose absence costs no memory.

/// Declares types of indices that count from 0. `u32::MAX` is not an index:
/// its place is taken by `None`, so that an `Option` of an index takes four
/// bytes, as the index itself does, and tables of them stay small.
#[macro_export]
macro_rules! index_types {
    ($($(#[$documentation:meta])* $visibility:vis struct $name:ident;)+) => {$(
        $(#[$documentation])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        $visibility struct $name(std::num::NonZero<u32>);

        impl $name {
            /// The index of this number.
            ///
            /// # Panics
            ///
            /// Panics when the number is `u32::MAX`.
            #[inline]
            $visibility fn new(number: u32) -> $name {
                // One more than the number, which keeps the order.
                let shifted = std::num::NonZero::new(number.wrapping_add(1));
                $name(shifted.expect("an index is below the largest number"))
            }

            /// Its number, from 0.
            #[inline]
            $visibility fn number(self) -> u32 {
                self.0.get() - 1
            }

            /// Its number as the index into a table.
            #[inline]
            #[allow(dead_code, reason = "not everything that is counted has a table")]
            $visibility fn index(self) -> usize {
                self.number() as usize
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.number().fmt(formatter)
            }
        }

        impl std::fmt::Debug for $name {
            fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.number().fmt(formatter)
            }
        }
    )+};
}

#[cfg(test)]
mod tests {
    use crate::placement::{Address, BufferWord, Slot};

    #[test]
    fn absence_costs_no_memory() {
        assert_eq!(size_of::<Option<Slot>>(), 8);
        assert_eq!(size_of::<Option<Address>>(), 4);
    }

    #[test]
    fn indices_are_ordered_and_written_as_their_numbers() {
        let last = BufferWord::new(u32::MAX - 1);
        assert!(BufferWord::new(0) < last && None < Some(BufferWord::new(0)));
        assert_eq!(last.number(), u32::MAX - 1);
        assert_eq!(format!("{last} {last:?}"), "4294967294 4294967294");
    }
}
