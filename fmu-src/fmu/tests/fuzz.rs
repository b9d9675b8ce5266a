//! Random calls: every function of both C interfaces, with arguments that make sense and arguments that do not;
//! `cargo xtask fuzz --calls N` makes more of them.
//!
//! Only conditions that C cannot check are always met: handles are valid, arrays have the given length. Nothing may crash, every
//! status is one of the standards', and no call may meet an internal failure, which is how a panic inside is reported.

use crate::common::{Fmu, Importer, Look, MODELS, Options, Saved};
use motor_fmu::fmi2::*;
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;
use motor_fmu::saved::seal;
use physics::model::ModelType;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::ptr::{null, null_mut};

/// Random numbers, the same for the same seed.
struct Source(Pcg64Mcg);

impl Source {
    fn new(seed: u64) -> Source {
        Source(Pcg64Mcg::seed_from_u64(seed))
    }

    fn next(&mut self) -> u64 {
        self.0.next_u64()
    }

    fn below(&mut self, n: usize) -> usize {
        self.0.random_range(0..n)
    }

    fn coin(&mut self) -> bool {
        self.below(2) == 1
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// A number as an importer gives it, or as none should.
    fn number(&mut self) -> f64 {
        let share = self.next() as f64 / u64::MAX as f64;
        match self.below(12) {
            0 => self.one(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, -0.0]),
            1 => self.one(&[0.0, 1.0, -1.0, 298.15, 101_325.0, 8.0, 64.0]),
            2 => (share - 0.5) * 1e6,
            3 => 250.0 + 200.0 * share,
            4 => (share - 0.5) * 1e-6,
            _ => (share - 0.3) * 30.0,
        }
    }

    fn numbers(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.number()).collect()
    }
}

/// An intermediate update with allowed and forbidden calls; sometimes it requests an early return.
fn looker(mut rng: Source, references: Vec<u32>) -> Look {
    Box::new(move |fmu, time, _, _| {
        let (vr, mut value) = ([rng.one(&references)], [rng.number()]);
        match rng.below(8) {
            0 | 1 => fmu.set_reals(&vr, &value),
            2 => fmu.step(time, 1e-3),
            3 => fmu.reset(),
            4 => fmu.get_slopes(&vr, &[1], &mut value),
            5 => fmu.enter_event(),
            _ => fmu.get_reals(&vr, &mut value),
        };
        fmu.free();
        (rng.below(4) == 0).then(|| time + rng.number() * 1e-3)
    })
}

/// One instance under test.
struct TestInstance {
    /// Freed before the instance.
    saved: Vec<Saved>,
    importer: Importer,
    references: Vec<u32>,
    /// The parameters that count elements.
    sizes: Vec<u32>,
    /// Where the next step may begin, s.
    time: f64,
}

impl TestInstance {
    fn new(rng: &mut Source, kind: Option<&'static ModelType>) -> TestInstance {
        let kind = kind.unwrap_or_else(|| &MODELS[rng.below(MODELS.len())]);
        let declaration = (kind.declaration)();
        let entries = &declaration.entries;
        let references: Vec<u32> =
            entries.iter().map(|e| e.value_reference).chain([0, 99, u32::MAX]).collect();
        let seen: Vec<u32> =
            entries.iter().filter(|e| e.is_intermediate()).map(|e| e.value_reference).collect();
        let how = (rng.coin(), rng.coin());
        let options = Options {
            logging: rng.coin(),
            event_mode: rng.coin(),
            early_return: rng.coin(),
            ..Options::default()
        };
        let look = looker(Source::new(rng.next()), references.clone());
        let look = (rng.below(3) == 0).then_some((&seen[..], look));
        let importer = Importer::tried(kind, how, options, look).expect("an instance");
        let sizes = declaration.dimensions.iter().map(|&k| entries[k].value_reference).collect();
        TestInstance { saved: Vec::new(), importer, references, sizes, time: 0.0 }
    }

    /// One call; the outcome's status.
    fn call(&mut self, rng: &mut Source) -> Status {
        let fmu: Fmu = *self.importer;
        let (h, three) = (fmu.handle, fmu.three);
        let n = rng.below(4);
        let vr: Vec<u32> = (0..n).map(|_| rng.one(&self.references)).collect();
        let mut values = rng.numbers(n);
        let mut whole: Vec<i64> = values.iter().map(|v| *v as i64).collect();
        let count = if rng.below(9) == 0 { rng.below(30) } else { fmu.number_of_states() };
        let mut x = rng.numbers(count);
        let orders = vec![1; n];
        match rng.below(30) {
            0 => fmu.enter(None, 0.0),
            1 => fmu.exit_initialization(),
            2 | 3 => fmu.get_reals(&vr, &mut values),
            4 | 5 => fmu.set_reals(&vr, &values),
            6 => fmu.set_whole(&vr, &whole),
            7 => fmu.get_whole(&vr, &mut whole),
            26 if three => unsafe { fmi3EnterStepMode(h) },
            27 if three && rng.below(4) > 0 => self.configure(rng),
            28 if three => fmu.get_reals(&vr, &mut vec![0.0; rng.below(80)]),
            8..=10 => {
                let step = rng.one(&[1e-6, 1e-3, 1e-3, 1e-2, 0.3, 5.0, 0.0, -1.0, f64::NAN]);
                let at = if rng.below(9) == 0 { rng.number() } else { self.time };
                let (status, last) = if three {
                    let (mut a, mut b, mut last) = (0, 0, at + step);
                    let status = unsafe { fmi3DoStep(h, at, step, 1, &mut a, &mut b, null_mut(), &mut last) };
                    (status, last)
                } else {
                    (fmu.step(at, step), at + step)
                };
                if status == Status::Ok {
                    self.time = last;
                }
                status
            }
            11 => fmu.iterate().0,
            12 => fmu.continue_in_time(),
            13 => fmu.set_states(&x),
            14 => fmu.get_rates(&mut x),
            15 => fmu.get_indicators(&mut x[..count.min(2)]),
            16 => fmu.set_time(rng.number()),
            17 => fmu.complete().0,
            18 => fmu.enter_event(),
            19 => fmu.directional(&vr, &[rng.one(&self.references)], &[rng.number()], &mut values),
            20 => self.keep(fmu.try_save()),
            21 => {
                let status = match self.a_state(rng) {
                    Some(saved) => fmu.restore(saved),
                    None => fmu.set_state(null_mut()),
                };
                let mut now = [0.0];
                if fmu.get_reals(&[0], &mut now) == Status::Ok {
                    self.time = now[0];
                }
                status
            }
            22 => self.through_bytes(rng),
            23 => fmu.get_slopes(&vr, &orders, &mut values),
            24 if three => unsafe {
                let (vr, seed, out) = (vr.as_ptr(), values.clone(), values.as_mut_ptr());
                fmi3GetAdjointDerivative(h, vr, n, vr, n, seed.as_ptr(), n, out, n)
            },
            24 => fmu.set_slopes(&vr, &orders, &values),
            25 if rng.below(20) == 0 => {
                self.time = 0.0;
                fmu.reset()
            }
            25 if three => unsafe { fmi3GetFloat64(h, null(), n, null_mut(), n) },
            25 => unsafe { fmi2SetReal(h, null(), n, null()) },
            _ if rng.below(20) == 0 => fmu.terminate(),
            _ => fmu.get_states(&mut x),
        }
    }

    /// Another number of elements, if this is the time for it.
    fn configure(&mut self, rng: &mut Source) -> Status {
        let h = self.importer.handle;
        let (size, count) = (rng.one(&[&self.sizes[..], &[99]].concat()), rng.below(70) as u64);
        unsafe {
            let status = fmi3EnterConfigurationMode(h);
            fmi3SetUInt64(h, &size, 1, &count, 1);
            fmi3ExitConfigurationMode(h);
            status
        }
    }

    /// A saved state, if there are any.
    fn a_state(&self, rng: &mut Source) -> Option<&Saved> {
        self.saved.get(rng.below(self.saved.len().max(1)))
    }

    /// A saved state through its bytes: as they are, with a damaged bit, or with a damaged number and the checksum that belongs to it.
    fn through_bytes(&mut self, rng: &mut Source) -> Status {
        let Some(saved) = self.a_state(rng) else {
            return self.importer.state_size(null_mut(), &mut 0);
        };
        let mut bytes = saved.bytes();
        match rng.below(4) {
            0 => {
                let k = rng.below(bytes.len());
                bytes[k] ^= 1 << rng.below(8);
            }
            1 => {
                // The mode stands before: that of an instance that failed is a valid one.
                let k = rng.below(bytes.len() - NUMBERS) + NUMBERS;
                bytes[k] ^= 1 << rng.below(8);
                seal(&mut bytes);
            }
            _ => {}
        }
        let keep = if rng.below(4) == 0 { rng.below(bytes.len() + 1) } else { bytes.len() };
        let made = self.importer.read(&bytes[..keep]);
        self.keep(made)
    }

    fn keep(&mut self, made: Result<Saved, Status>) -> Status {
        made.map(|saved| self.saved.push(saved)).err().unwrap_or(Status::Ok)
    }
}

/// Bytes of a serialized state before its token and numbers: magic, checksum, interface, mode.
const NUMBERS: usize = 14;

/// Calls of one instance.
const CALLS: u64 = 400;

/// Calls functions of `instances` instances, of one model or of all; how many calls there were, and how many succeeded.
///
/// # Panics
/// On an internal failure, with the seed that leads there.
pub fn run(instances: u64, seed: u64, kind: Option<&'static ModelType>) -> (u64, u64) {
    let (mut calls, mut done) = (0, 0);
    for seed in seed..seed + instances {
        let mut rng = Source::new(seed);
        let mut instance = TestInstance::new(&mut rng, kind);
        for _ in 0..CALLS {
            calls += 1;
            let status = instance.call(&mut rng);
            assert_ne!(status, Status::Fatal, "seed {seed}");
            assert!(!instance.importer.has_failed(), "seed {seed}: {:?}", instance.importer.heard());
            done += u64::from(status == Status::Ok);
            if instance.saved.len() > 8 {
                instance.saved.remove(0);
            }
        }
    }
    (calls, done)
}

#[test]
fn random_calls_cause_no_internal_failure() {
    let instances = crate::common::shortened(250, 3) as u64;
    let (calls, done) = run(instances, 1, None);
    assert_eq!(calls, CALLS * instances);
    // Neither all refused nor all accepted: the calls reach every mode.
    assert!(done > calls / 20 && done < calls, "{done} of {calls}");
}
