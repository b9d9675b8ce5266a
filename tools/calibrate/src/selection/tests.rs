use super::*;
use crate::setup::Setup;
use crate::testing::candidate;
use physics::terms::{Driver, Port};

/// Effects within the difference that structure error makes are alternatives, also if they alone would not be accepted.
#[test]
fn effects_that_explain_about_as_much_are_alternatives() {
    let experiment = crate::testing::experiment(crate::testing::PRIORS, true);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let of =
        |id: &str, size: f64, sure: f64| candidate(&setup, crate::testing::addition(&setup, id, size), sure);
    let point = Linearization::judged(&setup, setup.judged(setup.preset(), &[0]).unwrap(), &[0]).unwrap();
    let candidates = [
        ("windage", 1e-8, 120.0),
        ("iron_loss", 1e-6, 90.0),
        ("viscous_friction", 1e-6, 70.0),
        ("iron_loss", -1e-6, 110.0),
    ];
    let candidates = candidates.map(|(id, size, sure)| of(id, size, sure));
    assert_eq!(alike(&point, &candidates, 0), [1]);
    let law = crate::testing::law(Port::DragTorque, Follows::Driver(Driver::Speed));
    assert!(alike(&point, &[candidate(&setup, law, 120.0), of("iron_loss", 1e-6, 90.0)], 0).is_empty());
}

fn scored(name: &str, addition: Option<Addition>, evidence: f64) -> Scored {
    Scored {
        listed: addition.is_some(),
        addition,
        name: name.to_string(),
        port: Port::DragTorque,
        follows: Follows::Driver(Driver::Speed),
        evidence,
        raw: evidence + 10.0,
        shape: Vec::new(),
    }
}

/// Variants of one effect do not use up the places of others; two of them are fitted.
#[test]
fn variants_leave_room_for_other_effects() {
    let experiment = crate::testing::experiment("\"thermal.C_h\" = 0.1", true);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let windage = || Some(crate::testing::addition(&setup, "windage", 1e-8));
    let mut all: Vec<Scored> = (0..9)
        .map(|k| scored(&format!("windage in some runs (run-{k}.csv)"), windage(), 90.0 - f64::from(k)))
        .collect();
    all.extend((0..9).map(|k| scored(&format!("effect {k}"), windage(), 80.0 - f64::from(k))));
    let names: Vec<&str> = choose(&all, true).into_iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names.iter().filter(|n| n.starts_with("windage")).count(), 2, "{names:?}");
    assert_eq!(names.len() - 2, CANDIDATES[0] - 1, "{names:?}");
}

/// Candidates at one port alone are joined by the best one at another port, however far behind it is.
#[test]
fn another_port_is_tried() {
    let experiment = crate::testing::experiment("\"thermal.C_h\" = 0.1", true);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let addition = || Some(crate::testing::addition(&setup, "windage", 1e-8));
    let at = |port: Port, name: &str, sure: f64| Scored { port, ..scored(name, addition(), sure) };
    let [own, other] = [Port::WindingResistance, Port::TorqueConstant];
    let mut all = vec![at(own, "a", 900.0), at(own, "b", 800.0), at(other, "c", 40.0), at(other, "d", 60.0)];
    let names = |all: &[Scored]| choose(all, false).iter().map(|s| s.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&all), ["a", "b", "d"]);
    all.push(at(Port::HousingHeat, "e", 500.0));
    assert_eq!(names(&all), ["a", "b", "e"]);
    assert_eq!(names(&[at(own, "a", 900.0), at(other, "c", 0.5 * LEAST)]), ["a"]);
}

/// Only a general law over the same driver at the same port is a repetition.
#[test]
fn a_second_law_over_the_same_driver_is_not_looked_for() {
    let experiment = crate::testing::experiment("\"thermal.C_h\" = 0.1", true);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let listed = crate::testing::addition(&setup, "windage", 1e-8);
    let law = crate::testing::law(listed.port, listed.follows);
    let hypothesis = Hypothesis { additions: vec![law.clone()], ..setup.preset() };
    let own = scored("drag_torque over speed", None, 80.0);
    let other = Scored { follows: Follows::Driver(Driver::Current), ..own.clone() };
    let repeated = Scored { port: law.port, follows: law.follows, ..own.clone() };
    assert!(repeats(&hypothesis, &repeated) && !repeats(&hypothesis, &other));
    assert!(!repeats(&hypothesis, &Scored { listed: true, ..repeated.clone() }));
    let beside = Hypothesis { additions: vec![listed], ..setup.preset() };
    assert!(!repeats(&beside, &repeated));
}

/// Probabilities of the candidates of a round and of the model without any add up to 1; a difference of 2 ln 2 in the tempered BIC doubles
/// them.
#[test]
fn probabilities_of_a_round_add_up() {
    let failed = |delta: f64| (scored("windage", None, delta), CalibrateError(String::new()));
    let round = |deltas: &[f64]| Round {
        candidates: Vec::new(),
        taken: None,
        excuse: None,
        alike: Vec::new(),
        part: None,
        failed: deltas.iter().map(|delta| failed(*delta)).collect(),
    };
    let deltas = [2.0 * 4f64.ln() / TEMPER, 2.0 * 2f64.ln() / TEMPER, -50000.0];
    let all = round(&deltas);
    let shares: Vec<f64> = deltas.iter().map(|delta| all.probability(*delta)).collect();
    assert!((shares[0] - 4.0 / 7.0).abs() < 1e-12 && (shares[1] - 2.0 / 7.0).abs() < 1e-12, "{shares:?}");
    assert!((all.probability(0.0) + shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!((round(&[5000.0]).probability(5000.0) - 1.0).abs() < 1e-12);
}

/// Among models that are all far less probable than another one, the shares still add up to 1.
#[test]
fn shares_are_those_of_the_models_given() {
    let of = shares(&[-9000.0, -9000.0]);
    assert_eq!((of(-9000.0), of(-9000.0)), (0.5, 0.5));
}

/// A candidate that could not be fitted is listed with the reason.
#[test]
fn a_failed_candidate_is_listed() {
    let scored = scored("drag_torque over speed", None, 80.0);
    let failed = vec![(scored, CalibrateError("the step size is too small".to_string()))];
    let round =
        Round { candidates: Vec::new(), taken: None, excuse: None, alike: Vec::new(), part: None, failed };
    let candidate_table = round.candidate_table(2);
    assert_eq!((candidate_table.len(), candidate_table[0].round, candidate_table[0].delta_bic), (1, 2, 90.0));
    assert!(
        !candidate_table[0].accepted && candidate_table[0].reason.ends_with("the step size is too small")
    );
}

/// The reason of an accepted candidate says so if another one explains more; one that was refused does not count.
#[test]
fn a_preferred_candidate_does_not_explain_most() {
    let experiment = crate::testing::experiment(crate::testing::PRIORS, true);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let reason = |refused: Option<String>| {
        let law = |sure| {
            candidate(&setup, crate::testing::law(Port::DragTorque, Follows::Driver(Driver::Speed)), sure)
        };
        let candidates = vec![Candidate { refused, ..law(400.0) }, law(390.0)];
        let (alike, failed) = (Vec::new(), Vec::new());
        let round = Round { candidates, taken: Some(1), excuse: None, alike, part: None, failed };
        round.candidate_table(1).swap_remove(1).reason
    };
    assert!(reason(None).starts_with("is preferred to candidates with more evidence"), "{}", reason(None));
    assert!(reason(Some("is at a limit".to_string())).starts_with("has the largest evidence"));
}

/// A listed effect that explains little to first order, and is therefore not among the candidates, is fitted when a law at its port wins.
#[test]
fn a_law_gives_way_to_a_listed_effect_that_was_not_fitted() {
    use crate::testing::{OUTPUTS, PRIORS, driven_by};
    let mut experiment = driven_by(("current_A", 1.0, 190.0), &OUTPUTS, PRIORS, true);
    crate::testing::read_of(&mut experiment, |setup| {
        let additions = vec![crate::testing::addition(setup, "windage", 3e-8)];
        setup.change(&Hypothesis { additions, ..setup.preset() }, 0)
    });
    let setup = Setup::new(&experiment, &[]).unwrap();
    let point = Linearization::new(&setup, setup.refit(&[0]).unwrap(), &[0]).unwrap();
    let winner = |least: f64| {
        let mut scored = crate::search::search(&point);
        scored.retain(|s| s.port == Port::DragTorque);
        for own in scored.iter_mut().filter(|s| s.listed) {
            (own.evidence, own.raw) = (least, least);
        }
        let round = compete(&point, &point.fitted.hypothesis, &scored, &Known::default());
        let winner = round.winner().unwrap();
        assert!(round.candidate_table(1).iter().filter(|row| row.accepted).count() == 1);
        winner.name.clone()
    };
    assert_eq!(winner(2.0 * LEAST), "windage");
    // Below the least evidence nothing is fitted.
    assert!(winner(0.5 * LEAST).starts_with("drag_torque"), "{}", winner(0.5 * LEAST));
}

/// The zeros of a current differ between two runs by less than its noise. At rest a contact drop, whose slope at zero is steep, turns them into
/// voltages that were not measured: a table of the current, which is flat there, would explain more.
#[test]
fn a_contact_drop_is_named_although_the_current_has_a_zero() {
    use crate::testing::{OUTPUTS, PRIORS, driven_by, normal, read_of, rng};
    const SIGMA: f64 = 0.02;
    let mut experiment = driven_by(("current_A", 1.0, 190.0), &OUTPUTS, PRIORS, true);
    for (row, current) in experiment.runs[0].table.columns[0].iter_mut().enumerate() {
        *current *= f64::from(u8::from(row % 100 >= 45));
    }
    experiment.runs.push(experiment.runs[0].clone());
    experiment.noise.extend([("current_A", SIGMA), ("voltage_V", SIGMA)]);
    read_of(&mut experiment, |setup| {
        let additions = vec![crate::testing::addition(setup, "contact_drop", 0.6)];
        setup.change(&Hypothesis { additions, ..setup.preset() }, 0)
    });
    let (mut rng, voltage) = (rng(8), experiment.inputs.len());
    for (run, zero) in experiment.runs.iter_mut().zip([0.7, -0.7]) {
        run.table.columns[0].iter_mut().for_each(|i| *i += SIGMA * (zero + normal(&mut rng)));
        run.table.columns[voltage].iter_mut().for_each(|v| *v += SIGMA * normal(&mut rng));
    }
    let setup = Setup::new(&experiment, &[]).unwrap();
    let point = Linearization::new(&setup, setup.refit(&[0, 1]).unwrap(), &[0, 1]).unwrap();
    let scored = crate::search::search(&point);
    let round = compete(&point, &point.fitted.hypothesis, &scored, &Known::default());
    let table: Vec<_> =
        round.candidate_table(1).into_iter().map(|c| (c.name, c.delta_bic_whitened)).collect();
    assert_eq!(round.winner().unwrap().name, "contact_drop", "{table:?}");
}
