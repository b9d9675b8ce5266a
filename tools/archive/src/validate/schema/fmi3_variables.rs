//! The types and variables of FMI 3.0, after `fmi3Type.xsd`, `fmi3Variable.xsd` and `fmi3AttributeGroups.xsd`.
//!
//! The ten numeric kinds differ only in their name and number type; a macro writes their tables.

use super::fmi3_common::{ANNOTATED, ANNOTATIONS, NAME_AND_DESCRIPTION};
use super::types::*;
use super::*;

const VARIABLE: &[Attribute] = &[
    required("name", Type::Text),
    required("valueReference", UNSIGNED_INT),
    optional("description", Type::Text),
    optional(
        "causality",
        Type::Words(&[
            "parameter",
            "calculatedParameter",
            "input",
            "output",
            "local",
            "independent",
            "structuralParameter",
        ]),
    ),
    optional("variability", Type::Words(&["constant", "fixed", "tunable", "discrete", "continuous"])),
    optional("canHandleMultipleSetPerTimeInstant", Type::Boolean),
    optional("clocks", Type::List(&UNSIGNED_INT)),
];
const ARRAYABLE: &[Attribute] = &[
    optional("intermediateUpdate", Type::Boolean),
    optional("previous", UNSIGNED_INT),
    optional("initial", Type::Words(&["exact", "approx", "calculated"])),
];
const DECLARED: &[Attribute] = &[optional("declaredType", Type::Text)];
const QUANTITY: &[Attribute] = &[optional("quantity", Type::Text)];
const REAL: &[Attribute] = &[
    optional("quantity", Type::Text),
    optional("unit", Type::Text),
    optional("displayUnit", Type::Text),
    optional("relativeQuantity", Type::Boolean),
    optional("unbounded", Type::Boolean),
];
const REAL_VARIABLE: &[Attribute] =
    &[optional("derivative", UNSIGNED_INT), optional("reinit", Type::Boolean)];
const BINARY: &[Attribute] = &[optional("mimeType", Type::Text), optional("maxSize", Type::NonNegative)];
const CLOCK_TYPE: &[Attribute] = &[
    optional("canBeDeactivated", Type::Boolean),
    optional("priority", UNSIGNED_INT),
    required(
        "intervalVariability",
        Type::Words(&["constant", "fixed", "tunable", "changing", "countdown", "triggered"]),
    ),
    optional("intervalDecimal", Type::Float),
    optional("shiftDecimal", Type::Float),
    optional("supportsFraction", Type::Boolean),
    optional("resolution", UNSIGNED_LONG),
    optional("intervalCounter", UNSIGNED_LONG),
    optional("shiftCounter", UNSIGNED_LONG),
];

static DIMENSION: Element = element(
    "Dimension",
    &[&[optional("start", UNSIGNED_LONG), optional("valueReference", UNSIGNED_INT)]],
    &[],
);
static ALIAS: Element = element("Alias", &[NAME_AND_DESCRIPTION], &[]);
static FLOAT_ALIAS: Element =
    element("Alias", &[NAME_AND_DESCRIPTION, &[optional("displayUnit", Type::Text)]], &[]);
static STRING_START: Element = element("Start", &[&[optional("value", Type::Text)]], &[]);
static BINARY_START: Element = element("Start", &[&[optional("value", Type::HexBinary)]], &[]);

static PLAIN: [Slot; 3] = [maybe(&[&ANNOTATIONS]), any_number(&[&DIMENSION]), any_number(&[&ALIAS])];
static FLOATING: [Slot; 3] = [maybe(&[&ANNOTATIONS]), any_number(&[&DIMENSION]), any_number(&[&FLOAT_ALIAS])];

macro_rules! numeric {
    ($module:ident, $kind:literal, $type_name:literal, $number:expr, $common:expr, $own:expr, $variable:expr, $slots:expr) => {
        mod $module {
            use super::*;
            static NUMBER: Type = $number;
            const LIMITS: &[Attribute] = &[optional("min", $number), optional("max", $number)];
            pub(super) static VARIABLE_ELEMENT: Element = element(
                $kind,
                &[
                    VARIABLE,
                    ARRAYABLE,
                    DECLARED,
                    $common,
                    LIMITS,
                    $own,
                    $variable,
                    &[optional("start", Type::List(&NUMBER))],
                ],
                $slots,
            );
            pub(super) static TYPE_ELEMENT: Element =
                element($type_name, &[NAME_AND_DESCRIPTION, $common, LIMITS, $own], &ANNOTATED);
        }
    };
    ($module:ident, $kind:literal, $type_name:literal, $number:expr) => {
        numeric!($module, $kind, $type_name, $number, QUANTITY, &[], &[], &PLAIN);
    };
}

const FLOAT_NOMINAL: &[Attribute] = &[optional("nominal", Type::Float)];
const DOUBLE_NOMINAL: &[Attribute] = &[optional("nominal", Type::Double)];
numeric!(float32, "Float32", "Float32Type", Type::Float, REAL, FLOAT_NOMINAL, REAL_VARIABLE, &FLOATING);
numeric!(float64, "Float64", "Float64Type", Type::Double, REAL, DOUBLE_NOMINAL, REAL_VARIABLE, &FLOATING);
numeric!(int8, "Int8", "Int8Type", BYTE);
numeric!(uint8, "UInt8", "UInt8Type", UNSIGNED_BYTE);
numeric!(int16, "Int16", "Int16Type", SHORT);
numeric!(uint16, "UInt16", "UInt16Type", UNSIGNED_SHORT);
numeric!(int32, "Int32", "Int32Type", INT);
numeric!(uint32, "UInt32", "UInt32Type", UNSIGNED_INT);
numeric!(int64, "Int64", "Int64Type", LONG);
numeric!(uint64, "UInt64", "UInt64Type", UNSIGNED_LONG);

static BOOLEAN: Element = element(
    "Boolean",
    &[VARIABLE, ARRAYABLE, DECLARED, &[optional("start", Type::List(&Type::Boolean))]],
    &PLAIN,
);
static STRING: Element = element(
    "String",
    &[VARIABLE, ARRAYABLE, DECLARED],
    &[maybe(&[&ANNOTATIONS]), any_number(&[&DIMENSION]), any_number(&[&STRING_START]), any_number(&[&ALIAS])],
);
static BINARY_VARIABLE: Element = element(
    "Binary",
    &[VARIABLE, ARRAYABLE, DECLARED, BINARY],
    &[maybe(&[&ANNOTATIONS]), any_number(&[&DIMENSION]), any_number(&[&BINARY_START]), any_number(&[&ALIAS])],
);
static ENUMERATION: Element = element(
    "Enumeration",
    &[
        VARIABLE,
        ARRAYABLE,
        &[required("declaredType", Type::Text)],
        QUANTITY,
        &[optional("min", LONG), optional("max", LONG), optional("start", Type::List(&LONG))],
    ],
    &PLAIN,
);
static CLOCK: Element =
    element("Clock", &[VARIABLE, DECLARED, CLOCK_TYPE], &[maybe(&[&ANNOTATIONS]), any_number(&[&ALIAS])]);

/// The choice of variables.
pub(super) const VARIABLES: &[&Element] = &[
    &float32::VARIABLE_ELEMENT,
    &float64::VARIABLE_ELEMENT,
    &int8::VARIABLE_ELEMENT,
    &uint8::VARIABLE_ELEMENT,
    &int16::VARIABLE_ELEMENT,
    &uint16::VARIABLE_ELEMENT,
    &int32::VARIABLE_ELEMENT,
    &uint32::VARIABLE_ELEMENT,
    &int64::VARIABLE_ELEMENT,
    &uint64::VARIABLE_ELEMENT,
    &BOOLEAN,
    &STRING,
    &BINARY_VARIABLE,
    &ENUMERATION,
    &CLOCK,
];

static ITEM: Element = element("Item", &[NAME_AND_DESCRIPTION, &[required("value", LONG)]], &ANNOTATED);
static BOOLEAN_TYPE: Element = element("BooleanType", &[NAME_AND_DESCRIPTION], &ANNOTATED);
static STRING_TYPE: Element = element("StringType", &[NAME_AND_DESCRIPTION], &ANNOTATED);
static BINARY_TYPE: Element = element("BinaryType", &[NAME_AND_DESCRIPTION, BINARY], &ANNOTATED);
static ENUMERATION_TYPE: Element = element(
    "EnumerationType",
    &[NAME_AND_DESCRIPTION, QUANTITY, &[optional("min", LONG), optional("max", LONG)]],
    &[maybe(&[&ANNOTATIONS]), at_least_one(&[&ITEM])],
);
static CLOCK_TYPE_ELEMENT: Element = element("ClockType", &[NAME_AND_DESCRIPTION, CLOCK_TYPE], &ANNOTATED);

/// The choice of type definitions.
pub(super) const TYPES: &[&Element] = &[
    &float32::TYPE_ELEMENT,
    &float64::TYPE_ELEMENT,
    &int8::TYPE_ELEMENT,
    &uint8::TYPE_ELEMENT,
    &int16::TYPE_ELEMENT,
    &uint16::TYPE_ELEMENT,
    &int32::TYPE_ELEMENT,
    &uint32::TYPE_ELEMENT,
    &int64::TYPE_ELEMENT,
    &uint64::TYPE_ELEMENT,
    &BOOLEAN_TYPE,
    &STRING_TYPE,
    &BINARY_TYPE,
    &ENUMERATION_TYPE,
    &CLOCK_TYPE_ELEMENT,
];
