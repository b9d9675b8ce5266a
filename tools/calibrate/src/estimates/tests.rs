//! Intervals of the estimates, and what is said of a file that disagrees.

use super::*;
use crate::hypothesis::Addition;
use crate::outcome::Follows;
use crate::testing;
use physics::terms::Driver;

const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// An interval covers the exported value as widely as the estimate, also if they differ.
#[test]
fn intervals_are_those_of_either_estimate() {
    assert_eq!(of_either(3.0, (2.0, 4.0), FREE), (2.0, 4.0));
    assert_eq!(of_either(6.0, (2.0, 4.0), FREE), (2.0, 7.0));
    assert_eq!(of_either(3.5, (2.0, 4.0), (0.0, 4.2)), (2.0, 4.2));
    // At a limit it has one side.
    assert_eq!(of_either(0.0, (0.0, 1.0), (0.0, 9.0)), (0.0, 1.0));
}

/// At a limit, the interval ends where the parabola about the unconstrained optimum has risen by 1.96^2 squared deviations.
#[test]
fn intervals_end_at_limits_and_follow_the_profile_there() {
    assert_eq!(interval(3.0, 0.0, 2.0, FREE), (1.0, 5.0));
    assert_eq!(interval(1.0, 0.0, 2.0, (0.0, 9.0)), (0.0, 3.0));
    // Optimum at -1.5: from 0 to 1 the parabola rises from 1.5^2 to 2.5^2, by 2^2.
    assert_eq!(interval(0.0, -1.5, 2.0, (0.0, 9.0)), (0.0, 1.0));
    assert_eq!(interval(9.0, 1.5, 2.0, (0.0, 9.0)), (8.0, 9.0));
    // Optimum at the limit itself: one half of the normal interval.
    assert_eq!(interval(0.0, 0.0, 2.0, (0.0, 9.0)), (0.0, 2.0));
}

/// A file that disagrees with the parameters of the others is not reported if the final model describes it with effects of all runs.
#[test]
fn an_odd_file_is_reported_unless_an_effect_of_all_runs_describes_it() {
    let errors = |role, after| {
        let prediction = Prediction { half_width: 2.0, inside: 0.95 };
        let column = "voltage_V";
        let (before, refit, floor, instruments) = (9.0, 5.0, 1.0, 0.5);
        [ChannelError { role, column, before, refit, after, floor, instruments, blackbox: None, prediction }]
    };
    let of_all = testing::law(Port::DragTorque, Follows::Driver(Driver::Speed));
    let of_none = Addition { active: vec![false], ..of_all.clone() };
    let found = |addition: &Addition| Hypothesis { declared: Vec::new(), additions: vec![addition.clone()] };
    let is_said =
        |addition: &Addition, role, after| !describes_all_runs(&found(addition), &errors(role, after));
    assert!(is_said(&of_all, Role::Fit, 4.0) && is_said(&of_all, Role::Validate, 4.0));
    assert!(!is_said(&of_all, Role::Fit, 1.01) && !is_said(&of_all, Role::Test, 4.0));
    assert!(is_said(&of_none, Role::Fit, 1.01));
}
