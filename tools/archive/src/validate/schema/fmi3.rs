//! `modelDescription.xml` of FMI 3.0, after `fmi3ModelDescription.xsd` and the files it includes; the types and
//! variables are in `fmi3_variables.rs`.

use super::fmi2::{BASE_UNIT, CONVERSION, DEPENDENCIES, DESCRIPTION, EXPERIMENT};
use super::fmi3_common::{ANNOTATED, ANNOTATIONS, NAME, NAME_AND_DESCRIPTION};
use super::fmi3_variables::{TYPES, VARIABLES};
use super::types::{INT, Type, UNSIGNED_INT};
use super::*;

const INTERFACE: &[Attribute] = &[
    required("modelIdentifier", Type::Text),
    optional("needsExecutionTool", Type::Boolean),
    optional("canBeInstantiatedOnlyOncePerProcess", Type::Boolean),
    optional("canGetAndSetFMUState", Type::Boolean),
    optional("canSerializeFMUState", Type::Boolean),
    optional("providesDirectionalDerivatives", Type::Boolean),
    optional("providesAdjointDerivatives", Type::Boolean),
    optional("providesPerElementDependencies", Type::Boolean),
];

const fn interface(
    name: &'static str,
    attributes: &'static [&'static [Attribute]],
    slots: &'static [Slot],
) -> Element {
    Element { name, attributes, any_attribute: true, content: Content::Slots(slots) }
}

static MODEL_EXCHANGE: Element = interface(
    "ModelExchange",
    &[
        INTERFACE,
        &[
            optional("needsCompletedIntegratorStep", Type::Boolean),
            optional("providesEvaluateDiscreteStates", Type::Boolean),
        ],
    ],
    &ANNOTATED,
);
static CO_SIMULATION: Element = interface(
    "CoSimulation",
    &[
        INTERFACE,
        &[
            optional("canHandleVariableCommunicationStepSize", Type::Boolean),
            optional("fixedInternalStepSize", Type::Double),
            optional("maxOutputDerivativeOrder", UNSIGNED_INT),
            optional("recommendedIntermediateInputSmoothness", INT),
            optional("providesIntermediateUpdate", Type::Boolean),
            optional("mightReturnEarlyFromDoStep", Type::Boolean),
            optional("canReturnEarlyAfterIntermediateUpdate", Type::Boolean),
            optional("hasEventMode", Type::Boolean),
            optional("providesEvaluateDiscreteStates", Type::Boolean),
        ],
    ],
    &ANNOTATED,
);
static SCHEDULED_EXECUTION: Element = interface("ScheduledExecution", &[INTERFACE], &ANNOTATED);

static DISPLAY_UNIT: Element =
    element("DisplayUnit", &[NAME, CONVERSION, &[optional("inverse", Type::Boolean)]], &ANNOTATED);
static UNIT: Element =
    element("Unit", &[NAME], &[maybe(&[&BASE_UNIT]), any_number(&[&DISPLAY_UNIT]), maybe(&[&ANNOTATIONS])]);
static UNIT_DEFINITIONS: Element = element("UnitDefinitions", &[], &[at_least_one(&[&UNIT])]);
static TYPE_DEFINITIONS: Element = element("TypeDefinitions", &[], &[at_least_one(TYPES)]);

static CATEGORY: Element = element("Category", &[NAME_AND_DESCRIPTION], &ANNOTATED);
static LOG_CATEGORIES: Element = element("LogCategories", &[], &[at_least_one(&[&CATEGORY])]);
static DEFAULT_EXPERIMENT: Element = element("DefaultExperiment", &[EXPERIMENT], &ANNOTATED);
static MODEL_VARIABLES: Element = element("ModelVariables", &[], &[at_least_one(VARIABLES)]);

const UNKNOWN: &[&[Attribute]] = &[&[required("valueReference", UNSIGNED_INT)], DEPENDENCIES];
static OUTPUT: Element = element("Output", UNKNOWN, &ANNOTATED);
static DERIVATIVE: Element = element("ContinuousStateDerivative", UNKNOWN, &ANNOTATED);
static CLOCKED_STATE: Element = element("ClockedState", UNKNOWN, &ANNOTATED);
static INITIAL_UNKNOWN: Element = element("InitialUnknown", UNKNOWN, &ANNOTATED);
static EVENT_INDICATOR: Element = element("EventIndicator", UNKNOWN, &ANNOTATED);
static MODEL_STRUCTURE: Element = element(
    "ModelStructure",
    &[],
    &[
        any_number(&[&OUTPUT]),
        any_number(&[&DERIVATIVE]),
        any_number(&[&CLOCKED_STATE]),
        any_number(&[&INITIAL_UNKNOWN]),
        any_number(&[&EVENT_INDICATOR]),
    ],
);

/// The root element.
pub(crate) static MODEL_DESCRIPTION: Element = element(
    "fmiModelDescription",
    &[DESCRIPTION, &[required("fmiVersion", Type::Version3), required("instantiationToken", Type::Text)]],
    &[
        maybe(&[&MODEL_EXCHANGE]),
        maybe(&[&CO_SIMULATION]),
        maybe(&[&SCHEDULED_EXECUTION]),
        maybe(&[&UNIT_DEFINITIONS]),
        maybe(&[&TYPE_DEFINITIONS]),
        maybe(&[&LOG_CATEGORIES]),
        maybe(&[&DEFAULT_EXPERIMENT]),
        once(&[&MODEL_VARIABLES]),
        once(&[&MODEL_STRUCTURE]),
        maybe(&[&ANNOTATIONS]),
    ],
);
