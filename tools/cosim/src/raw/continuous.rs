//! Model Exchange: modes, states, derivatives and event indicators; and partial derivatives of either interface type.
use super::RawInstance;
use super::functions::{Api, EventInfo};
use crate::Status;

/// What `fmi2NewDiscreteStates` and `fmi3UpdateDiscreteStates` tell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiscreteUpdate {
    /// It has to be called once more.
    pub again: bool,
    /// The FMU asks for the end of the simulation.
    pub terminate: bool,
    /// Nominal values of states have changed.
    pub nominals_changed: bool,
    /// Values of states have changed.
    pub values_changed: bool,
    /// The next time event (s).
    pub next: Option<f64>,
}

// SAFETY, for all unsafe blocks below: the functions belong to the loaded library, the handle is alive, and each
// pointer comes with the length of what it points to.
impl RawInstance {
    /// `EnterEventMode`
    pub fn enter_event_mode(&mut self) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.enter_event.map(|f| unsafe { f(h) }))
    }

    /// One iteration of the events.
    pub fn update_discrete_states(&mut self) -> (Status, DiscreteUpdate) {
        let mut update = DiscreteUpdate::default();
        let status = self.status(|api, _, h| match api {
            Api::Two(f) => {
                let mut info = EventInfo::default();
                let new = f.new_discrete_states?;
                // SAFETY: see above.
                let status = unsafe { new(h, &mut info) };
                update = DiscreteUpdate {
                    again: info.again != 0,
                    terminate: info.terminate != 0,
                    nominals_changed: info.nominals_changed != 0,
                    values_changed: info.values_changed != 0,
                    next: (info.next_defined != 0).then_some(info.next),
                };
                Some(status)
            }
            Api::Three(f) => {
                let [mut again, mut terminate, mut nominals, mut values, mut defined] = [0; 5];
                let mut next = 0.0;
                let new = f.update_discrete?;
                // SAFETY: see above.
                let status = unsafe {
                    new(h, &mut again, &mut terminate, &mut nominals, &mut values, &mut defined, &mut next)
                };
                update = DiscreteUpdate {
                    again: again != 0,
                    terminate: terminate != 0,
                    nominals_changed: nominals != 0,
                    values_changed: values != 0,
                    next: (defined != 0).then_some(next),
                };
                Some(status)
            }
        });
        (status, update)
    }

    /// `EnterContinuousTimeMode`
    pub fn enter_continuous_time_mode(&mut self) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.enter_continuous.map(|f| unsafe { f(h) }))
    }

    /// `CompletedIntegratorStep`, without going back before this point; then whether event mode is asked for, and
    /// whether the end is.
    pub fn completed_integrator_step(&mut self) -> (Status, bool, bool) {
        let (mut event, mut end) = (false, false);
        let status = self.status(|api, _, h| match api {
            Api::Two(f) => {
                let (mut a, mut b) = (0, 0);
                let call = f.completed_step?;
                // SAFETY: see above.
                let status = unsafe { call(h, 1, &mut a, &mut b) };
                (event, end) = (a != 0, b != 0);
                Some(status)
            }
            Api::Three(f) => {
                let (mut a, mut b) = (0, 0);
                let call = f.completed_step?;
                // SAFETY: see above.
                let status = unsafe { call(h, true, &mut a, &mut b) };
                (event, end) = (a != 0, b != 0);
                Some(status)
            }
        });
        (status, event, end)
    }

    /// `SetTime`, s
    pub fn set_time(&mut self, t: f64) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.set_time.map(|f| unsafe { f(h, t) }))
    }

    /// `SetContinuousStates`
    pub fn set_states(&mut self, x: &[f64]) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.set_states.map(|f| unsafe { f(h, x.as_ptr(), x.len()) }))
    }

    /// `GetContinuousStates`
    pub fn get_states(&mut self, x: &mut [f64]) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.get_states.map(|f| unsafe { f(h, x.as_mut_ptr(), x.len()) }))
    }

    /// The derivatives of all states, per s.
    pub fn get_derivatives(&mut self, x: &mut [f64]) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.get_derivatives.map(|f| unsafe { f(h, x.as_mut_ptr(), x.len()) }))
    }

    /// `GetEventIndicators`
    pub fn get_indicators(&mut self, z: &mut [f64]) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.get_indicators.map(|f| unsafe { f(h, z.as_mut_ptr(), z.len()) }))
    }

    /// `GetNominalsOfContinuousStates`
    pub fn get_nominals(&mut self, x: &mut [f64]) -> Status {
        // SAFETY: see above.
        self.status(|_, c, h| c.get_nominals.map(|f| unsafe { f(h, x.as_mut_ptr(), x.len()) }))
    }

    /// FMI 3: the numbers of continuous states and of event indicators.
    pub fn numbers(&mut self) -> Result<(usize, usize), Status> {
        let (mut states, mut indicators) = (0, 0);
        let status = self.status(|api, _, h| match api {
            Api::Two(_) => None,
            Api::Three(f) => {
                let (a, b) = (f.number_of_states?, f.number_of_indicators?);
                // SAFETY: see above.
                let status = unsafe { a(h, &mut states) };
                // SAFETY: see above.
                Some(if status > 1 { status } else { unsafe { b(h, &mut indicators) } })
            }
        });
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
        let (s, o) = (seed.as_ptr(), out.as_mut_ptr());
        let (seeds, outs) = (seed.len(), out.len());
        self.status(|api, _, h| match api {
            // FMI 2 has scalars alone, so references and values are as many.
            Api::Two(f) if nu == outs && nk == seeds => {
                // SAFETY: see above.
                f.directional.map(|f| unsafe { f(h, u, nu, k, nk, s, o) })
            }
            Api::Two(_) => None,
            // SAFETY: see above.
            Api::Three(f) => f.directional.map(|f| unsafe { f(h, u, nu, k, nk, s, seeds, o, outs) }),
        })
    }

    /// FMI 3: the adjoint derivative, `seed` times the Jacobian of `unknowns` over `knowns`.
    pub fn adjoint_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        out: &mut [f64],
    ) -> Status {
        self.status(|api, _, h| match api {
            Api::Two(_) => None,
            Api::Three(f) => f.adjoint.map(|f| {
                let (u, k) = (unknowns.as_ptr(), knowns.as_ptr());
                let (s, o) = (seed.as_ptr(), out.as_mut_ptr());
                // SAFETY: see above.
                unsafe { f(h, u, unknowns.len(), k, knowns.len(), s, seed.len(), o, out.len()) }
            }),
        })
    }

    /// FMI 2: the first derivatives (per s) of real inputs.
    pub fn set_input_derivatives(&mut self, vrs: &[u32], slopes: &[f64]) -> Status {
        let orders = vec![1; vrs.len()];
        self.status(|api, _, h| match api {
            Api::Two(f) if vrs.len() == slopes.len() => f.set_input_derivatives.map(|f| {
                // SAFETY: see above.
                unsafe { f(h, vrs.as_ptr(), vrs.len(), orders.as_ptr(), slopes.as_ptr()) }
            }),
            _ => None,
        })
    }

    /// The first derivatives (per s) of scalar outputs.
    pub fn get_output_derivatives(&mut self, vrs: &[u32], out: &mut [f64]) -> Status {
        let orders = vec![1; vrs.len()];
        let (v, n, o) = (vrs.as_ptr(), vrs.len(), out.as_mut_ptr());
        if n != out.len() {
            return Status::Error;
        }
        self.status(|api, _, h| match api {
            // SAFETY: see above.
            Api::Two(f) => f.get_output_derivatives.map(|f| unsafe { f(h, v, n, orders.as_ptr(), o) }),
            // SAFETY: see above.
            Api::Three(f) => f.get_output_derivatives.map(|f| unsafe { f(h, v, n, orders.as_ptr(), o, n) }),
        })
    }
}
