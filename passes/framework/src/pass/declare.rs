//! The declaration of a pass, from which its structure, its options and its
//! entry in the registry are made.

/// Declares a pass: a structure whose fields are its options, and its entry for
/// the registry. The doc comment is the pass's page in the manual; its first
/// line is the one-line description. A field that is a number gives its range
/// after `=>`: `pub rounds: u32 = 6 => NumberLimit::whole(0, 64, "every round
/// takes as long as the first")`. Levels, class and properties are the fields
/// of [`PassInfo`](crate::pass::PassInfo); lists of properties may be omitted.
#[macro_export]
macro_rules! declare_pass {
    (
        $(#[doc = $documentation:expr])*
        pub struct $pass:ident($name:literal) {
            $($(#[doc = $field_documentation:expr])* pub $field:ident: $type:ty = $default:expr $(=> $limit:expr)?),* $(,)?
        }
        takes: [$($takes:ident),+],
        gives: $gives:expr,
        class: $class:ident,
        $(requires: [$($requires:ident),+],)?
        $(sets: [$($sets:ident),+],)?
        $(destroys: [$($destroys:ident),+],)?
    ) => {
        $(#[doc = $documentation])*
        #[derive(Clone, PartialEq, Debug)]
        pub struct $pass {
            $($(#[doc = $field_documentation])* pub $field: $type),*
        }

        impl Default for $pass {
            fn default() -> $pass {
                $pass { $($field: $default),* }
            }
        }

        impl $pass {
            /// The pass's entry in the registry.
            pub const INFO: $crate::pass::PassInfo = $crate::pass::PassInfo {
                name: $name,
                documentation: concat!($($documentation, "\n"),*),
                options: &[$($crate::options::OptionInfo {
                    name: $crate::options::plain_name(stringify!($field)),
                    documentation: concat!($($field_documentation, "\n"),*),
                    type_name: <$type as $crate::options::OptionValue>::type_name,
                    default: || $crate::options::OptionValue::print(&$pass::default().$field),
                    limit: {
                        #[allow(unused_mut, unused_assignments)]
                        let mut limit: Option<robovec_num::limits::NumberLimit> = None;
                        $(limit = Some($limit);)?
                        assert!(
                            limit.is_some() || !<$type as $crate::options::OptionValue>::IS_NUMBER,
                            "an option that is a number needs a limit"
                        );
                        limit
                    },
                }),*],
                takes: &[$(robovec_ir::Level::$takes),+],
                gives: $gives,
                class: $crate::NumericClass::$class,
                requires: &[$($($crate::pass::Property::$requires),+)?],
                sets: &[$($($crate::pass::Property::$sets),+)?],
                destroys: &[$($($crate::pass::Property::$destroys),+)?],
                build: $pass::build,
            };

            #[allow(unused_mut, unused_variables, clippy::never_loop)]
            fn build(
                options: &[(String, String)],
            ) -> Result<Box<dyn $crate::pass::Pass>, $crate::options::OptionError> {
                let mut pass = $pass::default();
                for (name, text) in options {
                    let limit = || {
                        let known = $pass::INFO.options.iter();
                        known.filter(|option| option.name == name).find_map(|option| option.limit)
                    };
                    match name.as_str() {
                        $(known if known == $crate::options::plain_name(stringify!($field)) => {
                            pass.$field = $crate::options::read(text, limit()).map_err(
                                |reason| $crate::options::OptionError::Value {
                                    name: name.clone(),
                                    reason,
                                },
                            )?;
                        })*
                        _ => return Err($crate::options::OptionError::Unknown(name.clone())),
                    }
                }
                Ok(Box::new(pass))
            }
        }
    };
}
