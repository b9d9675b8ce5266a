//! Writes the page: `page MODELS.wasm OUT.html`. Called by `cargo xtask page`.

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [wasm, out] = arguments.as_slice() else {
        eprintln!("usage: page MODELS.wasm OUT.html");
        return ExitCode::from(2);
    };
    let written = std::fs::read(wasm)
        .map_err(|e| format!("{wasm} cannot be read: {e}"))
        .and_then(|bytes| page::html::page(&bytes).map_err(|e| e.to_string()))
        .and_then(|page| std::fs::write(out, page).map_err(|e| format!("{out} cannot be written: {e}")));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(sentence) => {
            eprintln!("error: {sentence}");
            ExitCode::from(2)
        }
    }
}
