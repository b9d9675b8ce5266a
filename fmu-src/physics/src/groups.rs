//! Structs made of groups of variables: listed once, found by group and row.

use crate::model::GroupAt;

/// A struct of groups of variables, as [`groups!`](crate::groups) makes it.
pub trait Grouped {
    /// The groups, in the order of the tables.
    fn groups() -> Vec<GroupAt>;
    /// The value of a row.
    fn value(&self, group: usize, row: usize) -> f64;
    /// Sets a row; false where its type has no such value.
    fn set_value(&mut self, group: usize, row: usize, value: f64) -> bool;
}

/// Appends the values of all rows of all groups.
pub fn save(owner: &impl Grouped, groups: &[GroupAt], out: &mut Vec<f64>) {
    for (g, group) in groups.iter().enumerate() {
        out.extend((0..group.table.len()).map(|row| owner.value(g, row)));
    }
}

/// Takes what [`save`] has appended; `None` where the numbers run out or a type has no such value.
pub fn restore(
    owner: &mut impl Grouped,
    groups: &[GroupAt],
    next: &mut impl FnMut() -> Option<f64>,
) -> Option<()> {
    for (g, group) in groups.iter().enumerate() {
        (0..group.table.len()).try_for_each(|row| owner.set_value(g, row, next()?).then_some(()))?;
    }
    Some(())
}

/// Lists the groups of a struct and dispatches to them: a field a line, each a [`declare::Group`].
///
/// ```text
/// groups! { Motor { "" @ 0 => inputs: Inputs, "motor." @ 100 => winding: Winding } then effects: Effects }
/// ```
/// `then` names a field that has groups of its own, which follow.
#[macro_export]
macro_rules! groups {
    ($owner:ident { $($prefix:literal @ $base:literal => $field:ident : $type:ty),* $(,)? } $(then $tail:ident : $tail_type:ty)?) => {
        impl $owner {
            /// The groups of variables, in the order of the tables.
            pub fn groups() -> Vec<$crate::model::GroupAt> {
                #[allow(unused_mut)]
                let mut all = vec![$($crate::model::GroupAt {
                    prefix: $prefix, base: $base, table: <$type as declare::Group>::TABLE,
                }),*];
                $(all.extend(<$tail_type>::groups());)?
                all
            }

            /// The value of a row.
            ///
            /// # Panics
            /// Where there is no such group or row.
            #[inline]
            #[allow(unused_assignments)]
            pub fn value(&self, group: usize, row: usize) -> f64 {
                let mut k = 0;
                $(if group == k { return declare::Group::get(&self.$field, row); } k += 1;)*
                $(if group >= k { return self.$tail.value(group - k, row); })?
                panic!("no group {group}")
            }

            /// Sets a row; false where its type has no such value.
            ///
            /// # Panics
            /// Where there is no such group or row.
            #[inline]
            #[allow(unused_assignments)]
            pub fn set_value(&mut self, group: usize, row: usize, value: f64) -> bool {
                let mut k = 0;
                $(if group == k { return declare::Group::set(&mut self.$field, row, value); } k += 1;)*
                $(if group >= k { return self.$tail.set_value(group - k, row, value); })?
                panic!("no group {group}")
            }
        }

        impl $crate::groups::Grouped for $owner {
            fn groups() -> Vec<$crate::model::GroupAt> {
                <$owner>::groups()
            }

            #[inline]
            fn value(&self, group: usize, row: usize) -> f64 {
                <$owner>::value(self, group, row)
            }

            #[inline]
            fn set_value(&mut self, group: usize, row: usize, value: f64) -> bool {
                <$owner>::set_value(self, group, row, value)
            }
        }
    };
}
