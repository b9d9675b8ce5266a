//! `motor-fmu build`: archives of the models.

use crate::Failure;
use crate::existing::Force;
use crate::progress::Progress;
use ::study::walk::{Drive, Load, SETTINGS, Setting};
use archive::build::{
    Contents, Library, LoadFile, Standard, TermsFile, archive_path, build_all, library_path,
};
use archive::platform;
use clap::ValueEnum;
use describe::{LoadTable, ModelType, Preset, models, usage};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Which standards to build for.
#[derive(Clone, Copy, ValueEnum)]
pub enum Which {
    /// FMI 2.0.
    #[value(name = "2")]
    Two,
    /// FMI 3.0.
    #[value(name = "3")]
    Three,
    /// Both.
    Both,
}

/// Build FMUs, <out>/fmi2/<Model>.fmu and <out>/fmi3/<Model>.fmu, and validate them.
#[derive(clap::Args)]
pub struct Args {
    /// Models to build [default: all].
    #[arg(value_name = "MODEL")]
    models: Vec<String>,
    /// Version of the standard.
    #[arg(long, value_enum, default_value = "both")]
    fmi: Which,
    /// Start values for the preset's model: a built-in preset's name or a TOML file. SeriesElasticActuator derives the motor
    /// data of its control from a preset of the motor.
    #[arg(long, value_name = "NAME|FILE")]
    preset: Option<String>,
    /// Terms found in data, written to resources/effects.json of the archives.
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    /// Torque and speed (or angle) over a cycle for GaitLoad, which starts with gait.activity = table: a CSV file with columns of
    /// usual names (time, torque, speed, angle; units in brackets), or a load file of `steady --load` with a table [cycle], which names
    /// columns and units. Written to resources/load.json of the archive.
    #[arg(long, value_name = "F.csv|F.toml")]
    load: Option<PathBuf>,
    /// Platforms of the libraries in the archives, built before with `cargo xtask cross`: x86_64-linux, x86_64-windows,
    /// aarch64-linux, ...; by default the platform of this program.
    #[arg(long, value_name = "P,...", value_delimiter = ',')]
    platform: Vec<String>,
    /// Folder to write to. Earlier FMUs of the same models are overwritten.
    #[arg(long, value_name = "DIR", default_value = "dist")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let preset = args.preset.as_deref().map(Preset::load).transpose()?;
    let effects = args.effects.as_deref().map(TermsFile::load).transpose()?;
    let load = args.load.as_deref().map(load_file).transpose()?;
    let standards = match args.fmi {
        Which::Two => &Standard::ALL[..1],
        Which::Three => &Standard::ALL[1..],
        Which::Both => &Standard::ALL[..],
    };
    let libraries = libraries(&args.platform)?;
    let mut paths = Vec::new();
    let kinds = chosen(&args.models)?;
    let takes_load = |kind: &ModelType| load.as_ref().is_some_and(|(_, table)| (kind.new)().set_load(table));
    if let (Some(file), false) = (&args.load, kinds.iter().any(|kind| takes_load(kind))) {
        let names: Vec<&str> = kinds.iter().map(|kind| (kind.declaration)().name).collect();
        let sentence = "has no use for a load table; GaitLoad has";
        return Err(Failure::new(format!("--load {}: {} {sentence}", file.display(), names.join(" and "))));
    }
    for (kind, standard) in kinds.iter().flat_map(|kind| standards.iter().map(move |s| (kind, s))) {
        let model = (kind.declaration)().name;
        args.force.check_fmu(&archive_path(&args.out, *standard, model), model)?;
    }
    let bar = Progress::new("building");
    let count = kinds.len() as f64;
    for (k, kind) in kinds.into_iter().enumerate() {
        // The archives are made quickly and validated slowly.
        bar.set(&format!("building {}", (kind.declaration)().name), 0.5 * k as f64 / count);
        // A preset belongs to its model; the actuator derives its control's motor data from its motor's. Not every model takes
        // terms. Where all are built, the others are built without; where one is named that they are not for, they are refused.
        let named = !args.models.is_empty();
        let own = preset.as_ref().and_then(|p| p.for_model(kind));
        let takes = |f: &&TermsFile| named || f.terms().map_or(true, |terms| (kind.new)().set_terms(&terms));
        let contents = Contents {
            preset: own.as_ref().or(preset.as_ref().filter(|_| named)),
            effects: effects.as_ref().filter(takes),
            load: load.as_ref().filter(|_| takes_load(kind)).map(|(file, _)| file),
        };
        if let (Some(given), Some(own)) = (&preset, &own)
            && given.model != own.model
        {
            crate::say(&derived(kind, own));
        }
        paths.extend(build_all(kind, standards, contents, &libraries, &args.out)?);
        if let Some(preset) = contents.preset {
            let from = format!("preset {}", preset.name);
            crate::remark(usage::sentence(&usage::preset_values(preset), |_| from.clone()).as_slice());
        }
    }
    bar.finish();
    let needs: Vec<String> = libraries.iter().map(Library::needs).collect();
    crate::say(&format!("libraries for {}\n", needs.join(", ")));
    crate::validate::report(&paths, false)
}

/// The load table of a CSV file or of a load file, and a note on what is not part of it.
fn load_file(path: &Path) -> Result<(LoadFile, LoadTable), Failure> {
    let load = Load::read(path, None, &[])?;
    let (table, source, drive) = load.table().ok_or_else(|| {
        Failure::new(format!(
            "{} has no table [cycle]: a load table is torque and speed (or angle) from a CSV file",
            path.display()
        ))
    })?;
    let differs = |setting: &&Setting| setting.get(&drive) != setting.get(&Drive::default());
    let names: Vec<&str> =
        SETTINGS.iter().filter(differs).map(|s| s.name).filter(|n| *n != "cycle.scale").collect();
    if !names.is_empty() {
        let sentence = format!(
            "{} not part of GaitLoad: gear and supply belong to SeriesElasticActuator, inertia to the torque of the file",
            if names.len() == 1 { format!("{} is", names[0]) } else { format!("{} are", names.join(", ")) }
        );
        crate::remark(&[sentence]);
    }
    Ok((LoadFile::new(&table, source), table))
}

/// The start values that a model derives from a preset of another, as a line.
fn derived(kind: &ModelType, preset: &Preset) -> String {
    let declaration = (kind.declaration)();
    let entries = declaration.entries.iter().filter(|e| preset.starts.names(e));
    let values: Vec<String> =
        entries.map(|e| format!("{} = {} {}", e.name, preset.starts.of(e), e.row.unit.name())).collect();
    format!("{}, {}: {}\n", declaration.name, preset.description, values.join(", "))
}

/// The libraries for the platforms that are named, each once; for none that of this program.
fn libraries(names: &[String]) -> Result<Vec<Library>, Failure> {
    if names.is_empty() {
        return Ok(vec![Library::here(&library_path()?)]);
    }
    let mut found = Vec::new();
    for name in names {
        let library = platform::library(platform::by_name(name)?)?;
        if !found.contains(&library) {
            found.push(library);
        }
    }
    Ok(found)
}

/// The models that are named; without names all.
fn chosen(names: &[String]) -> Result<Vec<&'static ModelType>, Failure> {
    if names.is_empty() {
        return Ok(models::ALL.iter().collect());
    }
    let find = |name: &String| {
        models::by_name(name).ok_or_else(|| {
            let known: Vec<&str> = models::ALL.iter().map(|m| (m.declaration)().name).collect();
            let hint = describe::preset::nearest(name, known.iter().copied());
            Failure::new(format!("unknown model {name}; models: {}{hint}", known.join(", ")))
        })
    };
    names.iter().map(find).collect()
}
