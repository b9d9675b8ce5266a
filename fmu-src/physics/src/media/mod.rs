//! Properties of the media, one file each.

pub mod air;
pub mod water;
