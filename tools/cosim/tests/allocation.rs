//! Set, step and get must not allocate.
use crate::common::*;
use crate::counting::allocations;
use cosim::{Experiment, FmiVersion, Instance, Kind, Log};

#[test]
fn hot_calls_do_not_allocate() {
    for version in BOTH {
        let archive = Fmu::good(version).open().unwrap();
        let d = archive.description();
        let (n, twice) = (d.variable("n").unwrap().kind, d.variable("twice").unwrap().kind);
        let mut instance = Instance::instantiate(&archive, "lag", Log::new()).unwrap();
        instance.setup_experiment(&Experiment::default()).unwrap();
        instance.enter_initialization(&Experiment::default()).unwrap();
        instance.exit_initialization().unwrap();
        let before = allocations();
        let (mut x, mut i, mut b) = ([0.0], [0], [false]);
        for k in 0..100 {
            instance.set_f64(&[1], &[1.0]).unwrap();
            if version == FmiVersion::V2 {
                instance.set_input_derivatives(&[1], &[1.0]).unwrap();
            }
            instance.set_i64(n, &[7], &[3]).unwrap();
            instance.do_step(f64::from(k) * 0.5, 0.5).unwrap();
            instance.get_f64(&[5], &mut x).unwrap();
            instance.get_i64(twice, &[8], &mut i).unwrap();
            instance.get_bool(&[6], &mut b).unwrap();
            instance.get_number(Kind::Boolean, &[6], &mut x).unwrap();
        }
        assert_eq!(allocations(), before);
        assert_eq!((i, b), ([6], [true]));
    }
}
