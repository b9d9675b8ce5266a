//! Enumerations, for example drive mode and cooling mode.

/// An item of an [`Enumeration`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// Name as in presets and on the command line.
    pub name: &'static str,
    /// Value at the FMI interface, from 1.
    pub value: i32,
    /// Meaning, one sentence.
    pub doc: &'static str,
}

/// The declaration of an enumeration type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// Name of the type.
    pub name: &'static str,
    /// Meaning of the enumeration.
    pub doc: &'static str,
    /// The items, values ascending from 1.
    pub items: &'static [Item],
}

/// Declares a Rust enum together with its [`Enumeration`] table.
#[macro_export]
macro_rules! enumeration {
    ($(#[doc = $doc:literal])* pub enum $type:ident { $($(#[doc = $idoc:literal])* $item:ident = $value:literal, $name:literal;)* }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $type { $($(#[doc = $idoc])* $item = $value),* }

        impl $crate::Scalar for $type {
            const KIND: $crate::Kind = $crate::Kind::Enumeration(&$crate::Enumeration {
                name: stringify!($type),
                doc: concat!($($doc),*),
                items: &[$($crate::Item { name: $name, value: $value, doc: concat!($($idoc),*) }),*],
            });
            fn to_f64(self) -> f64 { self as i32 as f64 }
            fn from_f64(value: f64) -> Option<Self> {
                $(if value == $value as f64 { return Some($type::$item); })*
                None
            }
        }
    };
}
