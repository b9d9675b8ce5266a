//! Serialization of a model: each type lists its fields once; saving and restoring follow from the list.

use nalgebra::SVector;

/// A value that a saved state contains as numbers.
pub trait Saved {
    /// Appends the value.
    fn save(&self, out: &mut Vec<f64>);
    /// Restores the values of [`save`](Saved::save); `None` if there are too few numbers or a value is invalid.
    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()>;
}

impl Saved for f64 {
    fn save(&self, out: &mut Vec<f64>) {
        out.push(*self);
    }

    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        *self = next()?;
        Some(())
    }
}

impl Saved for bool {
    fn save(&self, out: &mut Vec<f64>) {
        out.push(f64::from(u8::from(*self)));
    }

    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        *self = next()? != 0.0;
        Some(())
    }
}

impl<T: Saved, const N: usize> Saved for [T; N] {
    fn save(&self, out: &mut Vec<f64>) {
        self.iter().for_each(|one| one.save(out));
    }

    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        self.iter_mut().try_for_each(|one| one.load(next))
    }
}

impl<const N: usize> Saved for SVector<f64, N> {
    fn save(&self, out: &mut Vec<f64>) {
        out.extend(self.iter());
    }

    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        self.iter_mut().try_for_each(|one| one.load(next))
    }
}

impl<T: Saved + Default> Saved for Option<T> {
    fn save(&self, out: &mut Vec<f64>) {
        self.is_some().save(out);
        self.iter().for_each(|value| value.save(out));
    }

    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        *self = if next()? == 0.0 { None } else { Some(T::default()) };
        self.iter_mut().try_for_each(|value| value.load(next))
    }
}

/// Implements [`Saved`] for the fields in a saved state; the others follow from them.
#[macro_export]
macro_rules! saved {
    ($name:ident $(<$(const $n:ident : $t:ty),+>)? { $($field:ident),* $(,)? }) => {
        impl $(<$(const $n: $t),+>)? $crate::runtime::Saved for $name $(<$($n),+>)? {
            fn save(&self, out: &mut Vec<f64>) {
                let _ = &out;
                $($crate::runtime::Saved::save(&self.$field, out);)*
            }

            fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
                let _ = &next;
                $($crate::runtime::Saved::load(&mut self.$field, next)?;)*
                Some(())
            }
        }
    };
}
