//! The native model of an archive, accessed by names; figures and reference results of the archive are computed with it.

use describe::{Entry, Kind, Model, ModelType, Resources, StartValues, usage};

/// A model with the archive's start values and resources.
#[derive(Clone, Copy, Debug)]
pub struct Native<'a> {
    /// Which model.
    pub kind: &'a ModelType,
    /// Start values.
    pub starts: &'a StartValues,
    /// Terms and a load table that are data.
    pub resources: &'a Resources,
}

/// A model on its way. A call that the model refuses gives `None`: the figure is then not drawn.
pub struct Run<'a> {
    native: Native<'a>,
    model: Box<dyn Model>,
    steps: u32,
}

impl<'a> Native<'a> {
    /// A variable's entry.
    pub fn entry(&self, name: &str) -> Option<&'static Entry> {
        (self.kind.declaration)().by_name(name)
    }

    /// An instance with these values instead of the start values; enumerations by the name of an item.
    pub fn start(&self, values: &[(&str, f64)], choices: &[(&str, &str)]) -> Option<Run<'a>> {
        let model = usage::with_starts(self.kind, self.starts, self.resources);
        let mut run = Run { native: *self, model, steps: 0 };
        for (name, choice) in choices {
            let Kind::Enumeration(t) = self.entry(name)?.row.kind else { return None };
            let item = t.items.iter().find(|i| i.name == *choice)?;
            run.set(name, f64::from(item.value))?;
        }
        values.iter().try_for_each(|(name, value)| run.set(name, *value))?;
        run.model.start(0.0).ok()?;
        Some(run)
    }
}

impl Run<'_> {
    /// Sets an input or a parameter within its limits.
    pub fn set(&mut self, name: &str, value: f64) -> Option<()> {
        let entry = self.native.entry(name)?;
        let row = entry.row;
        let value = if row.kind == Kind::Real { value.clamp(row.min, row.max) } else { value };
        self.model.set(entry.slot, value).then_some(())
    }

    /// The present value.
    pub fn get(&mut self, name: &str) -> Option<f64> {
        Some(self.model.get(self.native.entry(name)?.slot))
    }

    /// The present value of an entry.
    pub fn value(&mut self, entry: &Entry) -> f64 {
        self.model.get(entry.slot)
    }

    /// One of many steps of the same length, at times that are multiples of it.
    pub fn step(&mut self, h: f64) -> Option<()> {
        self.model.step(f64::from(self.steps) * h, h).ok()?;
        self.steps += 1;
        Some(())
    }
}
