//! Enumerations whose variants have names.

/// Declares an enumeration and gives every variant the name that users read and
/// write: `ALL`, `name` and `from_name`.
///
/// ```
/// robovec_num::named! {
///     /// A colour.
///     #[derive(Clone, Copy, PartialEq, Debug)]
///     pub enum Colour {
///         /// Of blood.
///         Red = "red",
///         /// Of grass.
///         Green = "green",
///     }
/// }
/// assert_eq!(Colour::ALL.map(Colour::name), ["red", "green"]);
/// assert_eq!(Colour::from_name("green"), Some(Colour::Green));
/// ```
#[macro_export]
macro_rules! named {
    ($(#[$meta:meta])* $visibility:vis enum $name:ident {
        $($(#[$variant_meta:meta])* $variant:ident = $text:literal),+ $(,)?
    }) => {
        $(#[$meta])*
        $visibility enum $name { $($(#[$variant_meta])* $variant),+ }

        #[allow(dead_code)]
        impl $name {
            /// All variants, in order of declaration.
            $visibility const ALL: [$name; [$($text),+].len()] = [$($name::$variant),+];

            /// The name in texts.
            #[inline]
            $visibility const fn name(self) -> &'static str {
                match self { $($name::$variant => $text),+ }
            }

            /// The variant with this name.
            $visibility fn from_name(name: &str) -> Option<$name> {
                $name::ALL.into_iter().find(|one| one.name() == name)
            }
        }
    };
}
