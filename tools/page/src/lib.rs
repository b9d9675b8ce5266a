//! Interactive motor page in a browser. The same native models and studies as in `motor-fmu` run there as WebAssembly; one HTML file holds
//! everything and needs no network.
//!
//! ```text
//! controls -> page.js -> worker -> interface.rs -> answer(): JSON -> choice.rs -> heating, range, efficiency, walking -> SVG and values
//! ```
//!
//! `cargo xtask page` compiles this library for wasm32 and calls the program `page`, which writes the file.

pub mod choice;
pub mod efficiency;
pub mod heating;
pub mod html;
#[cfg(target_arch = "wasm32")]
mod interface;
pub mod level_lines;
pub mod range;
pub mod walking;

use choice::{Choice, Load};
use present::figure::Figure;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use study::StudyError;

/// What the page asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// Values of a motor at which a first look is worth while.
    Suggestion,
    /// Temperatures over time, and the thermal steady state.
    Heating,
    /// Operating range: torque and speed.
    Range,
    /// Efficiency over torque and speed.
    Efficiency,
}

/// A question about a choice.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Request {
    /// What is asked.
    pub question: Question,
    /// Motor, cooling and load.
    pub choice: Choice,
}

/// An answer for the page.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Answer {
    /// A figure, as SVG.
    pub figure: String,
    /// The result in sentences.
    pub text: String,
    /// The numbers, in SI units.
    pub values: Value,
}

impl Answer {
    fn new(figure: &Figure, text: String, values: &impl Serialize) -> Answer {
        Answer { figure: figure.svg(), text, values: json!(values) }
    }
}

/// Answers a request in JSON: an [`Answer`], or `{"error": sentence}`.
pub fn answer(request: &str) -> String {
    let answered = serde_json::from_str::<Request>(request)
        .map_err(|e| StudyError::new(format!("the request cannot be read: {e}")))
        .and_then(|request| found(&request));
    match answered {
        Ok(answer) => json!(answer),
        Err(error) => json!({ "error": error.to_string() }),
    }
    .to_string()
}

fn found(request: &Request) -> Result<Answer, StudyError> {
    let choice = &request.choice;
    match (request.question, &choice.load) {
        (Question::Suggestion, _) => {
            let values = range::suggestion(choice)?;
            Ok(Answer { values: json!(values), ..Answer::default() })
        }
        (Question::Heating, Load::Gait(gait)) => walking::answer(choice, gait),
        (Question::Heating, _) => heating::answer(choice),
        (Question::Range, _) => range::answer(choice),
        (Question::Efficiency, _) => efficiency::answer(choice),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every answer has a figure, a text and values; what is wrong is one sentence.
    #[test]
    fn requests_are_answered() {
        let gait = r#"{"gait": {"activity": "walk", "joint": "ankle", "body_mass": 75, "support": 0.5, "ratio": 250, "stiffness": 250}}"#;
        let ask = |question: &str, motor: &str, load: &str| -> Value {
            let request = format!(
                r#"{{"question": "{question}", "choice": {{"motor": "{motor}", "cooling": "", "fan": 0, "ambient": 25, "voltage": 24, "speed": 1000,
                "minutes": 10, "load": {load}}}}}"#
            );
            serde_json::from_str(&answer(&request)).unwrap()
        };
        let torque = r#"{"torque": 0.05}"#;
        for (question, load) in
            [("heating", torque), ("heating", gait), ("range", torque), ("efficiency", torque)]
        {
            let found = ask(question, "maxon-305015", load);
            let svg = found["figure"].as_str().unwrap_or_else(|| panic!("{question}: {found}"));
            assert!(svg.starts_with("<svg") && !svg.contains("NaN"), "{question}: {svg}");
            assert!(found["text"].as_str().unwrap().ends_with('.') && found["values"].is_object(), "{found}");
        }
        let error =
            |motor, load| ask("heating", motor, load)["error"].as_str().unwrap_or_default().to_owned();
        assert!(error("maxon-305016", torque).contains("maxon-305015"), "{}", error("maxon-305016", torque));
        assert!(error("maxon-305015", r#"{"power": 3}"#).contains("power"));
        assert!(error("maxon-305015", r#"{"torque": 1e9}"#).contains("1000000000 N.m"));
    }
}
