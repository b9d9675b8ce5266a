//! Starts of runs.

use super::*;

fn named(model: &str, known: &[(&str, f64)]) -> Vec<(String, f64)> {
    let declaration = (physics::models::by_name(model).unwrap().declaration)();
    let name = |slot: Slot| declaration.entries.iter().find(|e| e.slot == slot).unwrap().name.clone();
    temperatures(&nodes(declaration), known).into_iter().map(|(slot, value)| (name(slot), value)).collect()
}

/// A motor that is running in the first row starts with the current of that row, unless `[set]` states another one.
#[test]
fn a_running_motor_does_not_start_at_rest() {
    let mut running = crate::testing::driven_by(("voltage_V", 1.0, 90.0), &["current_A"], "", true);
    let column = running.inputs.len();
    let start = |experiment: &Experiment| {
        let bench = Bench::new(experiment, &[]).unwrap();
        let drive = Drive::new(experiment, &experiment.runs[0]).unwrap();
        bench.run(&drive, &Override::default()).unwrap()[0][0]
    };
    assert_eq!(start(&running), 0.0, "no reading");
    running.runs[0].table.columns[column][0] = 3.0;
    assert_eq!(start(&running), 3.0);
    running.set.push(("initial.current".to_string(), 1.0));
    assert_eq!(start(&running), 1.0);
}

/// A motor that starts at 60 and 50 degC, with noise, and with a first reading that is wrong by 2 K.
#[test]
fn a_wrong_first_reading_does_not_shift_the_run() {
    let truth = [333.15, 323.15];
    let mut experiment = crate::testing::experiment("\"thermal.C_h\" = 0.1", true);
    experiment.runs[0].start = crate::experiment::Start::Measured;
    let [winding, housing] = [2, 3].map(|output| experiment.place_of(output));
    for (column, value) in [winding, housing].into_iter().zip(truth) {
        experiment.runs[0].table.columns[column].fill(value);
    }
    let bench = Bench::new(&experiment, &[]).unwrap();
    let lag = bench.declaration().by_name("effect.housing_sensor_lag.tau").unwrap().slot;
    let mut rng = crate::testing::rng(1);
    for late in [0.0, 30.0] {
        let change = Override { values: vec![(lag, late)], ..Override::default() };
        let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
        let mut model = bench.begin_at(&drive, &change, &truth).unwrap().model;
        let mut shown = vec![Vec::new(); 4];
        bench
            .along(&drive, model.as_mut(), |model, _| {
                for (column, slot) in shown.iter_mut().zip(bench.outputs()) {
                    column.push(model.get(*slot) + 0.2 * crate::testing::normal(&mut rng));
                }
            })
            .unwrap();
        shown[3][0] += 2.0;
        experiment.runs[0].table.columns.splice(experiment.inputs.len().., shown);
        let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
        let found = bench.started(&drive, &change).unwrap().unknowns;
        // 15 rows: 0.2 / sqrt(15) = 0.05 K, and a fifteenth of 2 K; a winding that cools down faster has fewer.
        assert!((found[1] - truth[1]).abs() < 0.25 && (found[0] - truth[0]).abs() < 0.5, "{late} {found:?}");
    }
}

/// A housing without readings that starts 20 K below the winding, which soon follows it: also if the first rows have none of either.
#[test]
fn a_node_without_readings_shows_in_the_other() {
    let truth = [353.15, 333.15];
    let mut experiment = crate::testing::experiment("\"thermal.C_h\" = 0.1", true);
    experiment.runs[0].start = crate::experiment::Start::Measured;
    let [winding, housing] = [2, 3].map(|output| experiment.place_of(output));
    experiment.runs[0].table.columns[winding].fill(truth[0]);
    experiment.runs[0].table.columns[housing].fill(truth[1]);
    let bench = Bench::new(&experiment, &[]).unwrap();
    let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
    let mut model = bench.begin_at(&drive, &Override::default(), &truth).unwrap().model;
    let mut shown = vec![Vec::new(); 4];
    bench
        .along(&drive, model.as_mut(), |model, _| {
            shown.iter_mut().zip(bench.outputs()).for_each(|(column, slot)| column.push(model.get(*slot)));
        })
        .unwrap();
    for blank in [0, 8] {
        let mut own = shown.clone();
        own[2][..blank].fill(f64::NAN);
        own[3].fill(f64::NAN);
        experiment.runs[0].table.columns.splice(experiment.inputs.len().., own);
        let drive = Drive::new(&experiment, &experiment.runs[0]).unwrap();
        assert_eq!(drive.warm.iter().map(|own| own.output).collect::<Vec<_>>(), [Some(2), None]);
        let found = bench.started(&drive, &Override::default()).unwrap().unknowns;
        let again = bench.run(&drive, &Override::default()).unwrap();
        let worst = |from: usize, output: usize| {
            let pairs = again[output].iter().zip(&shown[output]).skip(from);
            pairs.map(|(own, shown)| (own - shown).abs()).fold(0.0, f64::max)
        };
        assert!(worst(blank, 2) < 0.1, "{blank} {found:?}: {}", worst(blank, 2));
        // What a winding had that has cooled down since, 20 K of a tenth of the heat capacity, nobody knows.
        assert!(
            worst(blank, 3) < if blank > 0 { 2.0 } else { 0.1 },
            "{blank} {found:?}: {}",
            worst(blank, 3)
        );
    }
}

#[test]
fn a_node_that_is_not_known_takes_the_nearest() {
    let motor =
        named("AnnulusCooledMotor", &[("winding_temperature", 360.0), ("housing_temperature", 330.0)]);
    let values: Vec<f64> = motor.iter().map(|(_, value)| *value).collect();
    assert_eq!(values, [360.0, 330.0, 330.0, 330.0], "{motor:?}");
    let gearmotor = named("BrushedGearmotor", &[("housing_temperature", 320.0), ("box_temperature", 305.0)]);
    let (names, values): (Vec<_>, Vec<_>) = gearmotor.into_iter().unzip();
    assert_eq!(names, ["winding", "housing", "box", "gear"].map(|n| format!("initial.{n}_temperature")));
    assert_eq!(values, [320.0, 320.0, 305.0, 320.0]);
    assert!(named("BrushedGearmotor", &[]).is_empty());
}
