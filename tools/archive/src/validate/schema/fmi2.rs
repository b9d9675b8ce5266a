//! `modelDescription.xml` of FMI 2.0, after `fmi2ModelDescription.xsd` and the files it includes.

use super::types::{INT, Type, UNSIGNED_INT};
use super::*;

const REAL: &[Attribute] = &[
    optional("quantity", Type::Text),
    optional("unit", Type::Text),
    optional("displayUnit", Type::Text),
    optional("relativeQuantity", Type::Boolean),
    optional("min", Type::Double),
    optional("max", Type::Double),
    optional("nominal", Type::Double),
    optional("unbounded", Type::Boolean),
];
const INTEGER: &[Attribute] = &[optional("quantity", Type::Text), optional("min", INT), optional("max", INT)];
const DECLARED: &[Attribute] = &[optional("declaredType", Type::Text)];
const NAME: &[Attribute] = &[required("name", Type::Text)];
const NAME_AND_DESCRIPTION: &[Attribute] =
    &[required("name", Type::Text), optional("description", Type::Text)];

static TOOL: Element =
    Element { name: "Tool", attributes: &[NAME], any_attribute: false, content: Content::Any(1) };
static ANNOTATIONS: Element = element("Annotations", &[], &[at_least_one(&[&TOOL])]);
static VENDOR_ANNOTATIONS: Element = element("VendorAnnotations", &[], &[at_least_one(&[&TOOL])]);

static VARIABLE_REAL: Element = element(
    "Real",
    &[
        DECLARED,
        REAL,
        &[
            optional("start", Type::Double),
            optional("derivative", UNSIGNED_INT),
            optional("reinit", Type::Boolean),
        ],
    ],
    &[],
);
static VARIABLE_INTEGER: Element = element("Integer", &[DECLARED, INTEGER, &[optional("start", INT)]], &[]);
static VARIABLE_BOOLEAN: Element = element("Boolean", &[DECLARED, &[optional("start", Type::Boolean)]], &[]);
static VARIABLE_STRING: Element = element("String", &[DECLARED, &[optional("start", Type::Text)]], &[]);
static VARIABLE_ENUMERATION: Element = element(
    "Enumeration",
    &[&[required("declaredType", Type::Text)], INTEGER, &[optional("start", INT)]],
    &[],
);

static SCALAR_VARIABLE: Element = element(
    "ScalarVariable",
    &[&[
        required("name", Type::Text),
        required("valueReference", UNSIGNED_INT),
        optional("description", Type::Text),
        optional(
            "causality",
            Type::Words(&["parameter", "calculatedParameter", "input", "output", "local", "independent"]),
        ),
        optional("variability", Type::Words(&["constant", "fixed", "tunable", "discrete", "continuous"])),
        optional("initial", Type::Words(&["exact", "approx", "calculated"])),
        optional("canHandleMultipleSetPerTimeInstant", Type::Boolean),
    ]],
    &[
        once(&[
            &VARIABLE_REAL,
            &VARIABLE_INTEGER,
            &VARIABLE_BOOLEAN,
            &VARIABLE_STRING,
            &VARIABLE_ENUMERATION,
        ]),
        maybe(&[&ANNOTATIONS]),
    ],
);
static MODEL_VARIABLES: Element = element("ModelVariables", &[], &[at_least_one(&[&SCALAR_VARIABLE])]);

static TYPE_REAL: Element = element("Real", &[REAL], &[]);
static TYPE_INTEGER: Element = element("Integer", &[INTEGER], &[]);
// The schema gives these two no type at all, and so allows anything in them.
static TYPE_BOOLEAN: Element =
    Element { name: "Boolean", attributes: &[], any_attribute: true, content: Content::Any(UNBOUNDED) };
static TYPE_STRING: Element =
    Element { name: "String", attributes: &[], any_attribute: true, content: Content::Any(UNBOUNDED) };
static ITEM: Element = element("Item", &[NAME_AND_DESCRIPTION, &[required("value", INT)]], &[]);
static TYPE_ENUMERATION: Element =
    element("Enumeration", &[&[optional("quantity", Type::Text)]], &[at_least_one(&[&ITEM])]);
static SIMPLE_TYPE: Element = element(
    "SimpleType",
    &[NAME_AND_DESCRIPTION],
    &[once(&[&TYPE_REAL, &TYPE_INTEGER, &TYPE_BOOLEAN, &TYPE_STRING, &TYPE_ENUMERATION])],
);
static TYPE_DEFINITIONS: Element = element("TypeDefinitions", &[], &[at_least_one(&[&SIMPLE_TYPE])]);

pub(super) const EXPONENTS: &[Attribute] = &[
    optional("kg", INT),
    optional("m", INT),
    optional("s", INT),
    optional("A", INT),
    optional("K", INT),
    optional("mol", INT),
    optional("cd", INT),
    optional("rad", INT),
];
pub(super) const CONVERSION: &[Attribute] =
    &[optional("factor", Type::Double), optional("offset", Type::Double)];
pub(super) static BASE_UNIT: Element = element("BaseUnit", &[EXPONENTS, CONVERSION], &[]);
static DISPLAY_UNIT: Element = element("DisplayUnit", &[NAME, CONVERSION], &[]);
static UNIT: Element = element("Unit", &[NAME], &[maybe(&[&BASE_UNIT]), any_number(&[&DISPLAY_UNIT])]);
static UNIT_DEFINITIONS: Element = element("UnitDefinitions", &[], &[at_least_one(&[&UNIT])]);

static CATEGORY: Element = element("Category", &[NAME_AND_DESCRIPTION], &[]);
static LOG_CATEGORIES: Element = element("LogCategories", &[], &[at_least_one(&[&CATEGORY])]);

pub(super) const EXPERIMENT: &[Attribute] = &[
    optional("startTime", Type::Double),
    optional("stopTime", Type::Double),
    optional("tolerance", Type::Double),
    optional("stepSize", Type::Double),
];
static DEFAULT_EXPERIMENT: Element = element("DefaultExperiment", &[EXPERIMENT], &[]);

pub(super) const DEPENDENCIES: &[Attribute] = &[
    optional("dependencies", Type::List(&UNSIGNED_INT)),
    optional(
        "dependenciesKind",
        Type::List(&Type::Words(&["dependent", "constant", "fixed", "tunable", "discrete"])),
    ),
];
static UNKNOWN: Element = element("Unknown", &[&[required("index", UNSIGNED_INT)], DEPENDENCIES], &[]);
static OUTPUTS: Element = element("Outputs", &[], &[at_least_one(&[&UNKNOWN])]);
static DERIVATIVES: Element = element("Derivatives", &[], &[at_least_one(&[&UNKNOWN])]);
static INITIAL_UNKNOWNS: Element = element("InitialUnknowns", &[], &[at_least_one(&[&UNKNOWN])]);
static MODEL_STRUCTURE: Element = element(
    "ModelStructure",
    &[],
    &[maybe(&[&OUTPUTS]), maybe(&[&DERIVATIVES]), maybe(&[&INITIAL_UNKNOWNS])],
);

static FILE: Element = element("File", &[NAME], &[]);
static SOURCE_FILES: Element = element("SourceFiles", &[], &[at_least_one(&[&FILE])]);

const INTERFACE: &[Attribute] = &[
    required("modelIdentifier", Type::Text),
    optional("needsExecutionTool", Type::Boolean),
    optional("canBeInstantiatedOnlyOncePerProcess", Type::Boolean),
    optional("canNotUseMemoryManagementFunctions", Type::Boolean),
    optional("canGetAndSetFMUstate", Type::Boolean),
    optional("canSerializeFMUstate", Type::Boolean),
    optional("providesDirectionalDerivative", Type::Boolean),
];
static MODEL_EXCHANGE: Element = element(
    "ModelExchange",
    &[INTERFACE, &[optional("completedIntegratorStepNotNeeded", Type::Boolean)]],
    &[maybe(&[&SOURCE_FILES])],
);
static CO_SIMULATION: Element = element(
    "CoSimulation",
    &[
        INTERFACE,
        &[
            optional("canHandleVariableCommunicationStepSize", Type::Boolean),
            optional("canInterpolateInputs", Type::Boolean),
            optional("maxOutputDerivativeOrder", UNSIGNED_INT),
            optional("canRunAsynchronuously", Type::Boolean),
        ],
    ],
    &[maybe(&[&SOURCE_FILES])],
);

pub(super) const DESCRIPTION: &[Attribute] = &[
    required("modelName", Type::Text),
    optional("description", Type::Text),
    optional("author", Type::Text),
    optional("version", Type::Text),
    optional("copyright", Type::Text),
    optional("license", Type::Text),
    optional("generationTool", Type::Text),
    optional("generationDateAndTime", Type::DateTime),
    optional("variableNamingConvention", Type::Words(&["flat", "structured"])),
];

/// The root element.
pub(crate) static MODEL_DESCRIPTION: Element = element(
    "fmiModelDescription",
    &[
        DESCRIPTION,
        &[
            required("fmiVersion", Type::Words(&["2.0"])),
            required("guid", Type::Text),
            optional("numberOfEventIndicators", UNSIGNED_INT),
        ],
    ],
    &[
        // The schema repeats the sequence (ModelExchange?, CoSimulation?) up to twice: either order is allowed.
        Slot { choices: &[&MODEL_EXCHANGE, &CO_SIMULATION], least: 0, most: 2 },
        maybe(&[&UNIT_DEFINITIONS]),
        maybe(&[&TYPE_DEFINITIONS]),
        maybe(&[&LOG_CATEGORIES]),
        maybe(&[&DEFAULT_EXPERIMENT]),
        maybe(&[&VENDOR_ANNOTATIONS]),
        once(&[&MODEL_VARIABLES]),
        once(&[&MODEL_STRUCTURE]),
    ],
);
