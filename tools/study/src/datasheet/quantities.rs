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
    Quantity { key, words, unit, si, formula: "", deviation: 0.004, of: None }
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

    /// Its flag, without the two hyphens.
    pub fn flag(&self) -> String {
        self.key.replace('_', "-")
    }
}

/// All quantities, in the order of most datasheets. Deviations: speeds and torques at an operating point contain losses of which
/// makers have their own models.
pub const QUANTITIES: &[Quantity] = &[
    printed("nominal_voltage", "nominal voltage", "V", "V").is("", |m, _| m.u),
    printed("no_load_speed", "no-load speed", "rpm", "rad/s")
        .is("(U - R I_0) / k_t", |m, _| m.speed(m.i_0))
        .within(0.008),
    printed("no_load_current", "no-load current", "mA", "A").is("", |m, _| m.i_0),
    printed("nominal_speed", "nominal speed", "rpm", "rad/s")
        .is("(U - R I_N) / k_t", |m, _| m.speed(m.i_n))
        .within(0.03),
    printed("nominal_torque", "nominal torque (continuous)", "mN.m", "N.m")
        .is("k_t (I_N - I_0)", |m, _| m.k_t * (m.i_n - m.i_0).max(LEAST * m.i_n))
        .within(0.04),
    printed("nominal_current", "nominal current (continuous)", "A", "A").is("", |m, _| m.i_n).within(0.01),
    printed("stall_torque", "stall torque", "mN.m", "N.m").is("k_t U / R", |m, _| m.k_t * m.u / m.r),
    printed("stall_current", "stall current", "A", "A").is("U / R", |m, _| m.u / m.r),
    printed("terminal_resistance", "terminal resistance", "Ohm", "Ohm").is("", |m, _| m.r),
    printed("terminal_inductance", "terminal inductance", "mH", "H").is("", |m, _| m.l),
    printed("electrical_time_constant", "electrical time constant", "ms", "s")
        .is("L / R", |m, _| m.l / m.r)
        .within(0.03),
    printed("torque_constant", "torque constant", "mN.m/A", "N.m/A").is("", |m, _| m.k_t),
    printed("speed_constant", "speed constant", "rpm/V", "rad/(s.V)").is("1 / k_t", |m, _| 1.0 / m.k_t),
    printed("speed_torque_gradient", "speed/torque gradient", "rpm/(mN.m)", "rad/(s.N.m)")
        .is("R / k_t^2", |m, _| m.r / (m.k_t * m.k_t))
        .within(0.006),
    printed("mechanical_time_constant", "mechanical time constant", "ms", "s")
        .is("J R / k_t^2", |m, _| m.j * m.r / (m.k_t * m.k_t))
        .within(0.006),
    printed("rotor_inertia", "rotor inertia", "g.cm2", "kg.m2").is("", |m, _| m.j),
    printed("max_efficiency", "maximum efficiency", "%", "1")
        .is("(1 - sqrt(I_0 R / U))^2", |m, _| (1.0 - (m.i_0 * m.r / m.u).min(0.96).sqrt()).powi(2))
        .within(0.006),
    printed("resistance_housing_ambient", "thermal resistance housing-ambient", "K/W", "K/W")
        .is("", |m, _| m.r_ha),
    printed("resistance_winding_housing", "thermal resistance winding-housing", "K/W", "K/W")
        .is("", |m, _| m.r_wh),
    printed("winding_time_constant", "thermal time constant of the winding", "s", "s")
        .is("C_w R_wh", |m, _| m.c_w * m.r_wh),
    printed("motor_time_constant", "thermal time constant of the motor", "s", "s")
        .is("(C_w + C_h) R_ha", |m, _| (m.c_w + m.c_h) * m.r_ha),
    // The check uses the rise over the reference temperature.
    printed("max_winding_temperature", "maximum winding temperature", "degC", "K")
        .is("25 degC + R_hot I_N^2 (R_wh + R_ha) + k_t I_0 w_N R_ha", |m, rise| m.rise(rise))
        .within(0.08),
    printed("reference_temperature", "temperature of the printed values", "degC", "K"),
    printed("pole_pairs", "number of pole pairs", "1", "1"),
    printed("mass", "mass (weight) of the motor", "g", "kg"),
    printed("diameter", "outer diameter", "mm", "m"),
    printed("length", "length without shaft", "mm", "m"),
];

/// The quantity of a key.
pub fn by_key(key: &str) -> Option<&'static Quantity> {
    QUANTITIES.iter().find(|q| q.key == key)
}
