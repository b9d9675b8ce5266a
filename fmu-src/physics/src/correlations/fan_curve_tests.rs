//! Tests of the fan curve: data sheets, affinity laws, invalid curves, operating points with analytical solutions.

use super::*;
use crate::correlations::checks::{close, continuous};

const FLOW: [f64; 4] = [0.0, 0.001, 0.003, 0.0047];
const PRESSURE: [f64; 4] = [70.0, 50.0, 30.0, 0.0];

fn ends() -> FanCurve<'static> {
    FanCurve::new(Shape::EndPoints { flow_max: 0.004672, pressure_max: 62.27 }, None).unwrap()
}

fn table() -> FanCurve<'static> {
    FanCurve::new(Shape::Table { flow: &FLOW, pressure: &PRESSURE }, None).unwrap()
}

/// The CUI CFM-40V family at 12 V, one fan at three speeds, by its data sheet: 5800 min-1 3.304 L/s 29.89 Pa,
/// 7000 min-1 3.776 L/s 47.33 Pa, 8500 min-1 4.672 L/s 62.27 Pa. Real fans follow the affinity laws within 15 %
/// (the sheet rounds 0.12 inH2O); the thesis's family within 0.3 %: 8300 to 6400 min-1 from 7.24 to 4.29
/// mmH2O. The test fails for a pressure with n instead of n^2.
#[test]
fn data_sheets_follow_the_affinity_laws() {
    for (speed, flow, pressure) in [(5800.0, 0.003304, 29.89), (7000.0, 0.003776, 47.33)] {
        let n = speed / 8500.0;
        close(ends().pressure(0.0, n, 1.0), pressure, 0.15);
        close(ends().free_flow() * n, flow, 0.05);
    }
    let thesis_fan =
        FanCurve::new(Shape::EndPoints { flow_max: 0.28 / 60.0, pressure_max: 7.24 }, None).unwrap();
    close(thesis_fan.pressure(0.0, 6400.0 / 8300.0, 1.0), 4.29, 4e-3);
}

#[test]
fn ends_table_and_its_continuation() {
    assert_eq!(ends().pressure(0.0, 1.0, 1.0), 62.27);
    close(ends().pressure(0.002336, 1.0, 1.0), 31.135, 1e-12);
    for (q, p) in FLOW.into_iter().zip(PRESSURE) {
        assert!((table().pressure(q, 1.0, 1.0) - p).abs() < 1e-12);
    }
    close(table().pressure(0.002, 1.0, 1.0), 40.0, 1e-12);
    close(table().pressure(-0.001, 1.0, 1.0), 90.0, 1e-12);
    assert!(table().pressure(0.005, 1.0, 1.0) < 0.0);
    assert_eq!(table().pressure(0.001, 0.0, 1.0), 0.0);
    close(table().pressure(0.001, 1.0, 0.8), 40.0, 1e-12);
    for q in FLOW.into_iter().take(3) {
        continuous(|q| table().pressure(q, 1.0, 1.0), q);
    }
}

#[test]
fn a_curve_that_does_not_fall_is_refused_in_one_sentence() {
    let refused = |flow: &[f64], pressure: &[f64]| {
        FanCurve::new(Shape::Table { flow, pressure }, None).unwrap_err().to_string()
    };
    assert_eq!(
        refused(&[0.0, 0.001, 0.002], &[50.0, 55.0, 0.0]),
        "the fan curve must fall, but its pressure goes from 50 Pa at point 1 to 55 Pa at the next"
    );
    assert!(refused(&[0.0, 0.002, 0.002], &[50.0, 20.0, 0.0]).contains("point 2 has 0.002 m3/s"));
    assert!(refused(&[0.0, 0.002], &[50.0]).contains("2 flows and 1 pressures"));
    assert!(refused(&[], &[]).contains("0 flows"));
    assert!(refused(&[0.0, f64::NAN], &[50.0, 0.0]).contains("flow is NaN"));
    assert!(refused(&[0.001, 0.002], &[50.0, 0.0]).contains("starts at 0.001 m3/s"));
    let error = FanCurve::new(Shape::EndPoints { flow_max: 0.0, pressure_max: 50.0 }, None).unwrap_err();
    assert_eq!(error.to_string(), "the fan curve's free flow is 0; it must be finite and positive");
    let stall = Some(Stall { depth: -1.0, centre: 0.4, width: 0.1 });
    assert!(FanCurve::new(Shape::EndPoints { flow_max: 1.0, pressure_max: 1.0 }, stall).is_err());
}

/// System c Q^2 and a straight curve: c Q^2 + (p/q) Q - p = 0, solved by the quadratic formula.
#[test]
fn operating_point_on_a_parabola_by_hand() {
    let (q, p) = (0.004672, 62.27);
    for c in [1e4, 1e6, 3e6, 1e9f64] {
        let slope = p / q;
        let exact = 2.0 * p / (slope + (slope * slope + 4.0 * c * p).sqrt());
        close(ends().operating_flow(1.0, 1.0, |q| c * q * q), exact, 1e-11);
    }
    // A quadratic system keeps its relative operating point: the flow is proportional to n at any density (both ~ rho).
    let full = table().operating_flow(1.0, 1.0, |q| 3e6 * q * q);
    close(table().operating_flow(0.5, 0.8, |q| 0.8 * 3e6 * q * q), 0.5 * full, 1e-11);
}

#[test]
fn extremes_of_the_system() {
    assert_eq!(ends().operating_flow(1.0, 1.0, |_| 0.0), 0.004672);
    // A system that drives the fan: 62.27 (1 - Q/0.004672) = -5.
    close(ends().operating_flow(1.0, 1.0, |_| -5.0), 0.004672 * (1.0 + 5.0 / 62.27), 1e-11);
    assert_eq!(ends().operating_flow(0.0, 1.0, |q| q), 0.0);
    assert_eq!(ends().operating_flow(1.0, 1.0, |_| 1e9), 0.0);
    assert!(ends().operating_flow(1.0, 1.0, |q| 1e30 * q) < 1e-20);
    assert!(ends().operating_flow(1.0, 1.0, |_| f64::NAN).is_finite());
    for n in [1e-6, 1e-3, 1e300] {
        let flow = ends().operating_flow(n, 1.0, |q| 1e6 * q * q);
        assert!(flow.is_finite() && flow >= 0.0);
    }
}

#[test]
fn flow_rises_smoothly_with_the_speed_from_rest() {
    let mut last = 0.0;
    for k in 1..=1000 {
        let n = f64::from(k) * 1e-3;
        let flow = table().operating_flow(n, 1.0, |q| 2e6 * q * q + 3e3 * q);
        assert!(flow > last && flow - last < 1e-5);
        last = flow;
    }
}

/// A straight curve with a dip in the middle has three crossings with a steep system; the one with the largest flow is used.
#[test]
fn stall_dips_and_the_outer_branch_is_taken() {
    let stall = Some(Stall { depth: 0.4, centre: 0.4, width: 0.08 });
    let curve = FanCurve::new(Shape::EndPoints { flow_max: 1.0, pressure_max: 1.0 }, stall).unwrap();
    close(curve.pressure(0.4, 1.0, 1.0), 0.6 * 0.6, 1e-12);
    close(curve.pressure(0.9, 1.0, 1.0), 0.1, 1e-9);
    assert!(curve.pressure(0.5, 1.0, 1.0) > curve.pressure(0.4, 1.0, 1.0));
    let system = |q: f64| 0.9 * q;
    let flow = curve.operating_flow(1.0, 1.0, system);
    assert!((curve.pressure(flow, 1.0, 1.0) - system(flow)).abs() < 1e-11);
    assert!(flow > 0.5, "{flow}");
    let plain = Stall { depth: 0.0, centre: 0.4, width: 0.0 };
    let plain = FanCurve::new(Shape::EndPoints { flow_max: 1.0, pressure_max: 1.0 }, Some(plain)).unwrap();
    close(plain.operating_flow(1.0, 1.0, system), 1.0 / 1.9, 1e-12);
}
