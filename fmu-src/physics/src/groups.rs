//! Structs of groups of variables: declared once, accessed by group and row.

use crate::model::GroupAt;

/// A struct of groups of variables, implemented by [`groups!`](crate::groups!).
pub trait Grouped {
    /// Number of groups.
    const COUNT: usize;
    /// The groups, in the order of the tables.
    fn groups() -> Vec<GroupAt>;
    /// The value of a row.
    ///
    /// # Panics
    /// If there is no such group or row.
    fn value(&self, group: usize, row: usize) -> f64;
    /// Sets a row; false if the value is invalid for its type.
    ///
    /// # Panics
    /// If there is no such group or row.
    fn set_value(&mut self, group: usize, row: usize, value: f64) -> bool;
}

/// Declares a struct of groups and dispatches to them: each field is a [`declare::Group`] with the prefix of its names and the base of its
/// value references, or a struct of groups ([`Grouped`]).
///
/// ```text
/// groups! { pub struct Motor { winding: Winding = "motor." @ 100, effects: Effects } and { cache: Cache } }
/// ```
/// `and` names fields that are no groups.
#[macro_export]
macro_rules! groups {
    ($(#[$meta:meta])* pub struct $owner:ident {
        $($(#[$doc:meta])* $field:ident : $type:ty $(= $prefix:literal @ $base:literal)?),* $(,)?
    } $(and { $($(#[$and_doc:meta])* $and:ident : $and_type:ty),* })?) => {
        $(#[$meta])*
        pub struct $owner {
            $($(#[$doc])* pub $field: $type,)*
            $($($(#[$and_doc])* $and: $and_type),*)?
        }

        impl $crate::groups::Grouped for $owner {
            const COUNT: usize = 0 $(+ $crate::group!(count $type $(, $prefix @ $base)?))*;

            fn groups() -> Vec<$crate::model::GroupAt> {
                let mut all = Vec::new();
                $(all.extend($crate::group!(tables $type $(, $prefix @ $base)?));)*
                all
            }

            #[inline]
            fn value(&self, group: usize, row: usize) -> f64 {
                let mut k = group;
                $($crate::group!(dispatch k $type, &self.$field, get value (row) $(, $prefix @ $base)?);)*
                panic!("no group {group}, {k} too many")
            }

            #[inline]
            fn set_value(&mut self, group: usize, row: usize, value: f64) -> bool {
                let mut k = group;
                $($crate::group!(dispatch k $type, &mut self.$field, set set_value (row, value) $(, $prefix @ $base)?);)*
                panic!("no group {group}, {k} too many")
            }
        }
    };
}

/// One field of [`groups!`](crate::groups!): a group with prefix and base, or a struct of groups.
#[doc(hidden)]
#[macro_export]
macro_rules! group {
    (count $type:ty) => { <$type as $crate::groups::Grouped>::COUNT };
    (count $type:ty, $prefix:literal @ $base:literal) => { 1 };
    (tables $type:ty) => { <$type as $crate::groups::Grouped>::groups() };
    (tables $type:ty, $prefix:literal @ $base:literal) => {
        [$crate::model::GroupAt { prefix: $prefix, base: $base, table: <$type as declare::Group>::TABLE }]
    };
    (dispatch $k:ident $type:ty, $field:expr, $of_group:ident $of_groups:ident ($($argument:ident),*)) => {
        if $k < <$type as $crate::groups::Grouped>::COUNT {
            return $crate::groups::Grouped::$of_groups($field, $k, $($argument),*);
        }
        $k -= <$type as $crate::groups::Grouped>::COUNT;
    };
    (dispatch $k:ident $type:ty, $field:expr, $of_group:ident $of_groups:ident ($($argument:ident),*), $p:literal @ $b:literal) => {
        if $k == 0 {
            return declare::Group::$of_group($field, $($argument),*);
        }
        $k -= 1;
    };
}
