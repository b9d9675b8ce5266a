//! The validator without the rest of `motor-fmu`: `validate FILE...` prints what it finds.
//!
//! It is its own child, as `motor-fmu` is: `validate probe FILE STAGE`. The tests of the rules run FMUs through it.

use archive::validate::{Severity, dynamic, validate};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [word, file, stage] = &arguments[..]
        && word == "probe"
    {
        let stage = stage.parse().unwrap_or(0);
        let Ok(channel) = cosim::child::enter() else { return ExitCode::from(2) };
        dynamic::probe(Path::new(file), stage, &mut |event| {
            channel.send(&serde_json::to_string(&event).unwrap_or_default());
        });
        channel.end();
    }
    let Ok(program) = std::env::current_exe() else { return ExitCode::from(2) };
    let mut code = 0;
    for file in &arguments {
        match validate(Path::new(file), &program) {
            Ok(findings) => {
                for f in &findings {
                    println!("{file}: {:?} [{}] {}: {}", f.severity, f.code, f.place, f.message);
                    code = code.max(u8::from(f.severity == Severity::Error));
                }
            }
            Err(error) => {
                eprintln!("error: {error}");
                code = 2;
            }
        }
    }
    ExitCode::from(code)
}
