//! Tests over all modes: the linearized coefficients follow each of their conditions.

use super::tangent::{RISE, TOLERANCE as OF_FLOWS};
use super::{Coefficients, Conditions, Cooling, CoolingMode, Method, Site, Tangent, method};
use crate::groups::Grouped;
use crate::models::annulus_cooled_motor::parameters::Parameters;
use crate::models::annulus_cooled_motor::variables::{EnergyBalance, Inputs};
use declare::{Group, Kind, Scalar, Unit};

/// Permitted error of the heat flows after a change of one condition, as a fraction of the larger flow. Measured: 5e-5 for the inlet
/// temperature of a coolant, 4e-4 for a tube whose temperature is no condition.
const TOLERANCE: f64 = 1e-4;
/// The same for the ambient temperature: air properties are constant over 0.25 K. Measured: 2.5e-4.
const TOLERANCE_AMBIENT: f64 = 5e-4;

fn all_modes() -> impl Iterator<Item = CoolingMode> {
    (1..).map_while(|value| CoolingMode::from_f64(f64::from(value)))
}

/// Inputs of which those of the cooling that start at 0 have this part of their nominal value, within their limits.
fn flowing(part: f64) -> Inputs {
    let mut of_cooling = Conditions::NONE;
    let names: Vec<&str> = of_cooling.named().into_iter().map(|(name, _)| name).collect();
    let mut inputs = Inputs::default();
    for (row, input) in Inputs::TABLE.iter().enumerate() {
        if input.start == 0.0 && names.contains(&input.name) {
            inputs.set(row, input.limited(part * input.nominal));
        }
    }
    inputs
}

/// A change of a condition with this value: 0.2 K of a temperature, 2 % of another input or, if larger, of its nominal value.
fn size_of_change(name: &str, value: f64) -> f64 {
    match Inputs::TABLE.iter().find(|input| input.name == name) {
        Some(input) if input.unit != Unit::Kelvin => 0.02 * value.abs().max(input.nominal),
        _ => 0.2,
    }
}

/// What a mode needs so that the linearized coefficients follow a condition.
fn remedy(name: &str) -> &'static str {
    match name {
        "tube" => {
            "`tube` is the temperature of the mode's node: return its heat capacity in Method::tube_capacity"
        }
        "surface" | "ambient" => "the coefficients must be continuous in this temperature",
        _ => "reduce the first change of this input in the list `inputs` of cooling/mod.rs",
    }
}

/// The coefficients at `now` as the network computes them.
fn follow(
    tangent: &mut Tangent,
    cooling: &Cooling,
    parameters: &Parameters,
    now: Conditions,
) -> Coefficients {
    if !tangent.serves(&now) {
        tangent.evaluate(cooling, parameters, now);
    }
    let mut out = Coefficients::NONE;
    tangent.coefficients(cooling, parameters, &now, &mut out);
    out
}

/// From warm, hot and cold conditions with flows, each condition is changed alone by less than, about and more than the change at which
/// the coefficients are evaluated again. The heat flows must be those of the full equations.
#[test]
fn linearized_coefficients_follow_each_condition() {
    for mode in all_modes() {
        let mut parameters = Parameters::default();
        parameters.choices.cooling_mode = mode;
        let segments = if method(mode).has_network() { 3 } else { 1 };
        let cooling = Cooling::new(&parameters, segments);
        let inputs = flowing(0.5);
        for [surface, tube] in [[345.0, 320.0], [330.0, 326.0], [400.0, 390.0], [275.0, 285.0]] {
            let at = Conditions::of(&inputs, surface, tube, 298.0);
            let count = at.clone().named().len();
            for (field, share) in
                (0..count).flat_map(|k| [1.0, -1.0, 0.5, -0.5, 0.1, -0.1, 0.01].map(|s| (k, s)))
            {
                let mut now = at;
                let (name, value) = now.named().swap_remove(field);
                let change = share * size_of_change(name, *value);
                *value += change;
                assert!(now != at, "`{name}` does not change by {change}");
                let mut tangent = Tangent::NONE;
                tangent.evaluate(&cooling, &parameters, at);
                let followed = follow(&mut tangent, &cooling, &parameters, now);
                let truth = cooling.coefficients(&parameters, &now).heats(&now, segments);
                let tolerance = if name == "ambient" { TOLERANCE_AMBIENT } else { TOLERANCE };
                let size = truth[0].abs().max(truth[1].abs());
                for (got, want) in followed.heats(&now, segments).into_iter().zip(truth) {
                    assert!(
                        (got - want).abs() <= tolerance * size,
                        "{mode:?}: the linearized coefficients do not follow the condition `{name}`: heat flow {got} W and not {want} W \
                         after a change by {change}; {}",
                        remedy(name)
                    );
                }
            }
        }
    }
}

/// A thermostat that opens over some kelvin of the housing, and a heat pipe to the node with a largest heat flow.
#[derive(Debug)]
struct Bending;

impl Method for Bending {
    fn tube_capacity(&self, _: &Parameters) -> f64 {
        50.0
    }

    fn add(&self, site: &Site, c: &mut Coefficients) {
        let n = site.segments;
        let open = 1.0 + (0.5 * (site.at.surface - 335.0)).tanh();
        c.ambient_conductance[..n].fill(site.free() + 0.2 * open / n as f64);
        c.to_tube = 4.0 * 10.0 / 10.0f64.hypot(4.0 * (site.at.surface - site.at.tube)) / n as f64;
        c.tube_to_ambient = 0.5;
    }
}

/// A mode that bends within some kelvin needs no reach of its own: on the way through the bends each heat flow is within twice the tolerance, and
/// the heats of the whole way within half of it. Rising and falling, with steps of 1 mK and 0.1 K.
#[test]
fn the_reach_follows_the_curvature() {
    let parameters = Parameters::default();
    let cooling = Cooling::of(&Bending, &parameters, 3);
    for (from, to) in [(325.0, 345.0), (345.0, 325.0)] {
        for steps in [20_000, 200] {
            let mut tangent = Tangent::NONE;
            let (mut worst, mut sums) = (0.0f64, [0.0; 2]);
            for k in 0..=steps {
                let surface = from + (to - from) * f64::from(k) / f64::from(steps);
                let now = Conditions::of(&Inputs::default(), surface, 320.0 + 0.4 * (surface - 325.0), 298.0);
                let got = follow(&mut tangent, &cooling, &parameters, now).heats(&now, 3)[0];
                let want = cooling.coefficients(&parameters, &now).heats(&now, 3)[0];
                worst = worst.max((got - want).abs() / want);
                sums = [sums[0] + got, sums[1] + want];
            }
            let whole = (sums[0] / sums[1] - 1.0).abs();
            assert!(
                worst <= 2.0 * OF_FLOWS && whole <= 0.5 * OF_FLOWS,
                "{from} to {to}, {steps}: {worst:e} {whole:e}"
            );
        }
    }
}

/// Smooth modes bend no more than natural convection, c = x^(1/4), for which the comparison finds 3/32 r (r + w)/x^2 of the flow.
#[test]
fn modes_that_are_smooth_bend_as_natural_convection() {
    for mode in all_modes().filter(|mode| method(*mode).is_smooth()) {
        let mut parameters = Parameters::default();
        parameters.choices.cooling_mode = mode;
        let cooling = Cooling::new(&parameters, 3);
        for part in [0.0, 0.1, 0.5, 1.0, 10.0] {
            for (surface, share) in
                [(3.0, 0.2), (10.0, 0.5), (30.0, 0.9), (80.0, 0.4), (200.0, 0.7), (-20.0, 0.5)]
            {
                let at = Conditions::of(&flowing(part), 298.0 + surface, 298.0 + share * surface, 298.0);
                let tangent = Tangent::new(&cooling, &parameters, at);
                let back = tangent.back();
                let error = tangent.error(&cooling.coefficients(&parameters, &back), &back, 3);
                let reach = at.surface - back.surface;
                let natural = 3.0 / 32.0 * reach * (reach + RISE) / (surface * surface);
                assert!(
                    error <= OF_FLOWS + natural,
                    "{mode:?} bends too much for Method::is_smooth: {error:e} of the heat flow at a rise of {surface} K, inputs \
                     at {part} of their nominal values; natural convection {natural:e}. Leave is_smooth out: the curvature is then measured."
                );
            }
        }
    }
}

#[test]
fn outputs_of_other_modes_are_no_temperature_of_0_kelvin() {
    let shown = EnergyBalance::without_flow(&Inputs::default(), 300.0);
    for (row, variable) in EnergyBalance::TABLE.iter().enumerate() {
        assert!(
            variable.unit != Unit::Kelvin || variable.relative || shown.get(row) > 100.0,
            "{} is 0 K in the cooling modes that do not compute it: add it to EnergyBalance::without_flow in variables.rs",
            variable.name
        );
    }
}

/// Each parameter and each condition is changed alone: the heat paths that were kept from before may serve only where a thread that knows none
/// computes the same.
#[test]
fn what_is_kept_depends_on_every_parameter_and_condition() {
    let fresh = |parameters: &Parameters, at: &Conditions| {
        std::thread::scope(|scope| {
            let all = scope.spawn(|| Cooling::new(parameters, 3).coefficients(parameters, at).heats(at, 3));
            all.join().unwrap()
        })
    };
    for mode in all_modes() {
        let mut base = Parameters::default();
        base.choices.cooling_mode = mode;
        let at = Conditions::of(&flowing(0.5), 345.0, 320.0, 298.0);
        let mut changed = Vec::new();
        for (group, rows) in Parameters::groups().iter().enumerate() {
            for (row, variable) in rows.table.iter().enumerate() {
                let mut parameters = base;
                let value = base.value(group, row);
                let other = if value == 0.0 { 1e-3 * variable.nominal } else { 1.01 * value };
                if variable.kind == Kind::Real && parameters.set_value(group, row, other) {
                    changed.push((format!("{}{}", rows.prefix, variable.name), parameters, at));
                }
            }
        }
        for k in 0..at.clone().named().len() {
            let mut now = at;
            let (name, value) = now.named().swap_remove(k);
            *value *= 1.001;
            changed.push((name.to_string(), base, now));
        }
        for (name, parameters, now) in changed {
            Cooling::new(&base, 3).coefficients(&base, &at);
            let got = Cooling::new(&parameters, 3).coefficients(&parameters, &now).heats(&now, 3);
            assert_eq!(
                got,
                fresh(&parameters, &now),
                "{mode:?}: `{name}` is missing in Key of cooling/repeated.rs"
            );
        }
    }
}
