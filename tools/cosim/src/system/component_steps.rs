//! The steps of the components: their order, what is exchanged in between, and shorter steps of single components.
use super::batch::Batch;
use super::connections::{Connections, InputConnection};
use super::order::{Algorithm, Order};
use super::parts::Parts;
use crate::Variability;
use crate::input::InputColumn;

#[derive(Debug)]
pub(super) struct ComponentStep {
    pub(super) component: usize,
    /// Inputs from components that have stepped already.
    pub(super) fresh: Vec<usize>,
    /// Those of them without derivatives.
    pub(super) sets: Vec<Batch>,
    pub(super) gets: Vec<Batch>,
    /// The communication step of the component, s, where it is shorter than that of the system.
    pub(super) step: Option<f64>,
}

impl ComponentStep {
    /// The number of equal steps of the component in a step of length `h` of the system.
    pub(super) fn parts(&self, h: f64) -> usize {
        self.step.map_or(1, |step| (h / step * (1.0 - 1e-9)).ceil().max(1.0) as usize)
    }
}

/// The order of component steps, and what is exchanged in between.
pub(super) fn component_steps(
    parts: Parts,
    connections: &Connections,
    order: &Order,
    algorithm: Algorithm,
    has_derivative: &[bool],
) -> Vec<ComponentStep> {
    let in_file: Vec<usize> = (0..parts.structure.components.len()).collect();
    let sequence = if algorithm == Algorithm::GaussSeidel { &order.components } else { &in_file };
    let mut component_steps: Vec<ComponentStep> = Vec::new();
    for &component in sequence {
        let step = parts.structure.components[component].step.as_ref().map(|step| step.seconds);
        let mut component_step =
            ComponentStep { component, fresh: Vec::new(), sets: Vec::new(), gets: Vec::new(), step };
        for (slot, input) in
            connections.inputs.iter().enumerate().filter(|(_, f)| f.port.component == component)
        {
            let source = connections.outputs[input.source].component;
            if component_steps.iter().any(|t| t.component == source) {
                component_step.fresh.push(slot);
                if !has_derivative[slot] {
                    Batch::add(&mut component_step.sets, component, parts.variable(input.port), slot);
                }
            }
        }
        for (slot, port) in connections.outputs.iter().enumerate().filter(|(_, p)| p.component == component) {
            Batch::add(&mut component_step.gets, component, parts.variable(*port), slot);
        }
        component_steps.push(component_step);
    }
    component_steps
}

/// Whether a connected input gets a derivative.
pub(super) fn has_derivative(parts: Parts, connections: &Connections, input: &InputConnection) -> bool {
    let from = parts.variable(connections.outputs[input.source]);
    parts.description(input.port.component).takes_input_derivative(parts.variable(input.port))
        && from.variability == Variability::Continuous
}

/// Whether a column of the input table gets derivatives.
pub(super) fn has_slope(parts: Parts, column: &InputColumn) -> bool {
    let description = parts.description(column.component);
    description.takes_input_derivative(&description.variables[column.variable])
}
