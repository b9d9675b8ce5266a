//! One macro: a table of C functions, filled from a loaded binary.

/// Declares a struct of C function pointers and its `load(&Library)`.
///
/// `required` functions are fields of the function type; `optional` ones are `Option`s, for those that an
/// FMU needs only with a capability flag. `load` fails with the name of the first required symbol missing.
macro_rules! functions {
    ($(#[$doc:meta])* $table:ident {
        required { $($field:ident = $symbol:ident: fn($($argument:ty),* $(,)?) $(-> $result:ty)?;)* }
        optional { $($maybe:ident = $maybe_symbol:ident: fn($($maybe_argument:ty),* $(,)?) $(-> $maybe_result:ty)?;)* }
    }) => {
        $(#[$doc])*
        pub(crate) struct $table {
            $(pub $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            $(pub $maybe: Option<unsafe extern "C" fn($($maybe_argument),*) $(-> $maybe_result)?>,)*
        }

        impl $table {
            /// Resolves the symbols; the error is the name of a required one that is missing.
            pub(crate) fn load(library: &libloading::Library) -> Result<Self, &'static str> {
                Ok(Self {
                    // SAFETY: the standard fixes the type behind each name; `Instance` keeps the library loaded
                    // for as long as this table lives.
                    $($field: *unsafe { library.get(stringify!($symbol)) }.map_err(|_| stringify!($symbol))?,)*
                    // SAFETY: as above.
                    $($maybe: unsafe { library.get(stringify!($maybe_symbol)) }.ok().map(|symbol| *symbol),)*
                })
            }
        }
    };
}
pub(crate) use functions;
