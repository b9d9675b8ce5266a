//! Computing time of an hour of walking: motor, actuator and gait as FMUs under the native master with a step of 1 ms, and the same models
//! without FMI and master. The difference of their throughputs is the share of the interface and the master. The support is one that the motor
//! can give continuously: with that of the example the winding reaches its limit of validity within the hour, and the simulation ends.

use archive::build::{Contents, Standard, build, library_path};
use cosim::{System, SystemOptions, cosimulate};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use describe::{Model, Preset, models};
use physics::declare::Kind;
use std::hint::black_box;
use std::path::Path;

/// Communication step, s.
const STEP: f64 = 1e-3;
/// The example that walks, and where it looks for its archives.
const EXAMPLE: &str = include_str!("../../../examples/systems/actuator-gait.toml");
const DIST: &str = "../../dist/";
/// The support of the example, and a continuous one.
const SUPPORT: [&str; 2] = ["\"gait.support\" = 1.0 ", "\"gait.support\" = 0.5 "];
/// Preset of the motor.
const PRESET: &str = "maxon-305015";

/// The example with a continuous support.
fn example() -> String {
    assert!(EXAMPLE.contains(SUPPORT[0]), "the example sets its support");
    EXAMPLE.replace(SUPPORT[0], SUPPORT[1])
}

/// The example with archives of its own in `folder`.
fn system(folder: &Path) -> System {
    let library = library_path().expect("the library stands beside the program");
    let preset = Preset::load(PRESET).expect("a preset of ours");
    for kind in models::ALL.iter().filter(|kind| EXAMPLE.contains((kind.declaration)().name)) {
        let preset = Some(&preset).filter(|p| p.model == (kind.declaration)().name);
        build(kind, Standard::Fmi2, Contents { preset, ..Contents::default() }, &library, folder)
            .expect("an archive");
    }
    let path = folder.join("walk.toml");
    let own = format!("{}/", folder.display());
    let text = example().replace(&format!("{DIST}presets/{PRESET}/"), &own).replace(DIST, &own);
    std::fs::write(&path, text).expect("a file of ours");
    System::open(&path).expect("a system of ours")
}

/// The same walk by the models themselves: what is connected is handed on, with slopes, and all step.
fn natively(seconds: f64) -> f64 {
    let preset = Preset::load(PRESET).expect("a preset of ours");
    let mut running: Vec<(&str, Box<dyn Model>)> = Vec::new();
    let example = example();
    for line in example.lines() {
        let Some((key, value)) = line.split_once(" = ") else { continue };
        let value = value.split(" #").next().unwrap_or(value).trim().trim_matches('"');
        if let (true, Some((_, archive))) = (key == "fmu", value.rsplit_once('/')) {
            let kind = models::by_name(archive.trim_end_matches(".fmu")).expect("a model of ours");
            let mut model = (kind.new)();
            if preset.model == (kind.declaration)().name {
                for entry in (kind.declaration)().entries.iter().filter(|e| e.is_settable()) {
                    model.set(entry.slot, preset.starts.of(entry));
                }
            }
            running.push(("", model));
        } else if let Some((_, model)) = running.last_mut()
            && let Some(entry) = model.declaration().by_name(key.trim_matches('"'))
        {
            let item = |kind: Kind| match kind {
                Kind::Enumeration(all) => {
                    all.items.iter().find(|item| item.name == value).map(|item| item.value)
                }
                _ => None,
            };
            let number = value.parse().ok().or_else(|| item(entry.row.kind).map(f64::from));
            model.set(entry.slot, number.expect("a number or an item"));
        }
    }
    let names = EXAMPLE.lines().filter_map(|line| line.strip_prefix("name = ")).skip(1);
    running.iter_mut().zip(names).for_each(|((name, _), given)| *name = given.trim_matches('"'));
    let end = |text: &str| {
        let (component, variable) = text.split_once('.').expect("component.variable");
        let place = running.iter().position(|(name, _)| *name == component).expect("a component");
        (place, running[place].1.declaration().by_name(variable).expect("a variable").slot)
    };
    let quoted = EXAMPLE.lines().filter_map(|line| line.trim().strip_prefix('"')?.strip_suffix("\","));
    let links: Vec<_> =
        quoted.filter_map(|line| line.split_once(" -> ")).map(|(from, to)| (end(from), end(to))).collect();
    let mut last = vec![f64::NAN; links.len()];
    for k in 0..running.len() {
        running[k].1.start(0.0).expect("it starts");
        for ((from, output), (to, input)) in links.iter().filter(|((from, _), _)| *from == k) {
            let value = running[*from].1.get(*output);
            running[*to].1.set(*input, value);
        }
    }
    for k in 0..(seconds / STEP) as u32 {
        for (((from, output), (to, input)), last) in links.iter().zip(&mut last) {
            let value = running[*from].1.get(*output);
            running[*to].1.set(*input, value);
            if last.is_finite() {
                running[*to].1.set_slope(*input, (value - *last) / STEP);
            }
            *last = value;
        }
        for (_, model) in &mut running {
            model.step(f64::from(k) * STEP, STEP).expect("it walks");
        }
    }
    last.iter().sum()
}

fn hour(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder");
    let system = system(folder.path());
    let mut group = criterion.benchmark_group("walking at 1 ms");
    group.sample_size(10);
    group.throughput(Throughput::Elements((60.0 / STEP) as u64));
    group.bench_function("a minute, the models alone", |b| b.iter(|| black_box(natively(60.0))));
    for (name, seconds) in [("a minute, three FMUs", 60.0), ("an hour, three FMUs", 3600.0)] {
        group.throughput(Throughput::Elements((seconds / STEP) as u64));
        let options = SystemOptions { stop: Some(seconds), step: Some(STEP), ..SystemOptions::default() };
        group.bench_function(name, |b| {
            b.iter(|| {
                let recording = cosimulate(&system, &options, &mut |_| ()).expect("it walks").recording;
                assert_eq!(recording.ended_early, None);
                black_box(recording.steps)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, hour);
criterion_main!(benches);
