//! Parallel evaluation on rayon's threads.
//!
//! rayon's iterators are generic over the closure, so that its scheduling is compiled again at each place that uses them: a tenth of the
//! compiler's work for this crate. Here it is compiled once.

use rayon::prelude::*;
use std::sync::Mutex;

/// Values of `f` for the items, in their order.
pub fn map<T: Sync, R: Send>(items: &[T], f: impl Fn(&T) -> R + Sync) -> Vec<R> {
    indices(items.len(), |k| f(&items[k]))
}

/// All values of `f` for the items, none to several each, in their order.
pub fn flat_map<T: Sync, I: IntoIterator + Send>(items: &[T], f: impl Fn(&T) -> I + Sync) -> Vec<I::Item> {
    map(items, f).into_iter().flatten().collect()
}

/// As [`map`]; the items are begun in their order, so that a deadline ends the last ones.
pub fn in_turn<T: Sync, R: Send>(items: &[T], f: impl Fn(&T) -> R + Sync) -> Vec<R> {
    values(items.len(), |k| f(&items[k]), |count, f| (0..count).par_bridge().for_each(f))
}

/// Values of `f` for 0, 1, ..., `count` - 1.
pub fn indices<R: Send>(count: usize, f: impl Fn(usize) -> R + Sync) -> Vec<R> {
    values(count, f, |count, f| (0..count).into_par_iter().for_each(f))
}

/// The same with one of rayon's iterators.
fn values<R: Send>(
    count: usize,
    f: impl Fn(usize) -> R + Sync,
    each: fn(usize, &(dyn Fn(usize) + Sync)),
) -> Vec<R> {
    let values: Vec<Mutex<Option<R>>> = (0..count).map(|_| Mutex::new(None)).collect();
    each(count, &|k| {
        let value = f(k);
        if let Ok(mut place) = values[k].lock() {
            *place = Some(value);
        }
    });
    // All are there: rayon passes on a panic of `f`.
    values.into_iter().filter_map(|place| place.into_inner().ok().flatten()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..1000).collect();
        let squares: Vec<u64> = items.iter().map(|n| n * n).collect();
        assert_eq!(map(&items, |n| map(&[*n], |n| n * n)[0]), squares);
        assert_eq!(
            flat_map(&items, |n| (n % 2 == 1).then_some(*n)),
            (1..1000).step_by(2).collect::<Vec<_>>()
        );
        assert_eq!(indices(0, |k| k), Vec::<usize>::new());
        assert_eq!(in_turn(&items, |n| n * n), squares);
    }
}
