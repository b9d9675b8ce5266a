//! A native model by name: set and read by variable name, run to its steady state.

use crate::StudyError;
use describe::usage::{Scope, Unused};
use describe::{Preset, StartValues, models};
use physics::declare::{Causality, Kind, Unit};
use physics::load_table::LoadTable;
use physics::model::{Declaration, Entry, HousingHeat, Model};

/// Length of the first stretch on the way to the steady state, s.
const FIRST_STRETCH: f64 = 10.0;
/// Largest distance of a temperature from its steady value at which it counts as steady, K.
pub(crate) const STEADY: f64 = 1e-4;
/// Longest time to a steady state, s: a year and a half. Thermal time constants are minutes to hours.
const LONGEST: f64 = 5e7;
/// Stretch after which two changes below [`STEADY`] that do not fall leave nothing to come, s: longer than thermal time constants.
const QUIET: f64 = 1e4;
/// Stretches do not grow while a temperature changes by more than this within one, K.
const FAR: f64 = 100.0;
/// Above this temperature the run ends as a thermal runaway, K.
const RUNAWAY: f64 = 2000.0;

/// A model with the values that were set on it, and the time that it has reached.
pub struct Bench {
    declaration: &'static Declaration,
    model: Box<dyn Model>,
    time: f64,
    running: bool,
}

impl Clone for Bench {
    fn clone(&self) -> Self {
        Bench { model: self.model.boxed_clone(), ..*self }
    }
}

impl Bench {
    /// The model of this name at its default start values, or at those of a preset for it.
    ///
    /// # Errors
    /// No such model, or a preset for another model.
    pub fn new(model: &str, preset: Option<&Preset>) -> Result<Bench, StudyError> {
        let kind = models::by_name(model).ok_or_else(|| {
            let known: Vec<&str> = models::ALL.iter().map(|m| (m.declaration)().name).collect();
            let hint = describe::preset::nearest(model, known.iter().copied());
            StudyError::new(format!("unknown model {model}; models: {}{hint}", known.join(", ")))
        })?;
        if let Some(p) = preset.filter(|p| p.model != model) {
            return Err(StudyError::new(format!("preset {} is for {} and not for {model}", p.name, p.model)));
        }
        let declaration = (kind.declaration)();
        let mut bench = Bench { declaration, model: (kind.new)(), time: 0.0, running: false };
        for entry in &declaration.entries {
            if entry.is_settable() {
                bench.assign(entry, preset.map_or(entry.row.start, |p| p.starts.of(entry)))?;
            }
        }
        Ok(bench)
    }

    /// Sets all of these values.
    ///
    /// # Errors
    /// One sentence naming variable, value and limits.
    pub fn set_all(&mut self, values: &StartValues) -> Result<(), StudyError> {
        for (reference, value) in values.entries() {
            if let Some(entry) = self.declaration.by_reference(reference) {
                self.assign(entry, value)?;
            }
        }
        Ok(())
    }

    /// Gives the model a load table; false where it has no use for one.
    pub fn set_load(&mut self, table: &LoadTable) -> bool {
        self.model.set_load(table)
    }

    /// The model with the values that were set on it.
    pub fn into_model(self) -> Box<dyn Model> {
        self.model
    }

    /// What is declared of the model.
    pub fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    /// The time reached, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The variable of this name.
    ///
    /// # Errors
    /// One sentence with the nearest name.
    pub fn entry(&self, name: &str) -> Result<&'static Entry, StudyError> {
        self.declaration
            .by_name(name)
            .ok_or_else(|| StudyError::new(describe::preset::unknown(self.declaration, name)))
    }

    /// Whether the model has the variable, and, where `item` is given, whether it is a choice with that item.
    pub fn knows(&self, name: &str, item: Option<&str>) -> bool {
        self.declaration.by_name(name).is_some_and(|entry| match (item, entry.row.kind) {
            (None, _) => true,
            (Some(item), Kind::Enumeration(t)) => t.items.iter().any(|i| i.name == item),
            _ => false,
        })
    }

    /// Whether the model computes the variable.
    pub fn is_output(&self, name: &str) -> bool {
        self.declaration.by_name(name).is_some_and(|e| e.row.causality == Causality::Output)
    }

    /// Sets a parameter or an input, in SI units.
    ///
    /// # Errors
    /// One sentence naming variable, value and limits.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), StudyError> {
        let entry = self.entry(name)?;
        self.assign(entry, value)
    }

    /// Sets from text: a number in SI units or with its unit, an item of an enumeration, or true and false.
    ///
    /// # Errors
    /// One sentence naming variable, value and limits.
    pub fn set_text(&mut self, name: &str, text: &str) -> Result<(), StudyError> {
        let entry = self.entry(name)?;
        let value = describe::preset::from_text(entry, text, false).map_err(StudyError::new)?;
        self.assign(entry, value)
    }

    fn assign(&mut self, entry: &Entry, value: f64) -> Result<(), StudyError> {
        entry.check(value, self.running).map_err(|refusal| {
            StudyError::new(entry.explain(value, &refusal).trim_end_matches('.').to_owned())
        })?;
        if self.model.set(entry.slot, value) {
            Ok(())
        } else {
            Err(StudyError::new(format!("{} does not take {value}", entry.name)))
        }
    }

    /// Ends the configuration: every state takes its start value.
    ///
    /// # Errors
    /// Parameters that contradict each other.
    pub fn start(&mut self) -> Result<(), StudyError> {
        self.model.start(0.0).map_err(|fault| StudyError::new(fault.to_string()))?;
        (self.time, self.running) = (0.0, true);
        Ok(())
    }

    /// Advances by `h` > 0 seconds.
    ///
    /// # Errors
    /// Not started, a step that is none, or no solution.
    pub fn step(&mut self, h: f64) -> Result<(), StudyError> {
        if !self.running {
            return Err(StudyError::new(format!("{} has not been started", self.declaration.name)));
        }
        if !h.is_finite() || h <= 0.0 {
            return Err(StudyError::new(format!("the step {h} s is not positive and finite")));
        }
        self.model.step(self.time, h).map_err(|fault| StudyError::of_step(&*self.model, &fault))?;
        self.time += h;
        Ok(())
    }

    /// The value of a variable, in SI units; outputs belong to the present time.
    ///
    /// # Errors
    /// No such variable.
    pub fn get(&mut self, name: &str) -> Result<f64, StudyError> {
        let slot = self.entry(name)?.slot;
        Ok(self.model.get(slot))
    }

    /// Heat flow from the housing to ambient; `None` where the model has none.
    pub fn housing_heat(&mut self) -> Option<HousingHeat> {
        self.model.housing_heat()
    }

    /// Those of `candidates` that have no effect with the values set so far; called before the start.
    pub fn unused(&self, candidates: &[&'static Entry], scope: Scope) -> Vec<Unused> {
        describe::usage::unused(self.model.as_ref(), candidates, scope)
    }

    /// Those of `candidates` that have an effect on the steady state at the present inputs; called before the start.
    pub fn effective(&self, candidates: &[&'static Entry]) -> Vec<&'static Entry> {
        describe::usage::effective(self.model.as_ref(), candidates, Scope::Steady)
    }

    /// The declared outputs that are temperatures.
    pub fn temperatures(&self) -> impl Iterator<Item = &'static Entry> + use<> {
        self.declaration
            .entries
            .iter()
            .filter(|e| e.row.causality == Causality::Output && e.row.unit == Unit::Kelvin && !e.row.relative)
    }

    /// Starts the model and runs it with constant inputs until it [settles](Bench::settle).
    ///
    /// # Errors
    /// As `settle`, or parameters that contradict each other.
    pub fn steady_state(&mut self) -> Result<(), StudyError> {
        self.start()?;
        self.settle()
    }

    /// Runs on from the present state with constant inputs until every temperature is steady.
    ///
    /// The stretches grow until each leaves a small share of the distance that the one before has left. From
    /// two changes d1, d2 of a temperature over equal stretches what is still to come follows as that of a
    /// geometric sequence, d2^2/(d1 - d2) (Aitken); the model is steady where that is below 1e-4 K.
    ///
    /// # Errors
    /// The model has no steady state: thermal runaway, or a speed that grows without limit.
    pub fn settle(&mut self) -> Result<(), StudyError> {
        let end = self.time + LONGEST;
        let slots: Vec<_> = self.temperatures().collect();
        let read =
            |bench: &mut Bench| -> Vec<f64> { slots.iter().map(|e| bench.model.get(e.slot)).collect() };
        let mut stretch = FIRST_STRETCH;
        let mut before = read(self);
        let mut changes: Option<Vec<f64>> = None;
        while self.time < end {
            self.step(stretch).map_err(|e| self.unsettled(&e.to_string()))?;
            let now = read(self);
            let change: Vec<f64> = now.iter().zip(&before).map(|(a, b)| a - b).collect();
            if let Some(hot) = now.iter().position(|t| !t.is_finite() || *t > RUNAWAY) {
                let (name, t) = (&slots[hot].name, now[hot]);
                return Err(self.unsettled(&format!(
                    "{name} passes {t:.0} K {:.0} s after the start: thermal runaway",
                    self.time
                )));
            }
            if let Some(last) = &changes {
                let left = last.iter().zip(&change).map(|(d1, d2)| to_come(*d1, *d2)).fold(0.0, f64::max);
                if left < STEADY {
                    return Ok(());
                }
                // Changes that do not fall are the error of the integrator, or a drift that longer stretches show.
                if left.is_infinite() && last.iter().chain(&change).all(|d| d.abs() < STEADY) {
                    if stretch >= QUIET {
                        return Ok(());
                    }
                    stretch *= 2.0;
                    changes = None;
                    before = now;
                    continue;
                }
                let slow =
                    last.iter().zip(&change).any(|(d1, d2)| d2.abs() > 0.3 * d1.abs() && d2.abs() > STEADY);
                // A thermal runaway is exponential: no longer stretches for it.
                let far = change.iter().any(|d| d.abs() > FAR);
                if slow && !far {
                    stretch *= 2.0;
                    changes = None;
                    before = now;
                    continue;
                }
            }
            changes = Some(change);
            before = now;
        }
        let moving =
            slots.iter().zip(changes.unwrap_or_default()).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let moving = moving
            .map_or(String::new(), |(e, d)| format!("{} still moves by {d:.3} K in {stretch:.0} s", e.name));
        Err(self.unsettled(&moving))
    }

    fn unsettled(&self, why: &str) -> StudyError {
        StudyError::Unsettled(format!(
            "{} does not settle: {}",
            self.declaration.name,
            why.trim_end_matches('.')
        ))
    }
}

/// What is still to come of a quantity that changed by `d1` and then, over an equal stretch, by `d2`.
fn to_come(d1: f64, d2: f64) -> f64 {
    let (d1, d2) = (d1.abs(), d2.abs());
    // Rounding noise of a constant quantity has no ratio.
    if d2 < 1e-9 {
        return d2;
    }
    if d2 >= d1 { f64::INFINITY } else { d2 * d2 / (d1 - d2) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motor() -> Bench {
        Bench::new("AnnulusCooledMotor", Some(&Preset::load("maxon-305015").unwrap())).unwrap()
    }

    /// By hand: 10 W through R_wh 0.21 K/W and G 0.1351 W/K from 298.15 K.
    #[test]
    fn steady_state_of_two_nodes_by_hand() {
        let mut bench = motor();
        bench.set_text("drive_mode", "power").unwrap();
        bench.set("electrical_power", 10.0).unwrap();
        bench.steady_state().unwrap();
        let housing = 298.15 + 10.0 / 0.1351;
        assert!((bench.get("housing_temperature").unwrap() - housing).abs() < 1e-3);
        assert!((bench.get("winding_temperature").unwrap() - housing - 2.1).abs() < 1e-3);
        assert!((bench.get("heat_to_ambient").unwrap() - 10.0).abs() < 1e-4);
    }

    /// Steady within a millikelvin in every cooling mode: a day and a half later nothing has changed.
    #[test]
    fn steady_means_steady() {
        let mut bench = Bench::new("AnnulusCooledMotor", Some(&Preset::load("thesis-rig").unwrap())).unwrap();
        bench.set_text("drive_mode", "power").unwrap();
        bench.set("electrical_power", 10.0).unwrap();
        bench.set("fan_command", 1.0).unwrap();
        for mode in ["conductance", "bare", "fan_crossflow", "annulus_push", "annulus_pull"] {
            let mut bench = bench.clone();
            bench.set_text("cooling_mode", mode).unwrap();
            bench.steady_state().unwrap();
            for entry in bench.temperatures() {
                let at_once = bench.get(&entry.name).unwrap();
                let mut later = bench.clone();
                later.step(1.5 * 86_400.0).unwrap();
                let moved = later.get(&entry.name).unwrap() - at_once;
                assert!(moved.abs() < 1e-3, "{mode}: {} moves by {moved} K", entry.name);
            }
        }
    }

    /// 12 A at stall: I^2 R alpha (R_wh + 1/G) = 144 * 0.386 * 0.0039 * 7.61 = 1.65 > 1: every kelvin brings
    /// more heat than it drives out.
    #[test]
    fn runaway_is_one_sentence() {
        let mut bench = motor();
        bench.set_text("drive_mode", "current").unwrap();
        bench.set_text("mechanical_mode", "imposed_speed").unwrap();
        bench.set("current_command", 12.0).unwrap();
        let error = bench.steady_state().unwrap_err().to_string();
        assert!(
            error.contains("does not settle") && error.contains("runaway") && !error.contains('\n'),
            "{error}"
        );
    }

    #[test]
    fn bad_input_is_named() {
        let mut bench = motor();
        let refusal = |r: Result<(), StudyError>| r.unwrap_err().to_string();
        for (error, words) in [
            (refusal(bench.set("motor.R_reff", 1.0)), &["motor.R_reff", "did you mean motor.R_ref?"][..]),
            (refusal(bench.set("motor.R_ref", -1.0)), &["motor.R_ref = -1 Ohm", "0.0001 ... 10000"]),
            (refusal(bench.set("current", 1.0)), &["computed by the model"]),
            (refusal(bench.set_text("drive_mode", "steam")), &["drive_mode = steam", "voltage", "power"]),
            (
                refusal(bench.set_text("motor.R_ref", "much")),
                &["motor.R_ref = much", "number in Ohm", "0.0001 ... 10000"],
            ),
            (refusal(bench.step(1.0)), &["not been started"]),
            (
                Bench::new("Motor", None).err().unwrap().to_string(),
                &["unknown model Motor", "AnnulusCooledMotor"],
            ),
            (
                Bench::new("brushedgearmotor", None).err().unwrap().to_string(),
                &["did you mean BrushedGearmotor?"],
            ),
        ] {
            assert!(words.iter().all(|w| error.contains(w)), "{words:?} in {error}");
            assert!(!error.contains('\n') && !error.ends_with('.'), "{error}");
        }
        bench.start().unwrap();
        assert!(refusal(bench.step(-1.0)).contains("-1 s"));
        assert!(refusal(bench.set_text("drive_mode", "power")).contains("fixed after initialization"));
    }

    #[test]
    fn a_clone_has_a_life_of_its_own() {
        let mut one = motor();
        let mut other = one.clone();
        other.set("motor.R_ref", 1.0).unwrap();
        assert_eq!((one.get("motor.R_ref").unwrap(), other.get("motor.R_ref").unwrap()), (0.386, 1.0));
        assert!(one.knows("drive_mode", Some("power")) && !one.knows("drive_mode", Some("steam")));
    }
}
