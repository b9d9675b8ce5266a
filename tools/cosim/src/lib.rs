//! A black-box FMI client: load, step and record any FMU.
