//! Groups of options that stand in one flat table of a file.
//!
//! The table of a machine has thirty options. In the code they are fields of groups (its space, its search, ...), in the
//! file they have no such level. `serde(flatten)` cannot read that: it knows neither unknown options nor positions. Here
//! a table asks each of its groups whether it has an option, and refuses the option that none of them has.

use std::{fmt, marker::PhantomData};

use serde::{
    Deserializer,
    de::{DeserializeSeed, Error, MapAccess, Visitor},
};

/// Options that can be read one by one. All of them have a default.
pub(crate) trait OptionGroup: Default {
    /// The name for error messages.
    const NAME: &'static str;

    /// The names of its options in files.
    fn option_names() -> Vec<&'static str>;

    /// Reads the value of an option from a table. Returns whether the group has the option.
    fn read_option<'de, A: MapAccess<'de>>(&mut self, name: &str, table: &mut A) -> Result<bool, A::Error>;
}

/// Defines a group: its options with types and defaults.
macro_rules! option_group {
    ($(#[$group_attr:meta])* $group:ident { $($(#[$attr:meta])* $option:ident: $kind:ty = $default:expr,)* }) => {
        $(#[$group_attr])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize)]
        pub(crate) struct $group {
            $($(#[$attr])* pub $option: $kind,)*
        }

        impl Default for $group {
            fn default() -> Self {
                Self { $($option: $default,)* }
            }
        }

        $crate::reading::option_group::read_options!($group: $($option)*);
    };
}

/// Implements [`OptionGroup`] for a type with these options, and groups of options where it has some.
macro_rules! read_options {
    ($group:ident: $($option:ident)* $(, groups $($inner:ident: $inner_kind:ty)*)?) => {
        impl $crate::reading::option_group::OptionGroup for $group {
            const NAME: &'static str = stringify!($group);

            fn option_names() -> Vec<&'static str> {
                let own = vec![$(stringify!($option)),*];
                [$($(<$inner_kind>::option_names(),)*)? own].concat()
            }

            fn read_option<'de, A: serde::de::MapAccess<'de>>(
                &mut self,
                name: &str,
                table: &mut A,
            ) -> Result<bool, A::Error> {
                match name {
                    $(stringify!($option) => self.$option = table.next_value()?,)*
                    _ => return Ok(false $($(|| self.$inner.read_option(name, table)?)*)?),
                }
                Ok(true)
            }
        }
    };
}

pub(crate) use {option_group, read_options};

/// Reads a table of options. Options that are not in the table keep their defaults.
pub(crate) fn read_option_table<'de, T: OptionGroup, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_map(TableVisitor(PhantomData))
}

struct TableVisitor<T>(PhantomData<T>);

impl<'de, T: OptionGroup> Visitor<'de> for TableVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "struct {}", T::NAME)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<T, A::Error> {
        let (mut options, names) = (T::default(), T::option_names());
        while let Some(name) = table.next_key_seed(KnownName(&names))? {
            options.read_option(name, &mut table)?;
        }
        Ok(options)
    }
}

/// Reads the name of an option. An unknown one is refused here, so that the error has the position of the name.
#[derive(Clone, Copy)]
struct KnownName<'n>(&'n [&'static str]);

impl<'de> DeserializeSeed<'de> for KnownName<'_> {
    type Value = &'static str;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl Visitor<'_> for KnownName<'_> {
    type Value = &'static str;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of an option")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Self::Value, E> {
        let known = || self.0.iter().map(|known| format!("`{known}`")).collect::<Vec<_>>().join(", ");
        let unknown = || E::custom(format_args!("unknown field `{name}`, expected one of {}", known()));
        self.0.iter().find(|known| **known == name).copied().ok_or_else(unknown)
    }
}
