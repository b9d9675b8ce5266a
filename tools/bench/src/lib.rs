//! Benchmarks of the product: `cargo xtask bench`.
