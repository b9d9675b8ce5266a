//! What a sweep of periodic steady states under gait costs for each point: `motor-fmu sweep --load` without reading and writing files.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use describe::Preset;
use std::hint::black_box;
use study::sweep::{Goal, Vary, Walking, sweep};
use study::walk::Load;

/// The ankle of an adult in level walking, on which the sweeps of docs/size-an-actuator.md are based.
const LOAD: &str = "[gait]\n\"gait.support\" = 0.5\n[actuator]\n\"transmission.ratio\" = 250\n";

fn sweeps(criterion: &mut Criterion) {
    let preset = Preset::load("maxon-305015").expect("a preset of ours");
    let vary = ["gait.body_mass=50:95:10", "transmission.ratio=180:270:10"];
    let vary = vary.map(|text| Vary::parse(text).expect("a range"));
    let mut group = criterion.benchmark_group("sweep under gait");
    group.sample_size(10).throughput(Throughput::Elements(100));
    for (name, motor) in [
        ("voltage drive", "drive_mode = \"voltage\""),
        ("current drive", "drive_mode = \"current\""),
        ("annulus", "drive_mode = \"current\"\ncooling_mode = \"annulus_push\"\nfan_command = 1"),
    ] {
        let text = format!("[motor]\n{motor}\n{LOAD}");
        let load = Load::parse(&text, "gait.toml", Some(&preset), &[]).expect("a load");
        let case = Walking { load, hours: 1.0 };
        group.bench_function(format!("100 steady states, {name}"), |b| {
            b.iter(|| {
                black_box(sweep(&case, &vary, &Goal::of("winding_temperature"), |_| ()).expect("a result"))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, sweeps);
criterion_main!(benches);
