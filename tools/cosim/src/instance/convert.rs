//! Between the C types of an FMU and those of the caller.
use std::ffi::c_int;

/// Values that are converted at once; a stack buffer of that many keeps the hot calls free of allocation.
const CHUNK: usize = 64;

/// Reads `C` values with `call` and converts them. One value for each reference goes in chunks over the stack;
/// arrays need a buffer, as their boundaries are not known here.
pub(crate) fn convert_get<C: Copy + Default, U>(
    vrs: &[u32],
    values: &mut [U],
    mut call: impl FnMut(&[u32], &mut [C]) -> c_int,
    to: impl Fn(C) -> U,
) -> c_int {
    let mut read = |v: &[u32], out: &mut [U], buffer: &mut [C]| {
        let status = call(v, buffer);
        if status <= 1 {
            out.iter_mut().zip(buffer).for_each(|(o, x)| *o = to(*x));
        }
        status
    };
    if vrs.len() != values.len() {
        return read(vrs, values, &mut vec![C::default(); values.len()]);
    }
    let mut worst = 0;
    for (v, out) in vrs.chunks(CHUNK).zip(values.chunks_mut(CHUNK)) {
        let mut buffer = [C::default(); CHUNK];
        worst = worst.max(read(v, out, &mut buffer[..v.len()]));
        if worst > 1 {
            break;
        }
    }
    worst
}

/// Converts values to `C` and sets them with `call`; the mirror of [`convert_get`].
pub(crate) fn convert_set<C: Copy + Default, U: Copy>(
    vrs: &[u32],
    values: &[U],
    mut call: impl FnMut(&[u32], &[C]) -> c_int,
    from: impl Fn(U) -> C,
) -> c_int {
    if vrs.len() != values.len() {
        return call(vrs, &values.iter().map(|v| from(*v)).collect::<Vec<C>>());
    }
    let mut worst = 0;
    for (v, x) in vrs.chunks(CHUNK).zip(values.chunks(CHUNK)) {
        let mut buffer = [C::default(); CHUNK];
        buffer.iter_mut().zip(x).for_each(|(b, x)| *b = from(*x));
        worst = worst.max(call(v, &buffer[..v.len()]));
        if worst > 1 {
            break;
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_everything_once_and_stop_at_an_error() {
        let vrs: Vec<u32> = (0..150).collect();
        let mut values = vec![0i64; 150];
        let call = |v: &[u32], x: &mut [i32]| {
            v.iter().zip(x).for_each(|(v, x)| *x = *v as i32 * 2);
            0
        };
        assert_eq!(convert_get(&vrs, &mut values, call, i64::from), 0);
        assert!(values.iter().enumerate().all(|(i, v)| *v == 2 * i as i64));
        let mut calls = 0;
        let refuse = |_: &[u32], _: &[i32]| {
            calls += 1;
            3
        };
        assert_eq!(convert_set(&vrs, &values, refuse, |x| x as i32), 3);
        assert_eq!(calls, 1);
    }
}
