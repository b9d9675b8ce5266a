//! Liquid water near atmospheric pressure with temperature-dependent properties.
//!
//! rho = (999.83952 + 16.945176 t - 7.9870401e-3 t^2 - 46.170461e-6 t^3 + 105.56302e-9 t^4
//!        - 280.54253e-12 t^5) / (1 + 16.879850e-3 t),   t in degC                          (1)
//! mu  = 1e-6 (280.68 x^-1.9 + 511.45 x^-7.7 + 61.131 x^-19.6 + 0.45903 x^-40),   x = T/300 K (2)
//! k   = 0.80201 x^-0.32 - 0.25992 x^-5.7 + 0.10024 x^-12 - 0.032005 x^-15                  (3)
//! c_p = polynomial of degree 5 in T - 320 K                                                (4)
//!
//! *Assumes* pure water. *Neglects* additives: a mixture with 30 % of glycol has 20 % less conductivity and twice the viscosity.
//! *Range*: 273.16 to 380 K; the temperature is limited to this range. (1) within 0.01 %, (2) 1 %, (3) 2 %, (4) 0.1 %.
//! *Source*: (1) Kell, J. Chem. Eng. Data 20 (1975) 97-105; (2), (3) Patek et al., J. Phys. Chem. Ref. Data 38 (2009) 21-29
//! (IAPWS SR6-08); (4) fitted here to the saturated liquid in Perry's handbook, 9th ed., table 2-135.

/// Water at one temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// Density, kg/m3.
    pub rho: f64,
    /// Specific heat at constant pressure, J/(kg.K).
    pub c_p: f64,
    /// Dynamic viscosity, Pa.s.
    pub mu: f64,
    /// Thermal conductivity, W/(m.K).
    pub k: f64,
    /// Prandtl number.
    pub pr: f64,
}

/// Coefficients of (4), J/(kg.K^(n+1)).
const SPECIFIC_HEAT: [f64; 6] =
    [4_180.911_13, 0.236_391_842, 7.681_834_62e-3, -9.565_998_33e-5, 3.450_422_53e-6, -2.932_540_93e-8];

impl Water {
    /// Water at `t` kelvin.
    pub fn at(t: f64) -> Water {
        let t = t.clamp(273.16, 380.0);
        let horner = |all: &[f64], x: f64| all.iter().rev().fold(0.0, |sum, c| sum * x + c);
        let celsius = t - 273.15;
        let volume =
            [999.839_52, 16.945_176, -7.987_040_1e-3, -46.170_461e-6, 105.563_02e-9, -280.542_53e-12];
        let x = t / 300.0;
        let mu =
            280.68 * x.powf(-1.9) + 511.45 * x.powf(-7.7) + 61.131 * x.powf(-19.6) + 0.459_03 * x.powi(-40);
        let k = 0.802_01 * x.powf(-0.32) - 0.259_92 * x.powf(-5.7) + 0.100_24 * x.powi(-12)
            - 0.032_005 * x.powi(-15);
        let (mu, c_p) = (1e-6 * mu, horner(&SPECIFIC_HEAT, t - 320.0));
        Water { rho: horner(&volume, celsius) / (1.0 + 16.879_85e-3 * celsius), c_p, mu, k, pr: mu * c_p / k }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlations::checks::close;

    /// Perry's handbook, 9th ed., table 2-135 (saturated liquid): T, mol/dm3, J/(mol.K), mW/(m.K), uPa.s.
    #[test]
    fn the_table_of_the_handbook() {
        const ROWS: [[f64; 5]; 6] = [
            [273.16, 55.497, 76.023, 561.04, 1791.2],
            [290.0, 55.440, 75.429, 592.73, 1084.0],
            [300.0, 55.315, 75.320, 610.28, 853.84],
            [320.0, 54.919, 75.317, 639.71, 577.02],
            [350.0, 54.049, 75.567, 668.00, 368.77],
            [370.0, 53.321, 75.883, 678.02, 291.36],
        ];
        const MOLAR: f64 = 18.015_268e-3;
        for [t, rho, c_p, k, mu] in ROWS {
            let water = Water::at(t);
            close(water.rho, rho * 1e3 * MOLAR, 2e-4);
            close(water.c_p, c_p / MOLAR, 1e-3);
            close(water.k, k * 1e-3, 0.01);
            close(water.mu, mu * 1e-6, 0.01);
        }
        close(Water::at(300.0).pr, 5.85, 0.01);
    }

    #[test]
    fn outside_the_range_the_limit_holds() {
        assert_eq!(Water::at(0.0), Water::at(273.16));
        assert_eq!(Water::at(1e4), Water::at(380.0));
    }
}
