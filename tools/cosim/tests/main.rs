//! All integration tests of the FMI client, in one program.

mod common;
#[path = "common/counting.rs"]
mod counting;
mod parts;

mod allocation;
mod archives;
mod figures;
mod instances;
mod ode;
mod simulations;
mod system_allocation;
mod system_faults;
mod system_inputs;
mod system_loops;
mod system_ssp;
mod systems;
