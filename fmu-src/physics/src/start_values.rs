//! Start values inside the binary, so that an FMU has the start values of its XML even if the importer passes no
//! resource path and sets nothing.
//!
//! The library contains a block of fixed size that begins with [`MAGIC`]. The archive builder writes the start
//! values of a preset into this block of the packed library; the library reads them when it creates an
//! instance. Layout after the magic: number of entries, then that many pairs of value reference and value, all
//! little-endian, `u32` and `f64`.

/// Marker of the block.
pub const MAGIC: [u8; 24] = *b"motor-fmu start values 1";
/// Size of the block, bytes.
pub const SIZE: usize = 8192;
/// Largest number of entries.
pub const CAPACITY: usize = (SIZE - MAGIC.len() - 4) / 12;

/// The block without entries.
pub const fn empty() -> [u8; SIZE] {
    let mut block = [0; SIZE];
    let mut k = 0;
    while k < MAGIC.len() {
        block[k] = MAGIC[k];
        k += 1;
    }
    block
}

/// Reason why start values cannot be written into a library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PatchError {
    /// The empty block does not occur exactly once.
    #[error("the library holds {0} blocks for start values instead of 1")]
    Blocks(usize),
    /// More entries than the block holds.
    #[error("{0} start values are more than the {CAPACITY} that the library can hold")]
    TooMany(usize),
}

/// Writes entries (value reference, value) into the block of a library.
pub fn patch(library: &mut [u8], entries: &[(u32, f64)]) -> Result<(), PatchError> {
    if entries.len() > CAPACITY {
        return Err(PatchError::TooMany(entries.len()));
    }
    // The magic alone is not the block: a linker may keep the constant of this function.
    let is_empty = |at: usize| library.get(at..at + SIZE).is_some_and(|block| *block == empty());
    let magics = library.windows(MAGIC.len()).enumerate().filter(|(_, w)| *w == MAGIC).map(|(k, _)| k);
    let found: Vec<usize> = magics.filter(|&at| is_empty(at)).collect();
    let &[at] = found.as_slice() else { return Err(PatchError::Blocks(found.len())) };
    let Some(block) = library.get_mut(at + MAGIC.len()..at + SIZE) else { return Err(PatchError::Blocks(0)) };
    block[..4].copy_from_slice(&(entries.len() as u32).to_le_bytes());
    for (room, (value_reference, value)) in block[4..].chunks_exact_mut(12).zip(entries) {
        room[..4].copy_from_slice(&value_reference.to_le_bytes());
        room[4..].copy_from_slice(&value.to_le_bytes());
    }
    Ok(())
}

/// The entries of a block.
pub fn entries(block: &[u8; SIZE]) -> impl Iterator<Item = (u32, f64)> + '_ {
    let body = &block[MAGIC.len()..];
    let number = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap_or_default());
    let count = (number(&body[..4]) as usize).min(CAPACITY);
    body[4..].chunks_exact(12).take(count).map(move |entry| {
        (number(&entry[..4]), f64::from_le_bytes(entry[4..].try_into().unwrap_or_default()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_patched_is_read() {
        let mut library = vec![7u8; 100];
        library.extend(empty());
        library.extend(MAGIC);
        library.extend([9u8; 50]);
        patch(&mut library, &[(100, 0.5), (201, -3.25)]).unwrap();
        let block: [u8; SIZE] = library[100..100 + SIZE].try_into().unwrap();
        assert_eq!(entries(&block).collect::<Vec<_>>(), [(100, 0.5), (201, -3.25)]);
        assert_eq!(entries(&empty()).count(), 0);
    }

    #[test]
    fn a_library_without_the_block_is_refused() {
        assert_eq!(patch(&mut [0; 64], &[]), Err(PatchError::Blocks(0)));
        let mut two = [empty(), empty()].concat();
        assert_eq!(patch(&mut two, &[]), Err(PatchError::Blocks(2)));
        assert_eq!(
            patch(&mut empty(), &vec![(1, 1.0); CAPACITY + 1]),
            Err(PatchError::TooMany(CAPACITY + 1))
        );
    }
}
