//! Tables: from which printed values a start value follows, and by which formula.

/// One of the ways to derive a variable: the formula, the quantities and variables that it needs, and how.
pub(super) struct Derived {
    pub(super) name: &'static str,
    pub(super) formula: &'static str,
    pub(super) needs: &'static [&'static str],
    pub(super) of: fn(&[f64]) -> f64,
}

const fn from(name: &'static str, key: &'static [&'static str]) -> Derived {
    Derived { name, formula: "", needs: key, of: |v| v[0] }
}

const fn derived(
    name: &'static str,
    formula: &'static str,
    needs: &'static [&'static str],
    of: fn(&[f64]) -> f64,
) -> Derived {
    Derived { name, formula, needs, of }
}

/// The ways, in order: of a variable, the first whose needs are there counts. A need is a printed quantity or a variable above.
pub(super) const WAYS: &[Derived] = &[
    from("motor.k_t", &["torque_constant"]),
    derived("motor.k_t", "1 / speed constant", &["speed_constant"], |v| 1.0 / v[0]),
    from("motor.k_t", &["back_emf_constant"]),
    derived("motor.k_t", "1 / current constant", &["current_constant"], |v| 1.0 / v[0]),
    derived("motor.k_t", "stall torque / stall current", &["stall_torque", "stall_current"], |v| v[0] / v[1]),
    derived(
        "motor.k_t",
        "(U - R I_0) / no-load speed",
        &["nominal_voltage", "terminal_resistance", "no_load_current", "no_load_speed"],
        |v| (v[0] - v[1] * v[2]) / v[3],
    ),
    derived("motor.k_t", "motor constant x sqrt(R)", &["motor_constant", "terminal_resistance"], |v| {
        v[0] * v[1].sqrt()
    }),
    derived("motor.k_t", "sqrt(R / motor regulation)", &["terminal_resistance", "motor_regulation"], |v| {
        (v[0] / v[1]).sqrt()
    }),
    derived(
        "motor.k_t",
        "sqrt(R / speed/torque gradient)",
        &["terminal_resistance", "speed_torque_gradient"],
        |v| (v[0] / v[1]).sqrt(),
    ),
    from("motor.R_ref", &["terminal_resistance"]),
    derived("motor.R_ref", "U / stall current", &["nominal_voltage", "stall_current"], |v| v[0] / v[1]),
    derived("motor.R_ref", "k_t U / stall torque", &["motor.k_t", "nominal_voltage", "stall_torque"], |v| {
        v[0] * v[1] / v[2]
    }),
    derived("motor.R_ref", "speed/torque gradient x k_t^2", &["speed_torque_gradient", "motor.k_t"], |v| {
        v[0] * v[1] * v[1]
    }),
    derived("motor.R_ref", "motor regulation x k_t^2", &["motor_regulation", "motor.k_t"], |v| {
        v[0] * v[1] * v[1]
    }),
    derived("motor.R_ref", "(k_t / motor constant)^2", &["motor.k_t", "motor_constant"], |v| {
        (v[0] / v[1]).powi(2)
    }),
    from("motor.T_ref", &["reference_temperature"]),
    from("motor.L", &["terminal_inductance"]),
    derived("motor.L", "electrical time constant x R", &["electrical_time_constant", "motor.R_ref"], |v| {
        v[0] * v[1]
    }),
    from("motor.J", &["rotor_inertia"]),
    derived(
        "motor.J",
        "mechanical time constant x k_t^2 / R",
        &["mechanical_time_constant", "motor.k_t", "motor.R_ref"],
        |v| v[0] * v[1] * v[1] / v[2],
    ),
    derived(
        "motor.J",
        "k_t U / (R x angular acceleration)",
        &["motor.k_t", "nominal_voltage", "motor.R_ref", "angular_acceleration"],
        |v| v[0] * v[1] / (v[2] * v[3]),
    ),
    from("motor.pole_pairs", &["pole_pairs"]),
    derived("motor.pole_pairs", "number of poles / 2", &["poles"], |v| v[0] / 2.0),
    from("motor.mass", &["mass"]),
    // Static and dynamic friction are the no-load loss, split by its dependence on the speed.
    derived(
        "effect.coulomb_friction.tau_c",
        "static friction torque",
        &["static_friction_torque", "dynamic_friction"],
        |v| v[0],
    ),
    derived(
        "effect.viscous_friction.k",
        "dynamic friction torque over speed",
        &["dynamic_friction", "static_friction_torque"],
        |v| v[0],
    ),
    derived(
        "effect.coulomb_friction.tau_c",
        "k_t I_0 - dynamic friction torque at the no-load speed",
        &["motor.k_t", "no_load_current", "dynamic_friction", "no_load_speed"],
        |v| v[0] * v[1] - v[2] * v[3],
    ),
    derived(
        "effect.viscous_friction.k",
        "dynamic friction torque over speed",
        &["dynamic_friction", "no_load_current", "no_load_speed"],
        |v| v[0],
    ),
    derived(
        "effect.coulomb_friction.tau_c",
        "k_t I_0, all of the no-load loss",
        &["motor.k_t", "no_load_current"],
        |v| v[0] * v[1],
    ),
    from("effect.coulomb_friction.tau_c", &["friction_torque"]),
    from("effect.coulomb_friction.tau_c", &["static_friction_torque"]),
    from("thermal.R_wh", &["resistance_winding_housing"]),
    derived(
        "thermal.R_wh",
        "resistance winding-ambient - resistance housing-ambient",
        &["resistance_winding_ambient", "resistance_housing_ambient"],
        |v| v[0] - v[1],
    ),
    derived(
        "thermal.C_w",
        "winding time constant / R_wh",
        &["winding_time_constant", "resistance_winding_housing"],
        |v| v[0] / v[1],
    ),
    derived(
        "conductance.G_still",
        "1 / thermal resistance housing-ambient",
        &["resistance_housing_ambient"],
        |v| 1.0 / v[0],
    ),
    derived(
        "conductance.G_still",
        "1 / (resistance winding-ambient - resistance winding-housing)",
        &["resistance_winding_ambient", "resistance_winding_housing"],
        |v| 1.0 / (v[0] - v[1]),
    ),
    derived(
        "thermal.C_h",
        "motor time constant / R_ha - C_w",
        &["motor_time_constant", "resistance_housing_ambient", "thermal.C_w"],
        |v| v[0] / v[1] - v[2],
    ),
    from("thermal.T_w_max", &["max_winding_temperature"]),
    from("housing.diameter", &["diameter"]),
    from("housing.length", &["length"]),
];

/// Fractions of a motor of the library, their medians (tests.rs): of the thermal resistance winding-ambient between winding and
/// housing, and of the heat capacity in the winding; and heat capacity over mass, J/(kg.K).
pub(super) const OF_LIBRARY: (f64, f64, f64) = (0.24, 0.09, 460.0);

/// Estimates for what the datasheet does not print: a default that belongs to the declared motor would not go with the rest.
pub(super) const ESTIMATES: &[Derived] = &[
    derived(
        "thermal.R_wh",
        "0.24 of the resistance winding-ambient, the median of the presets",
        &["resistance_winding_ambient"],
        |v| OF_LIBRARY.0 * v[0],
    ),
    derived(
        "conductance.G_still",
        "1 / (resistance winding-ambient - R_wh)",
        &["resistance_winding_ambient", "thermal.R_wh"],
        |v| 1.0 / (v[0] - v[1]),
    ),
    derived("thermal.C_w", "winding time constant / R_wh", &["winding_time_constant", "thermal.R_wh"], |v| {
        v[0] / v[1]
    }),
    derived(
        "thermal.C_w",
        "0.09 of motor time constant / R_ha, the median of the presets",
        &["motor_time_constant", "conductance.G_still"],
        |v| OF_LIBRARY.1 * v[0] * v[1],
    ),
    derived("thermal.C_w", "0.09 x 460 J/(kg.K) x mass, the medians of the presets", &["mass"], |v| {
        OF_LIBRARY.1 * OF_LIBRARY.2 * v[0]
    }),
    derived(
        "thermal.C_h",
        "motor time constant / R_ha - C_w",
        &["motor_time_constant", "conductance.G_still", "thermal.C_w"],
        |v| v[0] * v[1] - v[2],
    ),
    derived(
        "thermal.C_h",
        "460 J/(kg.K) x mass - C_w, the median of the presets",
        &["mass", "thermal.C_w"],
        |v| OF_LIBRARY.2 * v[0] - v[1],
    ),
    derived("thermal.C_r", "C_h / 4, the ratio of the default motor", &["thermal.C_h"], |v| v[0] / 4.0),
    derived(
        "annulus.outer_diameter",
        "diameter + 10 mm, the gap of the default annulus",
        &["housing.diameter"],
        |v| v[0] + 0.01,
    ),
    derived("annulus.length", "length of the motor", &["housing.length"], |v| v[0]),
];

/// Without these there is no motor.
pub(super) const REQUIRED: [(&str, &str); 2] = [
    ("motor.k_t", "torque_constant, speed_constant, back_emf_constant, or stall_torque with stall_current"),
    (
        "motor.R_ref",
        "terminal_resistance, motor_constant, motor_regulation, or nominal_voltage with stall_current or stall_torque",
    ),
];
