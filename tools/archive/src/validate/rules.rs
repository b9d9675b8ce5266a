//! Every rule of the validator, in one table: code, severity, title, and the sections of the two standards.
//!
//! An empty section means that the standard has no such rule and the check is one of common sense.

use serde::Serialize;

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A breach of the standard or of the FMU's own declarations.
    Error,
    /// Doubtful practice: allowed, but a known source of trouble.
    Warning,
    /// Information.
    Note,
}

/// A rule.
#[derive(Debug)]
pub struct Rule {
    /// Short and unique code of a finding.
    pub code: &'static str,
    /// Severity of a breach.
    pub severity: Severity,
    /// The condition in a few words.
    pub title: &'static str,
    /// Section of FMI 2.0 (numbering of 2.0.4).
    pub fmi2: &'static str,
    /// Section of FMI 3.0.
    pub fmi3: &'static str,
}

macro_rules! rules {
    ($($name:ident $code:literal $severity:ident $title:literal $fmi2:literal $fmi3:literal;)*) => {
        $(
            #[doc = $title]
            pub static $name: Rule = Rule {
                code: $code, severity: Severity::$severity, title: $title, fmi2: $fmi2, fmi3: $fmi3,
            };
        )*
        /// All rules, in the order in which they are checked.
        pub static ALL: &[&Rule] = &[$(&$name),*];
    };
}

/// Whether an FMU that breaks this rule can still be read: all but the rules on archive, XML and schemas.
pub(super) fn leaves_readable(code: &str) -> bool {
    let place = |code: &str| ALL.iter().position(|r| r.code == code);
    place(code) >= place(INTERFACE_MISSING.code)
}

rules! {
    // The archive.
    EXTENSION "file-extension" Warning "the archive's name ends in .fmu" "2.3" "2.5";
    ARCHIVE_SPANNED "archive-spanned" Error "the archive is one file" "2.3" "2.5";
    ARCHIVE_BOMB "archive-bomb" Error "the archive unpacks to a sensible size" "" "";
    ENTRY_DUPLICATE "entry-duplicate" Error "an entry name occurs once" "" "";
    ENTRY_CASE "entry-case" Warning "entry names differ in more than case" "" "";
    ENTRY_BACKSLASH "entry-backslash" Error "only / separates folders" "2.3" "2.5";
    ENTRY_ABSOLUTE "entry-absolute" Error "entry names are relative" "2.3" "2.5";
    ENTRY_OUTSIDE "entry-outside" Error "entries stay inside the folder they are unpacked to" "" "";
    ENTRY_NOT_ASCII "entry-not-ascii" Warning "entry names are plain ASCII" "2.3" "2.5";
    ENTRY_UNPORTABLE "entry-unportable" Warning "entry names are allowed on every system" "" "";
    ENTRY_ENCRYPTED "entry-encrypted" Error "nothing is encrypted" "2.3" "2.5";
    ENTRY_METHOD "entry-method" Error "entries are stored or deflated" "2.3" "2.5";
    ENTRY_VERSION "entry-version" Error "zip version 2.0 is enough to extract" "2.3" "2.5";
    ENTRY_DESCRIPTOR "entry-descriptor" Error "stored entries do not set general purpose bit 3" "2.3" "2.5";
    ENTRY_LINK "entry-link" Error "the archive has no links" "2.3" "2.5";
    ENTRY_HEADER "entry-header" Error "directory and entry agree on the name" "" "";
    ENTRY_DAMAGED "entry-damaged" Error "every entry can be unpacked" "" "";
    DESCRIPTION_MISSING "model-description-missing" Error "modelDescription.xml is at the root" "2.3" "2.5.1";
    // XML.
    XML_NOT_UTF8 "xml-not-utf8" Error "XML files are UTF-8 text" "2.2" "2.4";
    XML_ENCODING "xml-encoding" Error "XML files declare the encoding UTF-8" "2.2" "2.4";
    XML_DOCTYPE "xml-doctype" Error "XML files have no document type declaration" "" "";
    XML_MALFORMED "xml-malformed" Error "XML files are well-formed" "2.2" "2.4";
    XML_DEPTH "xml-depth" Error "XML elements are not nested without end" "" "";
    VERSION "fmi-version" Error "fmiVersion is 2.0 or 3.0" "2.2.1" "2.4.1";
    VERSION_NEWER "fmi-version-newer" Note "fmiVersion is 3.0" "" "2.4.1";
    // The schemas.
    XSD_ROOT "xsd-root" Error "the root element is the right one" "2.2.1" "2.4.1";
    XSD_ELEMENT_UNKNOWN "xsd-element-unknown" Error "only elements of the schema" "2.2" "2.4";
    XSD_ELEMENT_ORDER "xsd-element-order" Error "elements are in the schema's order" "2.2" "2.4";
    XSD_ELEMENT_REPEATED "xsd-element-repeated" Error "elements occur as often as the schema allows" "2.2" "2.4";
    XSD_ELEMENT_MISSING "xsd-element-missing" Error "required elements are present" "2.2" "2.4";
    XSD_TEXT "xsd-text" Error "no text between elements" "2.2" "2.4";
    XSD_ATTRIBUTE_UNKNOWN "xsd-attribute-unknown" Error "only attributes of the schema" "2.2" "2.4";
    XSD_ATTRIBUTE_MISSING "xsd-attribute-missing" Error "required attributes are present" "2.2" "2.4";
    XSD_ATTRIBUTE_VALUE "xsd-attribute-value" Error "attribute values have the schema's type" "2.2" "2.4";
    CAPABILITY_UNKNOWN "capability-unknown" Warning "capability flags are known or have a namespace" "" "2.4.2";
    // Interface types.
    INTERFACE_MISSING "interface-missing" Error "at least one interface type is present" "2.2.1" "2.4.1";
    INTERFACE_REPEATED "interface-repeated" Error "each interface type is present once" "2.2.1" "2.4.1";
    MODEL_IDENTIFIER "model-identifier" Error "modelIdentifier is a C identifier" "3.3.1" "2.4.2";
    MODEL_IDENTIFIER_LONG "model-identifier-long" Warning "modelIdentifier is short" "3.3.1" "2.4.2";
    CAPABILITY_REQUIRES "capability-requires" Error "capability flags have what they require" "3.3.1" "2.4.2";
    INTERNAL_STEP "internal-step" Error "fixedInternalStepSize is positive" "" "4.4";
    // The document.
    TOKEN_EMPTY "token-empty" Error "guid or instantiationToken is not empty" "2.2.1" "2.4.1";
    MODEL_NAME_EMPTY "model-name-empty" Warning "modelName is not empty" "2.2.1" "2.4.1";
    DATE_FORM "date-form" Warning "generationDateAndTime is in UTC, without fractions" "2.2.1" "2.4.1";
    DEFAULT_EXPERIMENT "default-experiment" Error "the default experiment can be run" "2.2.5" "2.4.6";
    EXPERIMENT_STEP_LONG "experiment-step-long" Warning "stepSize fits into the default experiment" "2.2.5" "2.4.6";
    LOG_CATEGORY_REPEATED "log-category-repeated" Error "log categories have unique names" "2.2.4" "2.4.5";
    ANNOTATION_REPEATED "annotation-repeated" Error "tools of vendor annotations have unique names" "2.2.6" "";
    // Names and references.
    NAME_EMPTY "name-empty" Error "variable names are not empty" "2.2.9" "2.4.7.5.1";
    NAME_REPEATED "name-repeated" Error "variable names are unique, aliases included" "2.2.7" "2.4.7.4";
    NAME_SYNTAX "name-syntax" Error "structured names follow the grammar" "2.2.9" "2.4.7.5.1";
    NAME_CONTROL "name-control" Error "names have no line breaks or tabs" "2.2.9" "2.4.7.5.1";
    REFERENCE_REPEATED "value-reference-repeated" Error "value references are unique" "" "2.4.7.4";
    TYPE_NAME_CLASH "type-name-clash" Error "types and variables have different names" "2.2.3" "2.4.4";
    // Units.
    UNIT_NAME_EMPTY "unit-name-empty" Error "unit names are not empty" "" "2.4";
    UNIT_REPEATED "unit-repeated" Error "unit names are unique" "2.2.2" "2.4.3";
    UNIT_FACTOR "unit-factor" Error "factors are not zero, factors and offsets are finite" "2.2.2" "2.4.3";
    DISPLAY_UNIT_REPEATED "display-unit-repeated" Error "display units of a unit have unique names" "2.2.2" "2.4.3";
    DISPLAY_UNIT_INVERSE "display-unit-inverse" Error "inverse display units have no offset" "" "2.4.3";
    UNIT_UNDEFINED "unit-undefined" Error "units are defined" "2.2.3" "2.4.4";
    DISPLAY_UNIT_ALONE "display-unit-alone" Error "a display unit comes with a unit" "2.2.3" "2.4.4";
    DISPLAY_UNIT_UNDEFINED "display-unit-undefined" Error "display units belong to the unit" "" "2.4.4";
    DISPLAY_UNIT_IGNORED "display-unit-ignored" Warning "display units belong to the unit, or are ignored" "2.2.3" "";
    RELATIVE_WITHOUT_UNIT "relative-without-unit" Warning "relativeQuantity comes with a unit" "2.2.3" "2.4.4";
    // Types.
    TYPE_NAME_EMPTY "type-name-empty" Error "type names are not empty" "2.2.3" "2.4.4";
    TYPE_REPEATED "type-repeated" Error "type names are unique" "2.2.3" "2.4.4";
    ITEM_REPEATED "item-repeated" Error "names and values of enumeration items are unique" "2.2.3" "2.4.4";
    TYPE_UNDEFINED "type-undefined" Error "declared types are defined" "2.2.7" "2.4.7.5";
    TYPE_MISMATCH "type-mismatch" Error "declared types fit the variable" "2.2.7" "2.4.7.5";
    // Variables.
    CAUSALITY_VARIABILITY "causality-variability" Error "causality and variability may be combined" "2.2.7" "2.4.7.4";
    CONTINUOUS_NOT_FLOAT "continuous-not-float" Error "only real variables are continuous" "2.2.7" "2.4.7.4";
    INITIAL_FORBIDDEN "initial-forbidden" Error "initial is absent where it must be" "2.2.7" "2.4.7.5";
    INITIAL_NOT_ALLOWED "initial-not-allowed" Error "initial fits causality and variability" "2.2.7" "2.4.7.5";
    START_MISSING "start-missing" Error "a start value is present where required" "2.2.7" "2.4.7.5";
    START_FORBIDDEN "start-forbidden" Error "a start value is absent where forbidden" "2.2.7" "2.4.7.5";
    MULTIPLE_SET_NOT_INPUT "multiple-set-not-input" Error "canHandleMultipleSetPerTimeInstant is for inputs" "2.2.7" "2.4.7.4";
    MODEL_EXCHANGE_ONLY "model-exchange-only" Error "attributes of Model Exchange need that interface" "2.2.7" "";
    REINIT_NOT_STATE "reinit-not-state" Error "reinit is for continuous states" "2.2.7" "2.4.7.5";
    INTERMEDIATE_UPDATE "intermediate-update" Error "intermediateUpdate is for continuous variables" "" "2.4.7.4";
    INDEPENDENT_NOT_FLOAT "independent-not-float" Error "the independent variable is a real number" "2.2.7" "2.4.7.4";
    INDEPENDENT_REPEATED "independent-repeated" Error "there is one independent variable" "2.2.7" "2.4.7.4";
    INDEPENDENT_MISSING "independent-missing" Error "there is an independent variable" "" "2.4.7.4";
    // Values.
    LIMIT_NAN "limit-nan" Error "min and max are numbers" "2.2.3" "2.4.4";
    LIMITS_CROSSED "limits-crossed" Error "min is not above max" "2.2.3" "2.4.4";
    START_OUTSIDE "start-outside" Error "start lies within min and max" "2.2.3" "2.4.4";
    VALUE_SPECIAL "value-special" Error "FMI 2 allows neither NaN nor INF as a value" "2.2" "";
    START_NOT_FINITE "start-not-finite" Warning "start is a finite number" "" "";
    START_NO_ITEM "start-no-item" Error "start of an enumeration is one of its items" "2.2.7" "2.4.7.5";
    NOMINAL_STATE "nominal-state" Error "nominal values of states are positive" "3.2.2" "2.3.3";
    NOMINAL_DOUBTFUL "nominal-doubtful" Warning "nominal values are positive" "" "";
    // The model structure.
    UNKNOWN_REFERENCE "unknown-reference" Error "entries of the model structure exist" "2.2.8" "2.4.8";
    UNKNOWN_REPEATED "unknown-repeated" Error "a variable is listed once in a list" "2.2.8" "2.4.8";
    OUTPUT_NOT_LISTED "output-not-listed" Error "every output is listed" "2.2.8" "2.4.8";
    OUTPUT_CAUSALITY "output-causality" Error "only outputs are listed as such" "2.2.8" "2.4.8";
    EVENT_INDICATOR "event-indicator" Error "event indicators are continuous, local or output" "" "2.4.8";
    DEPENDENCIES_ORDER "dependencies-order" Warning "dependencies are in the order of indices" "2.2.8" "";
    DEPENDENCY_REPEATED "dependency-repeated" Warning "a dependency is listed once" "" "";
    DEPENDENCY_REFERENCE "dependency-reference" Error "dependencies exist" "2.2.8" "2.4.8";
    DEPENDENCY_NOT_KNOWN "dependency-not-known" Error "dependencies are knowns" "2.2.8" "2.4.8";
    KIND_ALONE "dependencies-kind-alone" Error "dependenciesKind comes with dependencies" "2.2.8" "2.4.8";
    KIND_LENGTH "dependencies-kind-length" Error "dependenciesKind is as long as dependencies" "2.2.8" "2.4.8";
    KIND_INITIAL "dependencies-kind-initial" Error "initial unknowns use dependent and constant only" "2.2.8" "2.4.8";
    // The standard forbids it, but the official reference FMUs do it.
    KIND_NOT_FLOAT "dependencies-kind-not-float" Warning "other kinds than dependent are for real numbers" "2.2.8" "2.4.8";
    INITIAL_UNKNOWN_MISSING "initial-unknown-missing" Error "every initial unknown is listed" "2.2.8" "2.4.8";
    INITIAL_UNKNOWN_WRONG "initial-unknown-wrong" Error "only initial unknowns are listed as such" "2.2.8" "2.4.8";
    INITIAL_UNKNOWNS_ORDER "initial-unknowns-order" Error "initial unknowns are in the order of indices" "2.2.8" "";
    // States.
    DERIVATIVE_REFERENCE "derivative-reference" Error "the variable of a derivative exists" "2.2.7" "2.4.7.5";
    DERIVATIVE_CYCLE "derivative-cycle" Error "no variable is a derivative of itself" "2.2.7" "2.4.7.5";
    DERIVATIVE_TARGET "derivative-target" Error "only continuous real variables have derivatives" "2.2.7" "2.4.7.5";
    DERIVATIVE_NAME "derivative-name" Error "der(x) is the derivative of x" "2.2.9" "2.4.7.5.1";
    DERIVATIVE_NAME_DOUBTFUL "derivative-name-doubtful" Warning "der(x) is the derivative of x, also in flat names" "" "";
    DERIVATIVE_NOT_CONTINUOUS "derivative-not-continuous" Error "state derivatives are continuous real variables" "2.2.8" "2.4.8";
    DERIVATIVE_MISSING "derivative-missing" Error "state derivatives name their state" "2.2.8" "2.4.8";
    DERIVATIVE_NOT_LISTED "derivative-not-listed" Warning "Model Exchange lists the derivatives of all states" "2.2.8" "2.4.8";
    DERIVATIVE_UNIT "derivative-unit" Error "a derivative has its state's unit per second" "2.2.7" "2.4.7.5";
    DERIVATIVE_UNIT_TIMELESS "derivative-unit-timeless" Warning "a derivative's unit has the time in it" "2.2.7" "2.4.7.5";
    DERIVATIVE_SIZE "derivative-size" Error "state and derivative have the same size" "" "2.4.8";
    STATE_REPEATED "state-repeated" Error "a state has one derivative" "2.2.8" "2.4.8";
    STATE_CAUSALITY "state-causality" Error "states are local or output" "2.2.7" "2.4.7.4";
    // FMI 2 aliases.
    ALIAS_START "alias-start" Error "only one variable of an alias set is free" "2.2.7" "";
    ALIAS_CONSTANT "alias-constant" Error "constants are aliases of equal constants only" "2.2.7" "";
    ALIAS_UNIT "alias-unit" Error "aliases have the same unit" "2.2.7" "";
    // FMI 3 arrays and clocks.
    STRUCTURAL_ARRAY "structural-array" Error "structural parameters are scalars" "" "2.4.7.4";
    DIMENSION "dimension" Error "dimensions have a positive size, fixed or by structural parameter" "" "2.4.7.2";
    START_COUNT "start-count" Error "an array has one start value, or one for each element" "" "2.4.7.5";
    CLOCK_CAUSALITY "clock-causality" Error "clocks are input, output or local" "" "2.4.7.4";
    CLOCK_VARIABILITY "clock-variability" Error "clocks are discrete" "" "2.4.7.4";
    CLOCK_INTERVAL "clock-interval" Error "the interval fits the kind of clock" "" "2.4.4";
    CLOCK_PRIORITY "clock-priority" Error "priority where Scheduled Execution needs it, not on output clocks" "" "2.4.4";
    CLOCKS "clocks" Error "clocked variables name clocks" "" "2.4.7.4";
    PREVIOUS "previous" Error "previous values fit" "" "2.4.7.4";
    CLOCKED_STATE "clocked-state" Error "clocked states have a clock and a previous value" "" "2.4.8";
    CLOCKS_WITHOUT_EVENTS "clocks-without-events" Error "Co-Simulation with clocks has event mode" "" "4.4";
    // Other files.
    NO_IMPLEMENTATION "no-implementation" Error "there are binaries or sources" "2.3" "2.5";
    SVG_WITHOUT_PNG "svg-without-png" Error "an SVG picture comes with its PNG" "2.3" "2.5.1";
    DOCUMENTATION_MISSING "documentation-missing" Note "there is documentation" "2.3" "2.5.1.1";
    LICENSE_MISSING "license-missing" Note "there are licences" "2.3" "2.5.1.1.1";
    LICENSE_ENTRY "license-entry" Error "the licence folder has an entry point" "" "2.5.1.1.1";
    TOOL_UNDOCUMENTED "tool-undocumented" Error "a needed tool is documented" "" "2.5.1.1";
    BUILD_DESCRIPTION_MISSING "build-description-missing" Error "sources come with a build description" "" "2.5.1.3";
    SOURCE_FILE_MISSING "source-file-missing" Error "listed source files are present" "2.3" "2.4.10";
    VERSION_MISMATCH "version-mismatch" Error "all XML files have the same fmiVersion" "" "2.4.9";
    BUILD_IDENTIFIER "build-identifier" Error "build configurations are for an interface type" "2.3" "2.4.10";
    BUILD_FALLBACK "build-fallback" Error "one build configuration is the fallback" "2.3" "2.4.10";
    COORDINATE_SYSTEM "coordinate-system" Error "the coordinate system's corners are in order" "2.3" "2.4.9.1";
    TERMINAL_REPEATED "terminal-repeated" Error "terminal names are unique on their level" "2.3" "2.4.9.2";
    TERMINAL_VARIABLE "terminal-variable" Error "terminals refer to variables that exist" "2.3" "2.4.9.2";
    TERMINAL_CAUSALITY "terminal-causality" Error "terminals refer to inputs, outputs and parameters" "2.3" "2.4.9.2";
    MATCHING_RULE "matching-rule" Warning "matching rules are known or in reverse domain notation" "2.3" "2.4.9.2";
    MEMBER_NAME "member-name" Error "members of plugs and buses have unique names" "2.3" "2.4.9.2";
    STREAM_FLOW "stream-flow" Error "a terminal with streams has one flow" "2.3" "2.4.9.2";
    ICON_MISSING "icon-missing" Error "a terminal's icon is present" "2.3" "2.4.9.2";
    // Binaries.
    PLATFORM_OF_FMI2 "platform-of-fmi2" Warning "folders of FMI 3 are platform tuples" "" "2.5.1.4.1";
    PLATFORM_OF_FMI3 "platform-of-fmi3" Warning "folders of FMI 2 have the names of FMI 2" "2.3" "";
    PLATFORM_UNKNOWN "platform-unknown" Note "platform folders are those of the standard" "2.3" "2.5.1.4.1";
    BINARY_MISSING "binary-missing" Error "libraries are named after modelIdentifier" "2.3" "2.5.1";
    BINARY_FORMAT "binary-format" Error "libraries are shared libraries" "2.3" "2.5.1.4";
    BINARY_ARCHITECTURE "binary-architecture" Error "libraries fit their platform folder" "2.3" "2.5.1.4.1";
    SYMBOL_MISSING "symbol-missing" Error "libraries export all functions" "2.3" "2.5";
    // Behaviour: one life.
    NOT_RUN "not-run" Note "the FMU has a library for this platform and needs no other program" "" "";
    LOAD "load" Error "the library can be loaded" "2.3" "2.5.1.4";
    INSTANTIATE "instantiate" Error "the library makes an instance" "2.1.5" "2.3.1";
    VERSION_STRING "version-string" Error "the library returns the version of the standard" "2.1.4" "2.2.5";
    LIFE_CYCLE "life-cycle" Error "calls in the standard's order succeed" "2.1.6" "2.3";
    EVENT_ITERATION "event-iteration" Error "the event iteration ends, and time events are not in the past" "3.2.2" "2.3.5";
    OUTPUT_NOT_FINITE "output-not-finite" Error "outputs are finite at the start values" "" "";
    VALUE_OUTSIDE "value-outside" Error "variables stay within their declared limits" "2.2.3" "2.2.7.3";
    LOG_CATEGORY_UNDECLARED "log-category-undeclared" Warning "messages come in declared categories" "2.1.5" "2.3.1";
    CRASH "crash" Error "no call ends the process" "2.1.3" "2.2.4";
    HANG "hang" Error "every call returns" "" "";
    // Behaviour: values.
    START_DIFFERS "start-differs" Error "variables start at their start values" "2.2.7" "2.4.7.5";
    SET_START "set-start" Error "setting a variable to its own start value changes nothing" "2.2.7" "2.4.7.5";
    SET_ORDER "set-order" Error "the order in which values are set does not matter" "2.1.7" "2.2.7.2";
    SET_LOST "set-lost" Error "a value that was set is kept" "2.1.7" "2.2.7.2";
    GET_CHANGES "get-changes" Error "reading changes nothing" "2.1.7" "2.2.7.2";
    // Behaviour: the same run again.
    NOT_DETERMINISTIC "not-deterministic" Warning "equal calls give equal results in two instances" "" "";
    RESET "reset" Error "a reset instance runs as a new one" "2.1.6" "2.3.1";
    INSTANCES "instances" Error "instances do not disturb each other" "2.1.5" "2.2.1";
    MEMORY "memory" Error "what was allocated is freed" "2.1.5" "2.3.1";
    ROLLBACK "rollback" Error "a saved state restores all values" "2.1.8" "2.2.7.4";
    ROLLBACK_INEXACT "rollback-inexact" Warning "a saved state restores all values bit for bit" "" "";
    SERIALIZE "serialize" Error "serialization does not change a state" "2.1.8" "2.2.7.4";
    STATE_POINTER "state-pointer" Error "freeing a state sets its pointer to NULL" "2.1.8" "2.2.7.4";
    // Behaviour: steps and derivatives.
    STEP_SIZE "step-size" Error "smaller communication steps converge" "4.3.1" "4.4";
    STOP_TIME "stop-time" Error "no step goes past the stop time" "2.1.6" "2.3.2";
    DERIVATIVE_VALUE "derivative-value" Error "a declared derivative equals the time derivative of its variable" "2.2.7" "2.4.7.5";
    OUTPUT_DERIVATIVE "output-derivative" Error "output derivatives equal the time derivatives of the outputs" "4.2.1" "4.1.2";
    INPUT_DERIVATIVE "input-derivative" Error "derivatives of inputs have an effect" "4.3.1" "";
    // Behaviour: Model Exchange.
    STATES_NUMBER "states-number" Error "states and event indicators are as many as declared" "" "2.4.8";
    STATES_ORDER "states-order" Error "states and derivatives are in the order of the model structure" "2.2.8" "2.4.8";
    STATES_KEPT "states-kept" Error "states that were set are kept" "3.2.1" "3.2.1";
    NOMINAL_VALUE "nominal-value" Error "nominal values of states are positive" "3.2.2" "2.3.3";
    EVALUATION_MEMORY "evaluation-memory" Error "derivatives depend on time, states and inputs only" "3.1" "3.1";
    INDICATOR_JUMPS "indicator-jumps" Warning "event indicators are continuous at their zero crossings" "3.1" "3.1.1";
    DIRECTIONAL "directional-derivative" Error "directional derivatives are the derivatives" "2.1.9" "2.2.12.1";
    ADJOINT "adjoint-derivative" Error "adjoint derivatives are the derivatives" "" "2.2.12.2";
    DEPENDENCY_UNDECLARED "dependency-undeclared" Error "unknowns depend on declared dependencies alone" "2.2.8" "2.4.8";
    EXCHANGE_DIFFERS "exchange-differs" Error "Model Exchange and Co-Simulation agree" "" "";
    // Behaviour: reference results in extra/org.fmi-standard.fmi-ls-ref.
    REFERENCE_FILE "reference-file" Warning "files with reference results are present and are tables" "" "";
    REFERENCE_DIFFERS "reference-differs" Error "the FMU reproduces the reference results of its archive" "" "";
    // Behaviour: what importers must not do.
    TOKEN_UNCHECKED "token-unchecked" Warning "a wrong guid or token is refused" "2.1.5" "2.3.1";
    NAN_ACCEPTED "nan-accepted" Note "NaN and infinity are refused" "" "";
    RANGE_UNCHECKED "range-unchecked" Note "values outside the limits are rejected or reported by a warning" "2.2.3" "2.2.7.3";
    REFERENCE_UNCHECKED "reference-unchecked" Error "unknown value references are errors" "2.1.2" "2.2.4";
    CONSTANT_SETTABLE "constant-settable" Error "constants cannot be set" "2.1.2" "2.2.4";
    CRASH_ON_MISUSE "crash-on-misuse" Warning "no wrong call ends the process" "2.1.3" "2.2.4";
    HANG_ON_MISUSE "hang-on-misuse" Warning "every wrong call returns" "" "";
}
