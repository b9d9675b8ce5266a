//! Closed-form solutions compared with a time simulation of the circuit.

use super::*;
use num_dual::Dual64;

const R: f64 = 9.2;
const L: f64 = 1.803e-3;
const SUPPLY: f64 = 12.0;

fn drive(pwm_frequency: f64, decay: Decay) -> Drive {
    Drive { drop: 2.2, freewheel_drop: 1.4, pwm_frequency, decay, zero_duty: ZeroDuty::Coast }
}

/// Means over a cycle.
#[derive(Debug)]
struct Means {
    current: f64,
    square: f64,
    voltage: f64,
    supply_power: f64,
    loss: f64,
}

/// Simulates the switched circuit with an ideal diode by the midpoint rule until the cycle is periodic.
fn switched(drive: &Drive, duty: f64, e: f64) -> Means {
    let (forward, e, duty) = if duty < 0.0 { (-1.0, -e, -duty) } else { (1.0, e, duty) };
    let period = 1.0 / drive.pwm_frequency;
    let n = 20_000;
    let h = period / f64::from(n);
    let returned = if drive.decay == Decay::Fast { 1.0 } else { 0.0 };
    let off = drive.freewheel_drop + returned * SUPPLY;
    let cycles = 2 + (12.0 * L / R / period) as usize;
    let mut i = 0.0f64;
    let mut m = Means { current: 0.0, square: 0.0, voltage: 0.0, supply_power: 0.0, loss: 0.0 };
    for cycle in 0..cycles {
        for k in 0..n {
            let on = (f64::from(k) + 0.5) / f64::from(n) < duty;
            let v = if on { SUPPLY - drive.drop } else { -off };
            let rate = |i: f64| (v - e - R * i) / L;
            let next = (i + h * rate(i + 0.5 * h * rate(i))).max(0.0);
            if cycle == cycles - 1 {
                let (mean, share) = (0.5 * (i + next), 1.0 / f64::from(n));
                m.current += share * mean;
                m.square += share * (i * i + i * next + next * next) / 3.0;
                m.voltage += share * if mean > 0.0 { v } else { e };
                m.supply_power += share * mean * SUPPLY * if on { 1.0 } else { -returned };
                m.loss += share * mean * if on { drive.drop } else { drive.freewheel_drop };
            }
            i = next;
        }
    }
    (m.current, m.voltage) = (forward * m.current, forward * m.voltage);
    m
}

fn close(found: f64, wanted: f64, size: f64, what: &str) {
    assert!((found - wanted).abs() <= 3e-4 * size, "{what}: {found} and {wanted}");
}

#[test]
fn the_means_are_those_of_the_switched_circuit() {
    let mut seen = [0; 2];
    for decay in [Decay::Slow, Decay::Fast] {
        for frequency in [490.0, 1775.0, 20e3] {
            for duty in [0.1, 0.35, 0.8, 1.0, -0.6] {
                for e in [-16.0, -3.0, 0.0, 2.0, 7.0, 9.5] {
                    let drive = drive(frequency, decay);
                    let m = switched(&drive, duty, e);
                    let bridge = Bridge::new(&drive, duty, duty, SUPPLY);
                    let cycle = bridge.cycle(e, R, L);
                    if e * duty.signum() > SUPPLY + drive.freewheel_drop {
                        continue; // rectifies: the circuit above has a single direction
                    }
                    let i = cycle.drive / R;
                    let what = format!("{decay:?} {frequency} Hz duty {duty} e {e}");
                    close(i, m.current, 1.0, &what);
                    close(i * i + cycle.ripple, m.square, 1.0, &what);
                    if i != 0.0 {
                        close(e + cycle.drive, m.voltage, 10.0, &what);
                    }
                    let power = R * (i * i + cycle.ripple) + e * i;
                    close(bridge.loss(&cycle, power, i), m.loss, 10.0, &what);
                    let supply = bridge.supply_power(&cycle);
                    close(supply.per_watt * power + supply.per_ampere * i, m.supply_power, 10.0, &what);
                    seen[usize::from(cycle.conducting == 1.0)] += 1;
                }
            }
        }
    }
    assert!(seen[0] > 20 && seen[1] > 20, "both kinds of conduction: {seen:?}");
}

/// All means are continuous at the boundary between continuous and discontinuous conduction.
#[test]
fn continuous_across_the_border_of_conduction() {
    for decay in [Decay::Slow, Decay::Fast] {
        for frequency in [490.0, 1775.0, 5e3] {
            let drive = drive(frequency, decay);
            let at = |duty: f64| -> Cycle<f64> { Bridge::new(&drive, duty, 1.0, SUPPLY).cycle(5.0, R, L) };
            let (mut low, mut high) = (0.01, 1.0);
            while high - low > 1e-12 {
                let middle = 0.5 * (low + high);
                if at(middle).conducting < 1.0 { low = middle } else { high = middle }
            }
            let (below, above) = (at(low), at(high));
            assert!(low > 0.02 && high < 0.999 && above.drive > 0.0, "{decay:?} {frequency} Hz: {low}");
            assert!((below.drive - above.drive).abs() <= 1e-9 * above.drive, "{below:?} {above:?}");
            assert!((below.ripple - above.ripple).abs() <= 1e-9 * above.ripple, "{below:?} {above:?}");
        }
    }
}

/// Fully on, the bridge is the supply minus the drop; fully off, it is open.
#[test]
fn the_ends_of_the_duty() {
    let drive = drive(1775.0, Decay::Slow);
    let cycle: Cycle<f64> = Bridge::new(&drive, 1.0, 1.0, SUPPLY).cycle(4.0, R, L);
    assert!((cycle.drive - (SUPPLY - 2.2 - 4.0)).abs() < 1e-14 && cycle.ripple < 1e-15, "{cycle:?}");
    for e in [-13.0, 0.0, 13.0] {
        let cycle: Cycle<f64> = Bridge::new(&drive, 0.0, 0.0, SUPPLY).cycle(e, R, L);
        assert_eq!((cycle.drive, cycle.ripple), (0.0, 0.0), "{e}");
    }
    // Above supply voltage plus diode drop an open bridge rectifies, for both signs.
    for (e, volts) in [(15.0, -1.6), (-15.0, 1.6)] {
        let bridge = Bridge::new(&drive, 0.0, 0.0, SUPPLY);
        let cycle: Cycle<f64> = bridge.cycle(e, R, L);
        assert!((cycle.drive - volts).abs() < 1e-12, "{cycle:?}");
        let i = cycle.drive / R;
        let power = R * i * i + e * i;
        let supply = bridge.supply_power(&cycle);
        let taken = supply.per_watt * power + supply.per_ampere * i;
        assert!((taken + SUPPLY * i.abs()).abs() < 1e-12, "{taken}");
        assert!((bridge.loss(&cycle, power, i) - 1.4 * i.abs()).abs() < 1e-12);
    }
}

/// At 200 kHz the ripple is negligible: d V_on - (1 - d) V_off, Kirchhoff's law.
#[test]
fn continuous_conduction_is_kirchhoffs_law() {
    let drive = drive(200e3, Decay::Slow);
    let cycle: Cycle<f64> = Bridge::new(&drive, 0.5, 1.0, SUPPLY).cycle(2.0, R, L);
    assert!((cycle.drive - (0.5 * 9.8 - 0.5 * 1.4 - 2.0)).abs() < 1e-14);
    assert!(cycle.ripple < 2e-4 * (cycle.drive / R).powi(2));
    assert_eq!(cycle.conducting, 1.0);
}

/// The derivative for the integrator's linearisation is correct in every regime.
#[test]
fn the_slope_is_the_derivative() {
    for decay in [Decay::Slow, Decay::Fast] {
        for (duty, e) in [(0.3, 5.0), (0.9, 1.0), (-0.3, 2.0), (0.5, 11.0), (0.5, 16.0), (0.4, -20.0)] {
            let bridge = Bridge::new(&drive(1775.0, decay), duty, duty, SUPPLY);
            let slope = bridge.cycle(Dual64::from(e).derivative(), R, L).drive.eps;
            let at = |e: f64| bridge.cycle(e, R, L).drive;
            let difference = (at(e + 1e-5) - at(e - 1e-5)) / 2e-5;
            assert!((slope - difference).abs() < 1e-6, "{decay:?} {duty} {e}: {slope} {difference}");
        }
    }
}
