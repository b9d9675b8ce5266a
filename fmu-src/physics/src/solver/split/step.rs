//! One step without control of its error, compiled once for every processor and once for those with AVX, where the same operations take
//! fewer instructions. The results are equal bit for bit.

use super::frozen::{Frozen, Matrices};
use super::{FAST_FLOOR, Fast, HeatCapacities, Segment, Split, State, StepIntegrals, System, largest};
use crate::solver::phi::{Forcing, product};
use nalgebra::SVector;

/// Absolute tolerance of temperatures, K (times [`super::TOLERANCE`]).
const THERMAL_FLOOR: f64 = 1.0;
/// Absolute tolerance of heat, as temperature of the smallest node, K (times [`super::TOLERANCE`]).
const HEAT_FLOOR: f64 = 1.0;
/// Sensitivity of copper and magnets to temperature, 1/K: effect of a temperature error on the fast block.
const SENSITIVITY: f64 = 0.004;
/// Largest number of iterations between the two blocks.
const ROUNDS: usize = 4;
/// Temperature limit, K: above it the solution has diverged and the step is rejected.
const ABSURD: f64 = 1e5;

/// Guessed temperatures in the middle and at the end of a step, and whether better ones may follow.
type Guess<const N: usize> = (Option<[SVector<f64, N>; 2]>, bool);
/// The error of a step, or better temperatures.
type Iteration<const N: usize> = Result<f64, [SVector<f64, N>; 2]>;

impl<const N: usize> Split<N> {
    /// One step of length `h` from `t`: its error in units of the tolerance; an error above `most` leaves the state unchanged.
    #[inline]
    pub(super) fn step<const E: usize>(
        &mut self,
        system: &impl System<N>,
        state: &mut State<N, E>,
        time: (f64, f64),
        most: f64,
        backup: &mut Option<Matrices<N>>,
    ) -> f64 {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx") {
            // SAFETY: the processor has AVX.
            #[allow(unsafe_code)]
            return unsafe { self.step_with_avx(system, state, time, most, backup) };
        }
        self.step_anywhere(system, state, time, most, backup)
    }
}

/// Defines a step and its iteration for a set of instructions. Neither is inlined: the loop around the iteration hardly ever repeats, but the
/// compiler would keep in memory all that is constant in it.
macro_rules! compiled {
    ($(#[$instructions:meta])* $step:ident, $iterate:ident) => {
        impl<const N: usize> Split<N> {
            $(#[$instructions])*
            #[inline(never)]
            fn $step<S: System<N>, const E: usize>(
                &mut self,
                system: &S,
                state: &mut State<N, E>,
                time: (f64, f64),
                most: f64,
                backup: &mut Option<Matrices<N>>,
            ) -> f64 {
                self.step_by(system, state, time, backup, |split, state, start, guess| {
                    split.$iterate(system, state, time, start, guess, most)
                })
            }

            $(#[$instructions])*
            #[inline(never)]
            fn $iterate<S: System<N>, const E: usize>(
                &self,
                system: &S,
                state: &mut State<N, E>,
                time: (f64, f64),
                start: (&S::Instant, &Fast),
                guess: Guess<N>,
                most: f64,
            ) -> Iteration<N> {
                self.iterate(system, state, time, start, guess, most)
            }
        }
    };
}

compiled!(step_anywhere, iterate_anywhere);
compiled!(
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    step_with_avx,
    iterate_with_avx
);

impl<const N: usize> Split<N> {
    #[inline(always)]
    fn step_by<S: System<N>, const E: usize>(
        &mut self,
        system: &S,
        state: &mut State<N, E>,
        (t, h): (f64, f64),
        backup: &mut Option<Matrices<N>>,
        iterate: impl Fn(&Self, &mut State<N, E>, (&S::Instant, &Fast), Guess<N>) -> Iteration<N>,
    ) -> f64 {
        let scale = self.ease[0] * self.scale;
        let start = system.instant(t, &state.x, &state.temperature);
        let slope0 = system.fast_rates_at(t, &state.x, &state.temperature, &start);
        self.frozen.renew(system, (t, h), (&state.x, &slope0, &state.temperature, &start), scale, backup);
        let mut guess = None;
        let mut left = ROUNDS;
        loop {
            left -= 1;
            match iterate(self, state, (&start, &slope0), (guess, left > 0)) {
                Ok(error) => return error,
                Err(better) => guess = Some(better),
            }
        }
    }

    /// One iteration between the blocks over a step, from guessed temperatures in the middle and at the end of the step; `Err` with
    /// better ones if they differ from the solution and `continues` allows.
    #[inline(always)]
    fn iterate<S: System<N>, const E: usize>(
        &self,
        system: &S,
        state: &mut State<N, E>,
        (t, h): (f64, f64),
        (start, slope0): (&S::Instant, &Fast),
        (guess, continues): Guess<N>,
        most: f64,
    ) -> Iteration<N> {
        let (x0, temp0) = (state.x, state.temperature);
        let Frozen { fast, squares, thermal, .. } = &self.frozen;
        let (a, m) = (fast.matrix(), thermal.matrix());
        let HeatCapacities { values: capacity, inverse: per_joule } = system.capacity();

        let [per_tolerance, per_stage, per_line] =
            self.per_tolerance[usize::from(system.bends_where_stiff())];
        let (middle, until) = (t + 0.5 * h, t + h);
        let slope0 = *slope0;
        let (network0, _) = system.network(t, &temp0);
        let heat0 = system.heat_rates_at(t, &x0, &temp0, start);
        let rate0 = network0 + heat0.component_mul(per_joule);
        let change_a = fast.half(&slope0);
        let xa = x0 + change_a;
        let mut tempm = temp0 + rate0 * (0.5 * h);
        let mut stage = system.instant(middle, &xa, &tempm);
        // Initial guess: temperatures at the end from the heat of the first stage, by which most of a fast transient has decayed.
        let rate = network0 + system.heat_rates_at(middle, &xa, &tempm, &stage).component_mul(per_joule);
        let mut temp1 = temp0 + rate * h;
        if let Some(guess) = guess {
            [tempm, temp1] = guess;
            stage = system.instant(middle, &xa, &tempm);
        }
        // What N adds to N_0 at the stages.
        let na = system.fast_rates_at(middle, &xa, &tempm, &stage) - slope0 - product(a, &change_a);
        let change_b = fast.constant(&slope0) + fast.constant(&na) * 2.0;
        let xb = x0 + change_b;
        let slopeb = system.fast_rates(until, &xb, &temp1);
        let nb = slopeb - slope0 - product(a, &change_b);
        let forcing = Forcing::through(na, nb);
        let (x1, xm) = (fast.end(&x0, &slope0, &forcing), fast.middle(&x0, &slope0, &forcing));
        let x = [x0, xm, x1];
        let (integral, moment) = (fast.integral(&x0, &slope0, &forcing), fast.moment(&x0, &slope0, &forcing));
        let (second, n0) = (fast.second(&x0, &slope0, &forcing), slope0 - product(a, &x0));
        let (square, error_of_square) =
            squares.integral(h, &x, [&integral, &moment, &second], (&n0, &forcing));
        let segment = Segment {
            t,
            h,
            x,
            square,
            error_of_square,
            integral,
            moment,
            temperature: [temp0, tempm, temp1],
        };
        let instants = [*start, system.instant(middle, &xm, &tempm), system.instant(until, &x1, &temp1)];
        let work = system.work(&segment, &instants);

        // Heat flow with exactly the integral of the step: Simpson's rule solved for the middle value.
        let heat1 = system.heat_rates_at(until, &x1, &temp1, &instants[2]);
        let heatm = work.heat * (1.5 / h) - (heat0 + heat1) * 0.25;
        let share = -m.tr_mul(capacity);
        let beyond = |t: f64, temperature: &SVector<f64, N>, heat: SVector<f64, N>| {
            let (rates, outflow) = system.network_remainder(t, temperature, m, &share);
            (rates + heat.component_mul(per_joule), outflow)
        };
        let (warming0, outflow0) = beyond(t, &temp0, heat0);
        let (warmingm, outflowm) = beyond(middle, &tempm, heatm);
        let (warming1, outflow1) = beyond(until, &temp1, heat1);
        let warming = Forcing::through(warmingm - warming0, warming1 - warming0);
        let (half, end) = (thermal.middle(&temp0, &rate0, &warming), thermal.end(&temp0, &rate0, &warming));
        let coupling_error = largest(&(end - temp1).abs().sup(&(half - tempm).abs()));
        let settled = SENSITIVITY * coupling_error * per_stage <= 0.3;
        if continues && !settled {
            return Err([half, end]);
        }

        let per_size = x0.abs().sup(&x1.abs()).sup(&FAST_FLOOR).map(f64::recip);
        let line_error = largest(&fast.curvature_error(&forcing).component_mul(&per_size));
        // In a stiff block the end state depends only on the remainder at the end, which is equal for parabola and line;
        // the error estimate is the difference of the remainders at the end and at the last stage.
        let stage_error =
            system.fast_rates_at(until, &x1, &temp1, &instants[2]) - slopeb - product(a, &(x1 - xb));
        let stage_error = fast.last_stage_error(&stage_error);
        let stage_error = largest(&stage_error.component_mul(&per_size));
        // The integral of the heat is exact; its shape within the step only matters as far as the node relaxes over the step.
        let thermal_error = largest(&product(m, &thermal.curvature_error(&warming))) * h / THERMAL_FLOOR;
        // The heat of a transient that decays early is not a parabola, and is released before the middle.
        let shape_error = system.heat_rates_at(middle, &xm, &tempm, &instants[1]) - heatm;
        let shape_error = largest(&shape_error.component_mul(per_joule)) * h;
        let heat_error = work.quadrature_error * largest(per_joule) / HEAT_FLOOR;
        let of_heat = thermal_error + heat_error + SENSITIVITY * shape_error;
        let error = line_error * per_line
            + (stage_error + SENSITIVITY * coupling_error) * per_stage
            + of_heat * per_tolerance;
        // Heat to ambient: the linear part of the frozen network from the exact integral, the rest by Simpson's rule.
        let over_time = thermal.integral(&temp0, &rate0, &warming);
        let outflow = share.dot(&over_time) + h / 6.0 * (outflow0 + 4.0 * outflowm + outflow1);
        let gained = [work.electrical, work.mechanical, outflow + work.ambient];
        let angle = state.angle + segment.integral[1];
        let finite = x1.sum() + end.sum() + angle;
        let sane = finite.is_finite() && largest(&end) < ABSURD && !error.is_nan();
        let error = if sane { error } else { f64::INFINITY };
        if error <= most {
            (state.x, state.angle, state.temperature) = (x1, angle, end);
            for (sum, gain) in state.energy.iter_mut().zip(gained.iter().chain(&work.losses)) {
                *sum += gain;
            }
            state.integrals +=
                StepIntegrals { fast: segment.integral, temperature: over_time, aside: work.aside, outflow };
        }
        Ok(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;
    use crate::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode};

    /// On a processor with AVX these are two compilations of one step.
    #[test]
    fn the_instructions_of_the_processor_change_no_bit() {
        for (drive_mode, drop) in [(DriveMode::Voltage, 0.0), (DriveMode::Pwm, 1.5)] {
            let mut motor = AnnulusCooledMotor::default();
            motor.parameters.choices.drive_mode = drive_mode;
            motor.parameters.effects.coulomb_friction.tau_c = 0.01;
            motor.parameters.effects.bridge_drop.V_0 = drop;
            (motor.inputs.voltage, motor.inputs.duty, motor.inputs.load_torque) = (24.0, 0.7, 0.03);
            motor.start(0.0).unwrap();
            let mut state = *motor.state();
            let system = motor.step_equations();
            let (mut split, mut other) = (Split::default(), Split::default());
            for h in [1e-4, 1e-4, 1e-3, 0.01, 0.1, 1e-5] {
                let mut same = state;
                let error = split.step(&system, &mut state, (0.0, h), f64::INFINITY, &mut None);
                let anywhere = other.step_anywhere(&system, &mut same, (0.0, h), f64::INFINITY, &mut None);
                assert_eq!(error.to_bits(), anywhere.to_bits(), "error of a step of {h} s");
                let bits = |state: &State<2>| state.to_numbers().map(f64::to_bits).collect::<Vec<u64>>();
                assert_eq!(bits(&state), bits(&same), "step of {h} s");
                assert!(state.x[1] > 0.0 && split == other);
            }
        }
    }
}
