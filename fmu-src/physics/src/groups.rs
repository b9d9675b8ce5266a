//! Structs of groups of variables: declared once, accessed by group and row.

use crate::model::GroupAt;

/// A struct of groups of variables, implemented by [`groups!`](crate::groups).
pub trait Grouped {
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

/// Lists the groups of a struct and dispatches to them: one field per line, each a [`declare::Group`].
///
/// ```text
/// groups! { Motor { "" @ 0 => inputs: Inputs, "motor." @ 100 => winding: Winding } then effects: Effects }
/// ```
/// `then` names a field that has its own groups, which follow.
#[macro_export]
macro_rules! groups {
    ($owner:ident { $($prefix:literal @ $base:literal => $field:ident : $type:ty),* $(,)? } $(then $tail:ident : $tail_type:ty)?) => {
        impl $crate::groups::Grouped for $owner {
            fn groups() -> Vec<$crate::model::GroupAt> {
                #[allow(unused_mut)]
                let mut all = vec![$($crate::model::GroupAt {
                    prefix: $prefix, base: $base, table: <$type as declare::Group>::TABLE,
                }),*];
                $(all.extend(<$tail_type as $crate::groups::Grouped>::groups());)?
                all
            }

            #[inline]
            #[allow(unused_assignments)]
            fn value(&self, group: usize, row: usize) -> f64 {
                let mut k = 0;
                $(if group == k { return declare::Group::get(&self.$field, row); } k += 1;)*
                $(if group >= k { return $crate::groups::Grouped::value(&self.$tail, group - k, row); })?
                panic!("no group {group}")
            }

            #[inline]
            #[allow(unused_assignments)]
            fn set_value(&mut self, group: usize, row: usize, value: f64) -> bool {
                let mut k = 0;
                $(if group == k { return declare::Group::set(&mut self.$field, row, value); } k += 1;)*
                $(if group >= k { return $crate::groups::Grouped::set_value(&mut self.$tail, group - k, row, value); })?
                panic!("no group {group}")
            }
        }
    };
}
