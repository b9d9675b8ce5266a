//! Model Exchange: modes, states, derivatives and event indicators; and partial derivatives of either interface type.
use super::RawInstance;
use super::functions::{EventInfo, Functions, ids};
use crate::{FmiVersion, Status};
use std::ffi::c_int;

/// Results of `fmi2NewDiscreteStates` and `fmi3UpdateDiscreteStates`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiscreteUpdate {
    /// It has to be called once more.
    pub again: bool,
    /// The FMU requests the end of the simulation.
    pub terminate: bool,
    /// Nominal values of states have changed.
    pub nominals_changed: bool,
    /// Values of states have changed.
    pub values_changed: bool,
    /// The next time event (s).
    pub next: Option<f64>,
}

// SAFETY, for all unsafe blocks below: the functions belong to the loaded library, the handle is alive, and each
// pointer is passed with the length of its array.
impl RawInstance {
    /// One iteration of the events.
    pub fn update_discrete_states(&mut self) -> (Status, DiscreteUpdate) {
        let mut info = EventInfo::default();
        let status = match self.version() {
            FmiVersion::V2 => self.status(ids::new_discrete_states, |f, h| {
                // SAFETY: see above.
                f.new_discrete_states.map(|f| unsafe { f(h, &mut info) })
            }),
            FmiVersion::V3 => {
                let [mut again, mut terminate, mut nominals, mut values, mut defined] = [0; 5];
                let status = self.status(ids::update_discrete_states, |f, h| {
                    let update = f.update_discrete_states?;
                    let (a, t, n, v) = (&mut again, &mut terminate, &mut nominals, &mut values);
                    // SAFETY: see above.
                    Some(unsafe { update(h, a, t, n, v, &mut defined, &mut info.next) })
                });
                info = EventInfo {
                    again: again.into(),
                    terminate: terminate.into(),
                    nominals_changed: nominals.into(),
                    values_changed: values.into(),
                    next_defined: defined.into(),
                    next: info.next,
                };
                status
            }
        };
        let update = DiscreteUpdate {
            again: info.again != 0,
            terminate: info.terminate != 0,
            nominals_changed: info.nominals_changed != 0,
            values_changed: info.values_changed != 0,
            next: (info.next_defined != 0).then_some(info.next),
        };
        (status, update)
    }

    /// `CompletedIntegratorStep`, without a later rollback to a time before this point; returns whether the FMU requests event mode and
    /// whether it requests the end of the simulation.
    pub fn completed_integrator_step(&mut self) -> (Status, bool, bool) {
        let (mut event2, mut end2, mut event3, mut end3) = (0, 0, 0, 0);
        let version = self.version();
        let function = match version {
            FmiVersion::V2 => ids::completed_step2,
            FmiVersion::V3 => ids::completed_step3,
        };
        let status = self.status(function, |f, h| match version {
            // SAFETY: see above.
            FmiVersion::V2 => f.completed_step2.map(|f| unsafe { f(h, 1, &mut event2, &mut end2) }),
            // SAFETY: see above.
            FmiVersion::V3 => f.completed_step3.map(|f| unsafe { f(h, true, &mut event3, &mut end3) }),
        });
        (status, event2 != 0 || event3 != 0, end2 != 0 || end3 != 0)
    }

    /// FMI 3: the numbers of continuous states and of event indicators.
    pub fn numbers(&mut self) -> Result<(usize, usize), Status> {
        let (mut states, mut indicators) = (0, 0);
        let mut status = self
            // SAFETY: see above.
            .status(ids::number_of_states, |f, h| f.number_of_states.map(|f| unsafe { f(h, &mut states) }));
        if status <= Status::Warning {
            status = self.status(ids::number_of_indicators, |f, h| {
                // SAFETY: see above.
                f.number_of_indicators.map(|f| unsafe { f(h, &mut indicators) })
            });
        }
        if status <= Status::Warning { Ok((states, indicators)) } else { Err(status) }
    }

    /// The directional derivative: Jacobian of `unknowns` over `knowns`, times `seed`.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        out: &mut [f64],
    ) -> Status {
        let (u, nu, k, nk) = (unknowns.as_ptr(), unknowns.len(), knowns.as_ptr(), knowns.len());
        let (s, o, seeds, outs) = (seed.as_ptr(), out.as_mut_ptr(), seed.len(), out.len());
        match self.version() {
            // FMI 2 has scalars alone, so references and values are as many.
            FmiVersion::V2 if nu != outs || nk != seeds => Status::Error,
            FmiVersion::V2 => {
                self.status(ids::directional2, |f, h| {
                    // SAFETY: see above.
                    f.directional2.map(|f| unsafe { f(h, u, nu, k, nk, s, o) })
                })
            }
            FmiVersion::V3 => {
                self.status(ids::directional3, |f, h| {
                    // SAFETY: see above.
                    f.directional3.map(|f| unsafe { f(h, u, nu, k, nk, s, seeds, o, outs) })
                })
            }
        }
    }

    /// FMI 3: the adjoint derivative, `seed` times the Jacobian of `unknowns` over `knowns`.
    pub fn adjoint_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        out: &mut [f64],
    ) -> Status {
        let (u, nu, k, nk) = (unknowns.as_ptr(), unknowns.len(), knowns.as_ptr(), knowns.len());
        let (s, o, seeds, outs) = (seed.as_ptr(), out.as_mut_ptr(), seed.len(), out.len());
        // SAFETY: see above.
        self.status(ids::adjoint, |f, h| f.adjoint.map(|f| unsafe { f(h, u, nu, k, nk, s, seeds, o, outs) }))
    }

    /// FMI 2: the first derivatives (per s) of real inputs.
    pub fn set_input_derivatives(&mut self, vrs: &[u32], slopes: &[f64]) -> Status {
        if vrs.len() != slopes.len() {
            return Status::Error;
        }
        const FIRST: [c_int; 64] = [1; 64];
        let mut worst = Status::Ok;
        for (v, s) in vrs.chunks(FIRST.len()).zip(slopes.chunks(FIRST.len())) {
            let (n, v, s) = (v.len(), v.as_ptr(), s.as_ptr());
            let call =
                // SAFETY: see above.
                |f: &Functions, h| f.set_input_derivatives.map(|f| unsafe { f(h, v, n, FIRST.as_ptr(), s) });
            worst = worst.max(self.status(ids::set_input_derivatives, call));
        }
        worst
    }

    /// The first derivatives (per s) of scalar outputs.
    pub fn get_output_derivatives(&mut self, vrs: &[u32], order: i32, out: &mut [f64]) -> Status {
        let orders = vec![order; vrs.len()];
        let (v, n, k, o) = (vrs.as_ptr(), vrs.len(), orders.as_ptr(), out.as_mut_ptr());
        if n != out.len() {
            return Status::Error;
        }
        let version = self.version();
        let function = match version {
            FmiVersion::V2 => ids::output_derivatives2,
            FmiVersion::V3 => ids::output_derivatives3,
        };
        self.status(function, |f, h| match version {
            // SAFETY: see above.
            FmiVersion::V2 => f.output_derivatives2.map(|f| unsafe { f(h, v, n, k, o) }),
            // SAFETY: see above.
            FmiVersion::V3 => f.output_derivatives3.map(|f| unsafe { f(h, v, n, k, o, n) }),
        })
    }
}
