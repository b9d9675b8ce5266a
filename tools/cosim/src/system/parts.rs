//! The structure of a system with the archives of its components.
use super::structure::Structure;
use crate::{Archive, ModelDescription, Variable};

/// A structure with the archive of each component.
#[derive(Clone, Copy)]
pub(crate) struct Parts<'a> {
    pub(crate) structure: &'a Structure,
    pub(crate) archives: &'a [Archive],
}

impl<'a> Parts<'a> {
    pub(crate) fn description(&self, component: usize) -> &'a ModelDescription {
        self.archives[component].description()
    }

    pub(crate) fn variable(&self, port: Port) -> &'a Variable {
        &self.description(port.component).variables[port.variable]
    }

    /// `component.variable`
    pub(crate) fn name(&self, port: Port) -> String {
        format!("{}.{}", self.structure.components[port.component].name, self.variable(port).name)
    }
}

/// A variable of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Port {
    pub(crate) component: usize,
    /// Place in the FMU's list of variables.
    pub(crate) variable: usize,
}
