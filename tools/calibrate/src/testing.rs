//! Experiments with readings simulated by the model itself, for tests.

use crate::experiment::{Experiment, Start};
use crate::hypothesis::{Addition, Hypothesis, Shape};
use crate::linearization::Linearization;
use crate::outcome::Follows;
use crate::overrides::Override;
use crate::selection::Candidate;
use crate::setup::Setup;
use physics::terms::{Factor, GenericTerm, Port};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Noise stated in the experiment, in the channels' units: negligible.
pub const NOISE: f64 = 1e-3;

/// Columns of all outputs.
pub const OUTPUTS: [&str; 4] =
    ["voltage_V", "shaft_torque_Nm", "winding_temperature_degC", "housing_temperature_degC"];

/// Priors of three parameters that every run determines.
pub const PRIORS: &str = "\"motor.R_ref\" = 0.03\n\"motor.k_t\" = 0.02\n\"conductance.G_still\" = 0.1";

/// One run of 300 rows of 5 s with varying load, speed and fan; constant inputs if `wild` is false. Without readings.
pub fn experiment(priors: &str, wild: bool) -> Experiment {
    driven_by(("current_A", 1.0, 90.0), &OUTPUTS, priors, wild)
}

/// The same with a column for the drive, one ampere in this column's unit, the period of the speed over 2 pi in s, and output columns.
pub fn driven_by(
    (drive, factor, period): (&str, f64, f64),
    outputs: &[&str],
    priors: &str,
    wild: bool,
) -> Experiment {
    let folder = tempfile::tempdir().unwrap();
    let mut rows = format!("time_s,{drive},speed_rad_per_s,fan_command_1,ambient_temperature_degC,");
    rows.push_str(&format!("{}\n", outputs.join(",")));
    let blank = ",".repeat(outputs.len());
    for k in 0..300 {
        let t = 5.0 * f64::from(k);
        let turn = |period: f64| if wild { (t / period).sin() } else { 0.5 };
        let fan = if wild && k > 200 { 0.6 } else { 0.0 };
        let (load, speed) = (factor * (3.0 + 2.0 * turn(90.0)), 300.0 + 200.0 * turn(period));
        rows.push_str(&format!("{t},{load},{speed},{fan},23{blank}\n"));
    }
    std::fs::write(folder.path().join("run.csv"), rows).unwrap();
    let noise: String = outputs.iter().map(|o| format!("{o} = {NOISE}\n")).collect();
    let text = format!(
        "[experiment]\nname = \"t\"\nmodel = \"AnnulusCooledMotor\"\npreset = \"maxon-305015\"\n\
         inputs = [\"{drive}\", \"speed_rad_per_s\", \"fan_command_1\", \"ambient_temperature_degC\"]\n\
         outputs = [\"{}\"]\n[set]\ncooling_mode = \"conductance\"\n\
         \"effect.coulomb_friction.tau_c\" = 0.005\n[prior]\n{priors}\n[noise]\n{noise}\n\
         [[run]]\nfile = \"run.csv\"\nrole = \"fit\"\n",
        outputs.join("\", \"")
    );
    std::fs::write(folder.path().join("e.toml"), text).unwrap();
    Experiment::read(&folder.path().join("e.toml")).unwrap()
}

/// Readings of the preset's motor with a term, with [`PRIORS`]. The period of the speed is not that of the current.
pub fn with_term(term: GenericTerm) -> Experiment {
    let mut experiment = driven_by(("current_A", 1.0, 190.0), &OUTPUTS, PRIORS, true);
    let preset = Setup::new(&experiment, &[]).unwrap().preset().declared;
    read(&mut experiment, &preset, Some(term));
    experiment
}

/// The same with these priors, a lag that starts `above` its driver, and noise of the temperatures, K: a run that starts warm.
pub fn with_warm_term(priors: &str, term: GenericTerm, above: f64, noise: f64) -> Experiment {
    let mut experiment = driven_by(("current_A", 1.0, 190.0), &OUTPUTS, priors, true);
    read_of(&mut experiment, |setup| {
        let slot = setup.bench.declaration().by_name("initial.term_lag_1").unwrap().slot;
        let mut change = setup.change(&setup.preset(), 0);
        change.values.push((slot, above));
        change.terms.push(term);
        change
    });
    let mut rng = rng(5);
    for output in [2, 3] {
        let column = experiment.place_of(output);
        for value in &mut experiment.runs[0].table.columns[column] {
            *value += noise * normal(&mut rng);
        }
    }
    experiment.runs[0].start = Start::Measured;
    experiment
}

/// Fills the run with readings simulated with these parameters and a term.
pub fn read(experiment: &mut Experiment, declared: &[f64], term: Option<GenericTerm>) {
    read_of(experiment, |setup| {
        let truth = Hypothesis { declared: declared.to_vec(), additions: Vec::new() };
        let mut change = setup.change(&truth, 0);
        change.terms.extend(term);
        change
    });
}

/// Fills the run with readings simulated with a change.
pub fn read_of(experiment: &mut Experiment, change: impl Fn(&Setup) -> Override) {
    let all: Vec<Vec<Vec<f64>>> = {
        let setup = Setup::new(experiment, &[]).unwrap().exact();
        setup.drives.iter().map(|drive| setup.bench.run(drive, &change(&setup)).unwrap()).collect()
    };
    let inputs = experiment.inputs.len();
    for (run, columns) in experiment.runs.iter_mut().zip(all) {
        run.table.columns.splice(inputs.., columns);
    }
}

/// Listed effect with its size.
pub fn addition(setup: &Setup, id: &str, size: f64) -> Addition {
    let listed = crate::catalogue::LISTED.iter().find(|l| l.id == id).unwrap();
    let mut addition = listed.addition(setup, &vec![true; setup.experiment.runs.len()]).unwrap();
    addition.numbers[0].value = size;
    addition
}

/// The preset with an addition, as a candidate with this reduction of the cost.
pub fn candidate<'a>(setup: &'a Setup<'a>, addition: Addition, sure: f64) -> Candidate<'a> {
    let fitted = setup.judged(setup.preset(), &[0]).unwrap();
    let mut point = Linearization::judged(setup, fitted, &[0]).unwrap();
    point.fitted.hypothesis.additions.push(addition);
    let (delta, name) = ((sure, sure + 10.0), String::new());
    Candidate { name, point, delta, delta_validation: None, validation: None, refused: None }
}

/// Linear law at a port, without numbers; `follows` is what is said of it.
pub fn law(port: Port, follows: Follows) -> Addition {
    let driver = follows.drivers().next().unwrap();
    let factor = Factor { driver, offset: 0.0, reference: 1.0, exponent: 1.0, range: Factor::UNLIMITED };
    Addition {
        id: "generic_term".to_string(),
        port,
        follows,
        shape: Shape::Power { factor },
        numbers: Vec::new(),
        active: Vec::new(),
    }
}

/// Random number generator; the sequence for a seed is the same on every machine.
pub fn rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// Approximately normal random number of mean 0 and standard deviation 1: sum of twelve uniform ones.
pub fn normal(rng: &mut Pcg64Mcg) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}
