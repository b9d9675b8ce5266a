//! The models: equations, correlations and the fast integrator.
