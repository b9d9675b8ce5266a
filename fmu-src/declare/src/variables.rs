//! The macro that generates a struct and its table.

/// Declares a struct of variables: each field is one row of its [`Group::TABLE`](crate::Group::TABLE).
///
/// ```
/// use declare::{variables, Group, Unit, Variable};
/// variables! {
///     /// A resistor.
///     pub struct Resistor {
///         /// Resistance
///         R: f64 = Variable::tunable(1, 10.0, Unit::Ohm, 0.0, 1e6),
///     }
/// }
/// assert_eq!(Resistor::default().R, 10.0);
/// assert_eq!(Resistor::TABLE[0].name, "R");
/// assert_eq!(Resistor::TABLE[0].doc.trim(), "Resistance");
/// ```
///
/// The rows by name ([`Named`](crate::Named)):
///
/// ```
/// # use declare::{variables, Named, Unit, Variable};
/// # variables! { /// A resistor.
/// # pub struct Resistor { /// Resistance
/// # R: f64 = Variable::tunable(1, 10.0, Unit::Ohm, 0.0, 1e6), } }
/// type Row = <Resistor as Named>::Row;
/// assert!(matches!(Resistor::row(0), Some(Row::R)) && Resistor::row(1).is_none());
/// ```
#[macro_export]
macro_rules! variables {
    ($(#[doc = $sdoc:literal])* pub struct $name:ident {
        $($(#[doc = $doc:expr])* $field:ident : $type:ty = $row:expr),* $(,)?
    }) => {
        $(#[doc = $sdoc])*
        #[allow(non_snake_case)] // symbols are written as in the equations
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name { $($(#[doc = $doc])* pub $field: $type),* }

        const _: () = {
            #[allow(non_camel_case_types)]
            #[derive(Clone, Copy, Debug, PartialEq, Eq)]
            pub enum Row { $($field),* }

            impl $crate::Named for $name {
                type Row = Row;

                #[inline(always)]
                fn row(index: usize) -> Option<Row> {
                    $(if index == Row::$field as usize { return Some(Row::$field); })*
                    None
                }
            }

            impl $crate::Group for $name {
                const TABLE: &'static [$crate::Variable] = &[$(
                    $crate::Variable::named($row, stringify!($field), concat!($($doc),*),
                        <$type as $crate::Scalar>::KIND)
                ),*];

                #[inline]
                fn get(&self, index: usize) -> f64 {
                    $(if index == Row::$field as usize { return $crate::Scalar::to_f64(self.$field); })*
                    panic!("no row {index}")
                }

                #[inline]
                fn set(&mut self, index: usize, value: f64) -> bool {
                    $(if index == Row::$field as usize {
                        return match <$type as $crate::Scalar>::from_f64(value) {
                            Some(value) => { self.$field = value; true }
                            None => false,
                        };
                    })*
                    panic!("no row {index}")
                }

                #[inline]
                fn zero() -> Self {
                    Self { $($field: <$type as $crate::Scalar>::from_f64(0.0).expect("a table of numbers")),* }
                }
            }

            impl Default for $name {
                /// The start values; zero for computed variables.
                fn default() -> Self {
                    let start = |row: Row| {
                        let start = <$name as $crate::Group>::TABLE[row as usize].start;
                        if start.is_nan() { 0.0 } else { start }
                    };
                    Self { $($field: <$type as $crate::Scalar>::from_f64(start(Row::$field))
                        .expect("a start value is a value of its type")),* }
                }
            }
        };
    };
}
