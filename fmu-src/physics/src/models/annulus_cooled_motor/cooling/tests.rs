//! Tests over all modes: the linearized coefficients follow each of their conditions.

use super::{Conditions, Cooling, CoolingMode, Tangent, method};
use crate::models::annulus_cooled_motor::parameters::Parameters;
use crate::models::annulus_cooled_motor::variables::Inputs;
use declare::Scalar;

/// Permitted error of the heat flows after a change of one condition, as a fraction of the larger flow. Measured: 5e-5 for the inlet
/// temperature of a coolant, 4e-4 for a tube whose temperature is no condition.
const TOLERANCE: f64 = 1e-4;
/// The same for the ambient temperature: air properties are constant over 0.25 K. Measured: 2.5e-4.
const TOLERANCE_AMBIENT: f64 = 5e-4;

fn all_modes() -> impl Iterator<Item = CoolingMode> {
    (1..).map_while(|value| CoolingMode::from_f64(f64::from(value)))
}

/// What a mode needs so that the linearized coefficients follow a condition.
fn remedy(name: &str) -> &'static str {
    match name {
        "tube" => "`tube` is the temperature of the mode's node: return its heat capacity in Method::tube_capacity",
        "surface" | "ambient" => "the coefficients must be continuous in this temperature",
        _ => "reduce the first change of this input in the list `inputs` of cooling/mod.rs",
    }
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
        let inputs = Inputs {
            fan_command: 0.6,
            coolant_flow_rate: 1e-5,
            coolant_inlet_temperature: 300.0,
            ..Inputs::default()
        };
        for [surface, tube] in [[345.0, 320.0], [330.0, 326.0], [400.0, 390.0], [275.0, 285.0]] {
            let at = Conditions::of(&inputs, surface, tube, 298.0);
            let count = at.clone().named().len();
            for (field, share) in (0..count).flat_map(|k| [1.0, -1.0, 0.1, -0.1, 0.01].map(|s| (k, s))) {
                let mut now = at;
                let (name, value) = now.named().swap_remove(field);
                let temperature = matches!(name, "surface" | "tube" | "ambient" | "coolant_inlet_temperature");
                let change = share * if temperature { 0.2 } else { 0.02 * *value };
                *value += change;
                let mut tangent = Tangent::new(&cooling, &parameters, at);
                let mut followed = *tangent.base();
                if tangent.serves(&now) {
                    tangent.coefficients(&cooling, &parameters, &now, &mut followed);
                } else {
                    followed = cooling.coefficients(&parameters, &now);
                }
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
