//! What a datasheet prints: the table of quantities, each with its unit and what it is in terms of the motor's constants.

/// The constants of a motor that its datasheet follows from, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motor {
    /// Nominal voltage.
    pub u: f64,
    /// Terminal resistance, cold.
    pub r: f64,
    pub k_t: f64,
    /// No-load current.
    pub i_0: f64,
    /// Rotor inertia.
    pub j: f64,
    pub l: f64,
    pub r_wh: f64,
    pub r_ha: f64,
    pub c_w: f64,
    pub c_h: f64,
    /// Continuous current.
    pub i_n: f64,
}

impl Motor {
    /// Number of constants.
    pub const COUNT: usize = 11;
    /// A motor from the middle of the catalogues: where the search starts.
    pub const TYPICAL: Motor = Motor {
        u: 24.0,
        r: 1.0,
        k_t: 0.03,
        i_0: 0.1,
        j: 1e-5,
        l: 3e-4,
        r_wh: 2.0,
        r_ha: 6.0,
        c_w: 20.0,
        c_h: 200.0,
        i_n: 3.0,
    };

    pub fn logarithms(self) -> [f64; Motor::COUNT] {
        let Motor { u, r, k_t, i_0, j, l, r_wh, r_ha, c_w, c_h, i_n } = self;
        [u, r, k_t, i_0, j, l, r_wh, r_ha, c_w, c_h, i_n].map(f64::ln)
    }

    pub fn from_logarithms(x: &[f64]) -> Motor {
        let e = |k: usize| x[k].exp();
        let (u, r, k_t, i_0, j, l) = (e(0), e(1), e(2), e(3), e(4), e(5));
        Motor { u, r, k_t, i_0, j, l, r_wh: e(6), r_ha: e(7), c_w: e(8), c_h: e(9), i_n: e(10) }
    }

    /// Speed at a current; never below a small fraction of that without current, so that a search stays among motors that turn.
    fn speed(&self, current: f64) -> f64 {
        (self.u - self.r * current).max(LEAST * self.u) / self.k_t
    }

    /// Rise of the winding at the continuous current and the speed there, with the no-load loss in the housing.
    fn rise(&self, rise: f64) -> f64 {
        let copper = self.r * (1.0 + COPPER * rise) * self.i_n * self.i_n;
        copper * (self.r_wh + self.r_ha) + self.k_t * self.i_0 * self.speed(self.i_n) * self.r_ha
    }
}

const LEAST: f64 = 0.02;
/// Temperature coefficient of copper, 1/K.
const COPPER: f64 = 0.0039;
/// Temperature of datasheets where none is given, K.
pub(super) const COLD: f64 = 298.15;

/// A quantity of datasheets.
#[derive(Clone, Copy)]
pub struct Quantity {
    /// Name as a key of a file; with hyphens, as a flag.
    pub key: &'static str,
    /// Names of the same quantity in the datasheets of other makers, as keys.
    pub aliases: &'static [&'static str],
    /// Its name in words.
    pub words: &'static str,
    /// Unit in datasheets, for numbers without unit.
    pub unit: &'static str,
    /// SI unit.
    pub si: &'static str,
    /// Formula of the value, for messages; empty where nothing else of a datasheet determines it.
    pub formula: &'static str,
    /// Relative standard deviation of a printed value from its formula, apart from rounding: what makers mean by the term.
    pub(super) deviation: f64,
    /// The value from the motor's constants; second argument: the rise of the winding's limit over the reference temperature.
    pub(super) of: Option<fn(&Motor, f64) -> f64>,
}

const fn printed(key: &'static str, words: &'static str, unit: &'static str, si: &'static str) -> Quantity {
    Quantity { key, aliases: &[], words, unit, si, formula: "", deviation: 0.004, of: None }
}

impl Quantity {
    const fn is(mut self, formula: &'static str, of: fn(&Motor, f64) -> f64) -> Quantity {
        self.formula = formula;
        self.of = Some(of);
        self
    }

    const fn within(mut self, deviation: f64) -> Quantity {
        self.deviation = deviation;
        self
    }

    const fn also(mut self, aliases: &'static [&'static str]) -> Quantity {
        self.aliases = aliases;
        self
    }

    /// Flags of its other names, without the two hyphens.
    pub fn other_flags(&self) -> Vec<String> {
        self.aliases.iter().map(|name| name.replace('_', "-")).collect()
    }

    /// Its flag, without the two hyphens.
    pub fn flag(&self) -> String {
        self.key.replace('_', "-")
    }
}

/// All quantities, in the order of most datasheets. Deviations: speeds and torques at an operating point contain losses of which
/// makers have their own models. Other names are those of Faulhaber, Portescap, Kollmorgen and others.
pub const QUANTITIES: &[Quantity] = &[
    printed("nominal_voltage", "nominal voltage", "V", "V")
        .is("", |m, _| m.u)
        .also(&["rated_voltage", "measuring_voltage"]),
    printed("no_load_speed", "no-load speed", "rpm", "rad/s")
        .is("(U - R I_0) / k_t", |m, _| m.speed(m.i_0))
        .within(0.008),
    printed("no_load_current", "no-load current", "mA", "A").is("", |m, _| m.i_0).also(&["idle_current"]),
    printed("nominal_speed", "nominal speed", "rpm", "rad/s")
        .is("(U - R I_N) / k_t", |m, _| m.speed(m.i_n))
        .within(0.03)
        .also(&["rated_speed"]),
    printed("nominal_torque", "nominal torque (continuous)", "mN.m", "N.m")
        .is("k_t (I_N - I_0)", |m, _| m.k_t * (m.i_n - m.i_0).max(LEAST * m.i_n))
        .within(0.04)
        .also(&["rated_torque", "continuous_torque", "max_continuous_torque", "continuous_stall_torque"]),
    printed("nominal_current", "nominal current (continuous)", "A", "A")
        .is("", |m, _| m.i_n)
        .within(0.01)
        .also(&["rated_current", "continuous_current", "max_continuous_current", "continuous_stall_current"]),
    printed("stall_torque", "stall torque", "mN.m", "N.m")
        .is("k_t U / R", |m, _| m.k_t * m.u / m.r)
        .also(&["starting_torque"]),
    printed("stall_current", "stall current", "A", "A")
        .is("U / R", |m, _| m.u / m.r)
        .also(&["starting_current"]),
    printed("terminal_resistance", "terminal resistance", "Ohm", "Ohm").is("", |m, _| m.r).also(&[
        "resistance",
        "winding_resistance",
        "armature_resistance",
        "rotor_resistance",
        "line_to_line_resistance",
    ]),
    printed("terminal_inductance", "terminal inductance", "mH", "H").is("", |m, _| m.l).also(&[
        "inductance",
        "winding_inductance",
        "armature_inductance",
        "rotor_inductance",
        "line_to_line_inductance",
    ]),
    printed("electrical_time_constant", "electrical time constant", "ms", "s")
        .is("L / R", |m, _| m.l / m.r)
        .within(0.03),
    printed("torque_constant", "torque constant", "mN.m/A", "N.m/A")
        .is("", |m, _| m.k_t)
        .also(&["torque_sensitivity"]),
    printed("back_emf_constant", "back-EMF constant", "V/krpm", "N.m/A")
        .is("k_t", |m, _| m.k_t)
        .also(&["voltage_constant"]),
    printed("current_constant", "current constant", "A/(mN.m)", "A/(N.m)").is("1 / k_t", |m, _| 1.0 / m.k_t),
    printed("motor_constant", "motor constant", "mN.m/W^0.5", "N.m/W^0.5")
        .is("k_t / sqrt(R)", |m, _| m.k_t / m.r.sqrt()),
    printed("speed_constant", "speed constant", "rpm/V", "rad/(s.V)").is("1 / k_t", |m, _| 1.0 / m.k_t),
    printed("speed_torque_gradient", "speed/torque gradient", "rpm/(mN.m)", "rad/(s.N.m)")
        .is("R / k_t^2", |m, _| m.r / (m.k_t * m.k_t))
        .within(0.006)
        .also(&["slope_of_n_m_curve"]),
    printed("motor_regulation", "motor regulation", "krad/(N.m.s)", "rad/(s.N.m)")
        .is("R / k_t^2", |m, _| m.r / (m.k_t * m.k_t))
        .within(0.006),
    printed("mechanical_time_constant", "mechanical time constant", "ms", "s")
        .is("J R / k_t^2", |m, _| m.j * m.r / (m.k_t * m.k_t))
        .within(0.006),
    printed("rotor_inertia", "rotor inertia", "g.cm2", "kg.m2")
        .is("", |m, _| m.j)
        .also(&["inertia", "moment_of_inertia"]),
    printed("angular_acceleration", "angular acceleration", "krad/s2", "rad/s2")
        .is("k_t U / (R J)", |m, _| m.k_t * m.u / (m.r * m.j))
        .within(0.02),
    printed("friction_torque", "friction torque", "mN.m", "N.m")
        .is("k_t I_0", |m, _| m.k_t * m.i_0)
        .within(0.03),
    printed("static_friction_torque", "friction torque, static", "mN.m", "N.m"),
    printed("dynamic_friction", "friction torque, dynamic", "mN.m/rpm", "N.m.s/rad")
        .also(&["viscous_damping"]),
    printed("max_efficiency", "maximum efficiency", "%", "1")
        .is("(1 - sqrt(I_0 R / U))^2", |m, _| (1.0 - (m.i_0 * m.r / m.u).min(0.96).sqrt()).powi(2))
        .within(0.006)
        .also(&["efficiency"]),
    printed("resistance_housing_ambient", "thermal resistance housing-ambient", "K/W", "K/W")
        .is("", |m, _| m.r_ha)
        .also(&["thermal_resistance_housing_ambient", "thermal_resistance_body_ambient", "rth2"]),
    printed("resistance_winding_housing", "thermal resistance winding-housing", "K/W", "K/W")
        .is("", |m, _| m.r_wh)
        .also(&["thermal_resistance_winding_housing", "thermal_resistance_rotor_body", "rth1"]),
    printed("resistance_winding_ambient", "thermal resistance winding-ambient", "K/W", "K/W")
        .is("R_wh + R_ha", |m, _| m.r_wh + m.r_ha)
        .also(&["thermal_resistance"]),
    printed("winding_time_constant", "thermal time constant of the winding", "s", "s")
        .is("C_w R_wh", |m, _| m.c_w * m.r_wh)
        .also(&["thermal_time_constant_winding", "thermal_time_constant_rotor", "tau_w1"]),
    printed("motor_time_constant", "thermal time constant of the motor", "s", "s")
        .is("(C_w + C_h) R_ha", |m, _| (m.c_w + m.c_h) * m.r_ha)
        .also(&[
            "thermal_time_constant",
            "thermal_time_constant_motor",
            "thermal_time_constant_stator",
            "tau_w2",
        ]),
    // The check uses the rise over the reference temperature.
    printed("max_winding_temperature", "maximum winding temperature", "degC", "K")
        .is("25 degC + R_hot I_N^2 (R_wh + R_ha) + k_t I_0 w_N R_ha", |m, rise| m.rise(rise))
        .within(0.08)
        .also(&["max_rotor_temperature", "max_coil_temperature"]),
    printed("reference_temperature", "reference temperature of the datasheet values", "degC", "K"),
    printed("pole_pairs", "number of pole pairs", "1", "1"),
    printed("poles", "number of poles", "1", "1").also(&["pole_number", "number_of_poles"]),
    printed("mass", "mass (weight) of the motor", "g", "kg").also(&["weight"]),
    printed("diameter", "outer diameter", "mm", "m").also(&["outer_diameter"]),
    printed("length", "length without shaft", "mm", "m").also(&["motor_length"]),
];

/// The quantity of a key or of another name.
pub fn by_key(key: &str) -> Option<&'static Quantity> {
    QUANTITIES.iter().find(|q| q.key == key || q.aliases.contains(&key))
}
