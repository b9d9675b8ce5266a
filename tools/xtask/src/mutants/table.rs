//! The mutants: one way each in which a motor model is wrong and may look right.

use super::Mutant;

const EQUATIONS: &str = "fmu-src/physics/src/models/annulus_cooled_motor/equations.rs";
const SYSTEM: &str = "fmu-src/physics/src/models/annulus_cooled_motor/equations/system.rs";
const NETWORK: &str = "fmu-src/physics/src/models/annulus_cooled_motor/network.rs";
const MOTOR: &str = "fmu-src/physics/src/components/motor.rs";
const THERMAL: &str = "fmu-src/physics/src/components/thermal.rs";
const CONDUCTANCE: &str = "fmu-src/physics/src/components/conductance.rs";
const SENSOR: &str = "fmu-src/physics/src/components/sensor.rs";
const HOUSING_STEM: &str = "fmu-src/physics/src/effects/housing_sensor_stem_loss.rs";

/// All of them.
pub const MUTANTS: &[Mutant] = &[
    Mutant {
        name: "heat-uphill",
        file: THERMAL,
        text: "(t_w - t_h) / self.R_wh",
        replacement: "(t_h - t_w) / self.R_wh",
        breaks: "heat flows from the cold housing to the hot winding",
    },
    Mutant {
        name: "heat-from-ambient",
        file: EQUATIONS,
        text: "conductance.housing * (temperature[CORE] - ambient)",
        replacement: "conductance.housing * (ambient - temperature[CORE])",
        breaks: "the surroundings heat the warm housing",
    },
    Mutant {
        name: "back-emf-sign",
        file: SYSTEM,
        text: "- lost - k * w)",
        replacement: "- lost + k * w)",
        breaks: "the back-EMF drives the current instead of opposing it",
    },
    Mutant {
        name: "torque-sign",
        file: SYSTEM,
        text: "(k * i - instant.drag - self.load.at(t)) * self.constants.inverse_j",
        replacement: "(-k * i - instant.drag - self.load.at(t)) * self.constants.inverse_j",
        breaks: "a positive current turns the shaft backwards",
    },
    Mutant {
        name: "load-sign",
        file: SYSTEM,
        text: "- self.load.at(t)) * self.constants.inverse_j",
        replacement: "+ self.load.at(t)) * self.constants.inverse_j",
        breaks: "the load pulls the shaft along",
    },
    Mutant {
        name: "cold-resistance",
        file: MOTOR,
        text: "self.R_ref * (1.0 + self.alpha * (t_w - self.T_ref))",
        replacement: "self.R_ref * (1.0 + 0.0 * self.alpha * (t_w - self.T_ref))",
        breaks: "the winding's resistance does not rise with its temperature",
    },
    Mutant {
        name: "cold-magnets",
        file: MOTOR,
        text: "self.k_t * (1.0 + self.alpha_mag * (t_m - self.T_ref))",
        replacement: "self.k_t * (1.0 + 0.0 * self.alpha_mag * (t_m - self.T_ref))",
        breaks: "the magnets do not weaken when warm",
    },
    Mutant {
        name: "lost-friction-heat",
        file: SYSTEM,
        text: "self.drag_in_core(w, instant.drag * w))",
        replacement: "self.drag_in_core(w, 0.0 * instant.drag * w))",
        breaks: "friction takes power from the shaft that heats nothing",
    },
    Mutant {
        name: "lost-copper-heat",
        file: SYSTEM,
        text: "let copper = volts * i + self.ripple_loss(t_w);",
        replacement: "let copper = 0.5 * volts * i + self.ripple_loss(t_w);",
        breaks: "half of the copper loss heats nothing",
    },
    Mutant {
        name: "fan-exponent",
        file: CONDUCTANCE,
        text: "n.powf(0.8)",
        replacement: "n.powf(0.5)",
        breaks: "the wrong exponent of Reynolds' number in forced convection",
    },
    Mutant {
        name: "inductive-energy",
        file: SYSTEM,
        text: "(self.magnetic(x1[0]) - self.magnetic(x0[0]))",
        replacement: "0.0 * (self.magnetic(x1[0]) - self.magnetic(x0[0]))",
        breaks: "the energy in the inductance is booked as copper heat",
    },
    Mutant {
        name: "hasty-sensor",
        file: SENSOR,
        text: "(to - from) / h * (h - tau * e)",
        replacement: "(to - from) / h * h",
        breaks: "the sensor follows a ramp without a lag",
    },
    Mutant {
        name: "warm-stem",
        file: HOUSING_STEM,
        text: "t - self.k * (t - t_a)",
        replacement: "t + self.k * (t - t_a)",
        breaks: "a sensor that the air cools shows too much",
    },
    Mutant {
        name: "generic-heat-sign",
        file: EQUATIONS,
        text: "- self.ports().housing_heat(temperature[CORE])",
        replacement: "+ self.ports().housing_heat(temperature[CORE])",
        breaks: "a term that heats the housing cools it",
    },
    Mutant {
        name: "air-does-not-warm",
        file: NETWORK,
        text: "air: air + taken,",
        replacement: "air: air + 0.0 * taken,",
        breaks: "every segment of the housing meets fresh air",
    },
    Mutant {
        name: "tube-takes-no-radiation",
        file: NETWORK,
        text: "to_tube += radiated - from_tube;",
        replacement: "to_tube += 0.0 * radiated - from_tube;",
        breaks: "what the housing radiates to the tube is gone",
    },
    Mutant {
        name: "heat-lost-between-stator-and-housing",
        file: NETWORK,
        text: "inflow.segment[k] = (q + to_housing) / h;",
        replacement: "inflow.segment[k] = (0.999 * q + to_housing) / h;",
        breaks: "a thousandth of the heat is lost where two solvers meet",
    },
];
