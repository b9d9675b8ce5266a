//! `terminalsAndIcons.xml`, after `fmi3TerminalsAndIcons.xsd` and `fmi3Terminal.xsd`.

use super::fmi3_common::{ANNOTATED, ANNOTATIONS};
use super::types::{Type, UNSIGNED_BYTE};
use super::*;

const CORNERS: &[Attribute] = &[
    required("x1", Type::Double),
    required("y1", Type::Double),
    required("x2", Type::Double),
    required("y2", Type::Double),
];
static COORDINATE_SYSTEM: Element =
    element("CoordinateSystem", &[CORNERS, &[required("suggestedScalingFactorTo_mm", Type::Double)]], &[]);
static ICON: Element = element("Icon", &[CORNERS], &[]);
static GRAPHICAL_REPRESENTATION: Element = element(
    "GraphicalRepresentation",
    &[],
    &[maybe(&[&COORDINATE_SYSTEM]), maybe(&[&ICON]), maybe(&[&ANNOTATIONS])],
);
static MEMBER: Element = element(
    "TerminalMemberVariable",
    &[&[
        required("variableName", Type::Text),
        optional("memberName", Type::Text),
        required("variableKind", Type::Text),
    ]],
    &ANNOTATED,
);
static STREAM_MEMBER: Element = element(
    "TerminalStreamMemberVariable",
    &[&[
        required("inStreamMemberName", Type::Text),
        required("outStreamMemberName", Type::Text),
        required("inStreamVariableName", Type::Text),
        required("outStreamVariableName", Type::Text),
    ]],
    &ANNOTATED,
);
static TERMINAL_GRAPHIC: Element = element(
    "TerminalGraphicalRepresentation",
    &[
        CORNERS,
        &[
            optional("defaultConnectionColor", Type::List(&UNSIGNED_BYTE)),
            optional("defaultConnectionStrokeSize", Type::Double),
            required("iconBaseName", Type::Text),
        ],
    ],
    &ANNOTATED,
);
static TERMINAL: Element = element(
    "Terminal",
    &[&[
        required("name", Type::Text),
        required("matchingRule", Type::Text),
        optional("terminalKind", Type::Text),
        optional("description", Type::Text),
    ]],
    &[
        any_number(&[&MEMBER]),
        any_number(&[&STREAM_MEMBER]),
        any_number(&[&TERMINAL]),
        maybe(&[&TERMINAL_GRAPHIC]),
        maybe(&[&ANNOTATIONS]),
    ],
);
static TERMINALS: Element = element("Terminals", &[], &[at_least_one(&[&TERMINAL])]);

/// The root element.
pub(crate) static TERMINALS_AND_ICONS: Element = element(
    "fmiTerminalsAndIcons",
    &[&[required("fmiVersion", Type::Version3)]],
    &[maybe(&[&GRAPHICAL_REPRESENTATION]), maybe(&[&TERMINALS]), maybe(&[&ANNOTATIONS])],
);
