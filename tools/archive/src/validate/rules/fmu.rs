//! The rules that need no running FMU: archive, XML, schemas, model description, other files, binaries.

use super::rules;

rules! {
    // The archive.
    EXTENSION "file-extension" Warning "the archive's name ends in .fmu" "2.3" "2.5"
        extension() "The name of the archive does not end in .fmu";
    ARCHIVE_SPANNED "archive-spanned" Error "the archive is one file" "2.3" "2.5"
        archive_spanned() "The archive is split over several disks";
    ARCHIVE_BOMB "archive-bomb" Error "the archive unpacks to a sensible size" "" ""
        archive_bomb(total, length) "The archive of {length} bytes unpacks to {total} bytes"
        entry_bomb(shown, compressed, size) "The entry \"{shown}\" of {compressed} bytes unpacks to {size} bytes";
    TIME_LIMIT "time-limit" Error "the files can be checked in time" "" ""
        time_limit(seconds) "The static checks of the files take longer than {seconds} s";
    ENTRY_DUPLICATE "entry-duplicate" Error "an entry name occurs once" "" ""
        entry_duplicate(name) "The entry \"{name}\" occurs more than once in the archive";
    ENTRY_CASE "entry-case" Warning "entry names differ in more than case" "" ""
        entry_case(other, name) "The entries \"{other}\" and \"{name}\" differ only in case and overwrite each other where file names do not";
    ENTRY_BACKSLASH "entry-backslash" Error "only / separates folders" "2.3" "2.5";
    ENTRY_ABSOLUTE "entry-absolute" Error "entry names are relative" "2.3" "2.5";
    ENTRY_OUTSIDE "entry-outside" Error "entries stay inside the folder they are unpacked to" "" "";
    ENTRY_NOT_ASCII "entry-not-ascii" Warning "entry names are plain ASCII" "2.3" "2.5";
    ENTRY_UNPORTABLE "entry-unportable" Warning "entry names are allowed on every system" "" "";
    ENTRY_ENCRYPTED "entry-encrypted" Error "nothing is encrypted" "2.3" "2.5"
        entry_encrypted(shown) "The entry \"{shown}\" is encrypted";
    ENTRY_METHOD "entry-method" Error "entries are stored or deflated" "2.3" "2.5"
        entry_method(shown, method) "The entry \"{shown}\" uses compression method {method}; only 0 (store) and 8 (deflate) are allowed";
    ENTRY_VERSION "entry-version" Error "zip version 2.0 is enough to extract" "2.3" "2.5"
        entry_version(shown, major, minor) "The entry \"{shown}\" needs version {major}.{minor} of zip to extract; at most 2.0 is allowed";
    ENTRY_DESCRIPTOR "entry-descriptor" Error "stored entries do not set general purpose bit 3" "2.3" "2.5"
        entry_descriptor(shown) "The stored entry \"{shown}\" has general purpose bit 3 set, which only deflated entries may have";
    ENTRY_LINK "entry-link" Error "the archive has no links" "2.3" "2.5"
        entry_link(shown) "The entry \"{shown}\" is a symbolic link";
    ENTRY_HEADER "entry-header" Error "directory and entry agree on the name" "" ""
        entry_header(shown, local) "The directory calls the entry \"{shown}\", its own header \"{local}\"";
    ENTRY_DAMAGED "entry-damaged" Error "every entry can be unpacked" "" ""
        entry_header_damaged(name) "The entry \"{name}\" cannot be read: its header is damaged"
        entry_damaged(name, what) "The entry \"{name}\" {what}";
    DESCRIPTION_MISSING "model-description-missing" Error "modelDescription.xml is at the root" "2.3" "2.5.1"
        description_unreadable(model_description) "{model_description} cannot be read from the archive"
        description_missing(model_description, hint) "The archive has no {model_description} at its root{hint}";
    // XML.
    XML_NOT_UTF8 "xml-not-utf8" Error "XML files are UTF-8 text" "2.2" "2.4"
        xml_not_utf8() "The file is not UTF-8 text";
    XML_ENCODING "xml-encoding" Error "XML files declare the encoding UTF-8" "2.2" "2.4"
        xml_encoding(short) "The file declares the encoding \"{short}\" instead of UTF-8"
        xml_encoding_missing() "The first line does not declare the encoding UTF-8";
    XML_DOCTYPE "xml-doctype" Error "XML files have no document type declaration" "" ""
        xml_doctype() "The file has a document type declaration, through which entities can be smuggled in";
    XML_MALFORMED "xml-malformed" Error "XML files are well-formed" "2.2" "2.4"
        xml_malformed(error) "The file is not well-formed XML: {error}";
    XML_DEPTH "xml-depth" Error "XML elements are not nested without end" "" ""
        xml_depth(deepest) "The elements are nested deeper than {deepest} levels";
    VERSION "fmi-version" Error "fmiVersion is 2.0 or 3.0" "2.2.1" "2.4.1"
        version(v) "fmiVersion is \"{v}\", which is neither 2.0 nor 3.0";
    VERSION_NEWER "fmi-version-newer" Note "fmiVersion is 3.0" "" "2.4.1"
        version_newer(v) "fmiVersion is \"{v}\"; the file is checked by the rules of 3.0";
    // The schemas.
    XSD_ROOT "xsd-root" Error "the root element is the right one" "2.2.1" "2.4.1"
        xsd_root(tag_name, space, root) "The root element is <{tag_name}>{space} instead of <{root}>";
    XSD_ELEMENT_UNKNOWN "xsd-element-unknown" Error "only elements of the schema" "2.2" "2.4"
        xsd_element_unknown(name, element) "The element <{name}> is not allowed in <{element}>";
    XSD_ELEMENT_ORDER "xsd-element-order" Error "elements are in the schema's order" "2.2" "2.4"
        xsd_element_order(name, join, element) "The element <{name}> must stand before <{join}> in <{element}>";
    XSD_ELEMENT_REPEATED "xsd-element-repeated" Error "elements occur as often as the schema allows" "2.2" "2.4"
        xsd_too_many_children(element, count, most) "<{element}> has {count} child elements, at most {most} is allowed"
        xsd_element_repeated(name, element, most) "The element <{name}> occurs too often in <{element}>: at most {most} allowed";
    XSD_ELEMENT_MISSING "xsd-element-missing" Error "required elements are present" "2.2" "2.4"
        xsd_element_missing(element, join) "<{element}> must contain {join}";
    ATTRIBUTE_HUGE "attribute-huge" Warning "texts have a sensible length" "" ""
        attribute_huge(name, element, length, most)
            "The attribute \"{name}\" in <{element}> has {length} characters; more than {most} are too many for tools that copy it";
    XSD_TEXT "xsd-text" Error "no text between elements" "2.2" "2.4"
        xsd_text(element, trim) "<{element}> contains the text \"{trim}\", but only elements are allowed";
    XSD_ATTRIBUTE_UNKNOWN "xsd-attribute-unknown" Error "only attributes of the schema" "2.2" "2.4"
        xsd_foreign_attribute(name, space, element) "The attribute \"{name}\" of the namespace \"{space}\" is not allowed in <{element}>"
        xsd_attribute_unknown(name, element) "The attribute \"{name}\" is not allowed in <{element}>";
    XSD_ATTRIBUTE_MISSING "xsd-attribute-missing" Error "required attributes are present" "2.2" "2.4"
        xsd_attribute_missing(element, label, attribute) "The element <{element}>{label} lacks the required attribute \"{attribute}\"";
    XSD_ATTRIBUTE_VALUE "xsd-attribute-value" Error "attribute values have the schema's type" "2.2" "2.4"
        xsd_attribute_value(value, name, element, label, describe)
            "The value \"{value}\" of the attribute \"{name}\" in <{element}>{label} is not {describe}";
    CAPABILITY_UNKNOWN "capability-unknown" Warning "capability flags are known or have a namespace" "" "2.4.2"
        capability_unknown(element, name)
            "<{element}> has the attribute \"{name}\", which is not a capability flag of the standard and has no namespace";
    // Interface types.
    INTERFACE_MISSING "interface-missing" Error "at least one interface type is present" "2.2.1" "2.4.1";
    INTERFACE_REPEATED "interface-repeated" Error "each interface type is present once" "2.2.1" "2.4.1"
        interface_repeated(name) "<{name}> is present more than once";
    MODEL_IDENTIFIER "model-identifier" Error "modelIdentifier is a C identifier" "3.3.1" "2.4.2"
        model_identifier(identifier, interface) "The modelIdentifier \"{identifier}\" of <{interface}> is not a C identifier";
    MODEL_IDENTIFIER_LONG "model-identifier-long" Warning "modelIdentifier is short" "3.3.1" "2.4.2"
        model_identifier_long(interface, count, longest_identifier)
            "The modelIdentifier of <{interface}> has {count} characters; more than {longest_identifier} is not a short class name";
    CAPABILITY_REQUIRES "capability-requires" Error "capability flags have what they require" "3.3.1" "2.4.2"
        capability_requires(flag, name, other) "{flag} is true in <{name}>, but {other}, which it requires, is not";
    INTERNAL_STEP "internal-step" Error "fixedInternalStepSize is positive" "" "4.4"
        internal_step(step) "fixedInternalStepSize is {step}, but a step must be greater than 0 and finite";
    // The document.
    TOKEN_EMPTY "token-empty" Error "guid or instantiationToken is not empty" "2.2.1" "2.4.1"
        token_empty(token) "The attribute {token} is empty, so the binary cannot tell whether this file belongs to it";
    MODEL_NAME_EMPTY "model-name-empty" Warning "modelName is not empty" "2.2.1" "2.4.1"
        model_name_empty() "The attribute modelName is empty";
    DATE_FORM "date-form" Warning "generationDateAndTime is in UTC, without fractions" "2.2.1" "2.4.1"
        date_form(date) "generationDateAndTime is \"{date}\" and should have the form 2026-01-31T12:00:00Z";
    DEFAULT_EXPERIMENT "default-experiment" Error "the default experiment can be run" "2.2.5" "2.4.6";
    EXPERIMENT_STEP_LONG "experiment-step-long" Warning "stepSize fits into the default experiment" "2.2.5" "2.4.6"
        experiment_step_long(step, start, stop) "stepSize {step} of the default experiment is longer than the experiment from {start} to {stop}";
    LOG_CATEGORY_REPEATED "log-category-repeated" Error "log categories have unique names" "2.2.4" "2.4.5";
    ANNOTATION_REPEATED "annotation-repeated" Error "tools of vendor annotations have unique names" "2.2.6" "";
    // Names and references.
    NAME_EMPTY "name-empty" Error "variable names are not empty" "2.2.9" "2.4.7.5.1"
        name_empty() "A variable has an empty name";
    NAME_REPEATED "name-repeated" Error "variable names are unique, aliases included" "2.2.7" "2.4.7.4"
        name_repeated(name, first) "The variable name \"{name}\" is already used at {first}";
    NAME_SYNTAX "name-syntax" Error "structured names follow the grammar" "2.2.9" "2.4.7.5.1"
        name_syntax(name) "The variable name \"{name}\" does not follow the naming convention structured";
    NAME_CONTROL "name-control" Error "names have no line breaks or tabs" "2.2.9" "2.4.7.5.1"
        name_control(name) "The variable name \"{name}\" contains a line break or a tab";
    REFERENCE_REPEATED "value-reference-repeated" Error "value references are unique" "" "2.4.7.4"
        reference_repeated(v, reference, other)
            "Variable {v} has the value reference {reference} of variable \"{other}\"; value references must be unique";
    TYPE_NAME_CLASH "type-name-clash" Error "types and variables have different names" "2.2.3" "2.4.4"
        type_name_clash(t, first) "The type {t} has the same name as the variable at {first}";
    // Units.
    UNIT_NAME_EMPTY "unit-name-empty" Error "unit names are not empty" "" "2.4"
        unit_name_empty() "A unit has an empty name";
    UNIT_REPEATED "unit-repeated" Error "unit names are unique" "2.2.2" "2.4.3"
        unit_repeated(name) "The unit \"{name}\" is defined more than once";
    UNIT_FACTOR "unit-factor" Error "factors are not zero, factors and offsets are finite" "2.2.2" "2.4.3"
        unit_factor(name, what, x) "The {name} of the {what} is {x}; no value can be converted with it";
    UNIT_CONTRADICTION "unit-contradiction" Error "a unit with a common name means what the name says" "" ""
        unit_contradiction(what, factor, offset, wanted_factor, wanted_offset)
            "{what} has the factor {factor} and the offset {offset}, but the name says {wanted_factor} and {wanted_offset}";
    UNIT_EXPONENTS "unit-exponents" Error "a unit with a common name has the exponents of its name" "" ""
        unit_exponents(name, exponents, wanted) "The unit \"{name}\" is declared as {exponents}, but its name says {wanted}";
    DISPLAY_UNIT_REPEATED "display-unit-repeated" Error "display units of a unit have unique names" "2.2.2" "2.4.3"
        display_unit_repeated(display_name, name) "The display unit \"{display_name}\" is defined more than once for the unit \"{name}\"";
    DISPLAY_UNIT_INVERSE "display-unit-inverse" Error "inverse display units have no offset" "" "2.4.3"
        display_unit_inverse(display_name) "The display unit \"{display_name}\" is inverse and has an offset; inverse is only allowed without";
    UNIT_UNDEFINED "unit-undefined" Error "units are defined" "2.2.3" "2.4.4"
        unit_undefined(label, unit) "{label} has the unit \"{unit}\", which is not defined in <UnitDefinitions>";
    DISPLAY_UNIT_ALONE "display-unit-alone" Error "a display unit comes with a unit" "2.2.3" "2.4.4"
        display_unit_alone(label, program) "{label} has the display unit \"{program}\" but no unit";
    DISPLAY_UNIT_UNDEFINED "display-unit-undefined" Error "display units belong to the unit" "" "2.4.4"
        display_unit_undefined(label, display, unit)
            "{label} has the display unit \"{display}\", which is not defined for the unit \"{unit}\"";
    DISPLAY_UNIT_IGNORED "display-unit-ignored" Warning "display units belong to the unit, or are ignored" "2.2.3" ""
        display_unit_ignored(label, display, unit)
            "{label} has the display unit \"{display}\", which is not defined for the unit \"{unit}\" and is therefore ignored";
    RELATIVE_WITHOUT_UNIT "relative-without-unit" Warning "relativeQuantity comes with a unit" "2.2.3" "2.4.4"
        type_relative_without_unit(t) "Type {t} has relativeQuantity but no unit, so it has no meaning"
        relative_without_unit(v) "Variable {v} has relativeQuantity but no unit, so it has no meaning";
    // Types.
    TYPE_NAME_EMPTY "type-name-empty" Error "type names are not empty" "2.2.3" "2.4.4"
        type_name_empty() "A type definition has an empty name";
    TYPE_REPEATED "type-repeated" Error "type names are unique" "2.2.3" "2.4.4"
        type_repeated(t) "The type {t} is defined more than once";
    ITEM_REPEATED "item-repeated" Error "names and values of enumeration items are unique" "2.2.3" "2.4.4"
        item_name_repeated(name, t) "The item \"{name}\" occurs more than once in the enumeration {t}"
        item_value_repeated(value, t) "The value {value} occurs more than once in the enumeration {t}";
    TYPE_UNDEFINED "type-undefined" Error "declared types are defined" "2.2.7" "2.4.7.5"
        type_undefined(v, declared) "Variable {v} has the declared type \"{declared}\", which is not defined in <TypeDefinitions>";
    TYPE_MISMATCH "type-mismatch" Error "declared types fit the variable" "2.2.7" "2.4.7.5"
        type_mismatch(v, type_name, declared, defines)
            "Variable {v} is of type {type_name} and cannot have the declared type \"{declared}\", which defines {defines}";
    // Variables.
    CAUSALITY_VARIABILITY "causality-variability" Error "causality and variability may be combined" "2.2.7" "2.4.7.4"
        causality_variability(v, causality, variability, by_default)
            "Variable {v} combines causality {causality} with variability {variability}{by_default}, which is not allowed";
    CONTINUOUS_NOT_FLOAT "continuous-not-float" Error "only real variables are continuous" "2.2.7" "2.4.7.4"
        continuous_not_float(v, type_name, by_default, floats)
            "Variable {v} is of type {type_name} with variability continuous{by_default}; only {floats} may be continuous";
    INITIAL_FORBIDDEN "initial-forbidden" Error "initial is absent where it must be" "2.2.7" "2.4.7.5"
        initial_forbidden(v, causality, initial) "Variable {v} is {causality} and must not have the attribute initial, which is \"{initial}\"";
    INITIAL_NOT_ALLOWED "initial-not-allowed" Error "initial fits causality and variability" "2.2.7" "2.4.7.5"
        initial_not_allowed(v, initial, causality, variability, join)
            "Variable {v} has initial \"{initial}\", but for causality {causality} and variability {variability} only {join} is allowed";
    START_MISSING "start-missing" Error "a start value is present where required" "2.2.7" "2.4.7.5"
        start_missing(v, reason) "Variable {v} has no start value although {reason}";
    START_FORBIDDEN "start-forbidden" Error "a start value is absent where forbidden" "2.2.7" "2.4.7.5"
        independent_with_start(v) "Variable {v} is the independent variable and must not have a start value"
        calculated_with_start(v, how) "Variable {v} has a start value although its initial is calculated{how}";
    MULTIPLE_SET_NOT_INPUT "multiple-set-not-input" Error "canHandleMultipleSetPerTimeInstant is for inputs" "2.2.7" "2.4.7.4"
        multiple_set_not_input(v, causality) "Variable {v} has canHandleMultipleSetPerTimeInstant but is {causality}, not input";
    MODEL_EXCHANGE_ONLY "model-exchange-only" Error "attributes of Model Exchange need that interface" "2.2.7" ""
        multiple_set_without_exchange(v) "Variable {v} has canHandleMultipleSetPerTimeInstant, which must not be present without <ModelExchange>"
        reinit_without_exchange(v) "Variable {v} has reinit, which must not be present without <ModelExchange>";
    REINIT_NOT_STATE "reinit-not-state" Error "reinit is for continuous states" "2.2.7" "2.4.7.5"
        reinit_not_state(v) "Variable {v} has reinit but is not a continuous state";
    INTERMEDIATE_UPDATE "intermediate-update" Error "intermediateUpdate is for continuous variables" "" "2.4.7.4"
        intermediate_update(v, variability) "Variable {v} has intermediateUpdate but its variability is {variability}, not continuous";
    INDEPENDENT_NOT_FLOAT "independent-not-float" Error "the independent variable is a real number" "2.2.7" "2.4.7.4"
        independent_not_float(v, type_name) "Variable {v} is the independent variable and must be a floating point number, not {type_name}";
    INDEPENDENT_REPEATED "independent-repeated" Error "there is one independent variable" "2.2.7" "2.4.7.4"
        independent_repeated(v) "Variable {v} is a second independent variable; only one is allowed";
    INDEPENDENT_MISSING "independent-missing" Error "there is an independent variable" "" "2.4.7.4"
        independent_missing() "No variable has causality independent; exactly one must";
    // Values.
    LIMIT_NAN "limit-nan" Error "min and max are numbers" "2.2.3" "2.4.4"
        limit_nan(name, v) "The {name} of variable {v} is NaN and limits nothing";
    LIMITS_CROSSED "limits-crossed" Error "min is not above max" "2.2.3" "2.4.4"
        limits_crossed(v, min, max) "Variable {v} has min {min} above max {max}";
    START_OUTSIDE "start-outside" Error "start lies within min and max" "2.2.3" "2.4.4"
        start_outside(v, start, min, max)
            "Variable {v} has the start value {start} outside its limits (min {min}, max {max})";
    VALUE_SPECIAL "value-special" Error "FMI 2 allows neither NaN nor INF as a value" "2.2" ""
        value_special(v, text) "Variable {v} has the start value {text}";
    START_NOT_FINITE "start-not-finite" Warning "start is a finite number" "" ""
        start_not_finite(v, text) "Variable {v} has the start value {text}";
    START_NO_ITEM "start-no-item" Error "start of an enumeration is one of its items" "2.2.7" "2.4.7.5"
        start_no_item(v, start, declared)
            "Variable {v} has the start value {start}, which is no item of the enumeration \"{declared}\"";
    NOMINAL_STATE "nominal-state" Error "nominal values of states are positive" "3.2.2" "2.3.3"
        nominal_state(v, nominal) "The continuous state {v} has the nominal value {nominal}; it must be greater than 0";
    NOMINAL_DOUBTFUL "nominal-doubtful" Warning "nominal values are positive" "" ""
        nominal_doubtful(v, nominal) "Variable {v} has the nominal value {nominal}; tools divide by it and expect a number greater than 0";
    // The model structure.
    UNKNOWN_REFERENCE "unknown-reference" Error "entries of the model structure exist" "2.2.8" "2.4.8"
        unknown_reference(list, reference_word, reference) "The list of {list} refers to {reference_word} {reference}, which no variable has";
    UNKNOWN_REPEATED "unknown-repeated" Error "a variable is listed once in a list" "2.2.8" "2.4.8"
        unknown_repeated(index, list) "Variable \"{index}\" is listed more than once among the {list}";
    OUTPUT_NOT_LISTED "output-not-listed" Error "every output is listed" "2.2.8" "2.4.8"
        output_not_listed(v) "Variable {v} is an output but is not listed among the outputs of <ModelStructure>";
    OUTPUT_CAUSALITY "output-causality" Error "only outputs are listed as such" "2.2.8" "2.4.8"
        output_causality(v, causality) "Variable {v} is listed among the outputs but its causality is {causality}";
    EVENT_INDICATOR "event-indicator" Error "event indicators are continuous, local or output" "" "2.4.8"
        event_indicator(v, wrong) "The event indicator {v} {wrong}";
    DEPENDENCIES_ORDER "dependencies-order" Warning "dependencies are in the order of indices" "2.2.8" ""
        dependencies_order(v) "The dependencies of variable {v} are not in the order of their indices";
    DEPENDENCY_REPEATED "dependency-repeated" Warning "a dependency is listed once" "" ""
        dependency_repeated(v, reference_word, reference) "Variable {v} lists {reference_word} {reference} twice among its dependencies";
    DEPENDENCY_REFERENCE "dependency-reference" Error "dependencies exist" "2.2.8" "2.4.8"
        dependency_reference(v, reference_word, reference) "Variable {v} depends on {reference_word} {reference}, which no variable has";
    DEPENDENCY_NOT_KNOWN "dependency-not-known" Error "dependencies are knowns" "2.2.8" "2.4.8"
        dependency_not_known(v, known, variability, causality, mode)
            "Variable {v} depends on {known}, which is {variability} {causality} and not among the knowns {mode}";
    KIND_ALONE "dependencies-kind-alone" Error "dependenciesKind comes with dependencies" "2.2.8" "2.4.8"
        kind_alone(v) "The entry of variable {v} has dependenciesKind but no dependencies";
    KIND_LENGTH "dependencies-kind-length" Error "dependenciesKind is as long as dependencies" "2.2.8" "2.4.8"
        kind_length(v, written, count) "The entry of variable {v} has {written} dependencies but {count} items in dependenciesKind";
    KIND_INITIAL "dependencies-kind-initial" Error "initial unknowns use dependent and constant only" "2.2.8" "2.4.8"
        kind_initial(v, kind) "The initial unknown {v} has the dependenciesKind {kind}; only dependent and constant are allowed there";
    // The standard forbids it, but the official reference FMUs do it.
    KIND_NOT_FLOAT "dependencies-kind-not-float" Warning "other kinds than dependent are for real numbers" "2.2.8" "2.4.8"
        kind_not_float(v, type_name, kind)
            "Variable {v} is of type {type_name} and has the dependenciesKind {kind}, which is meant for floating point numbers";
    INITIAL_UNKNOWN_MISSING "initial-unknown-missing" Error "every initial unknown is listed" "2.2.8" "2.4.8"
        initial_unknown_missing(v) "Variable {v} is calculated during initialisation but is not listed among the initial unknowns";
    INITIAL_UNKNOWN_WRONG "initial-unknown-wrong" Error "only initial unknowns are listed as such" "2.2.8" "2.4.8"
        initial_unknown_wrong(v, causality, initial)
            "Variable {v} is listed among the initial unknowns but is not one: its causality is {causality}, its initial {initial}";
    INITIAL_UNKNOWNS_ORDER "initial-unknowns-order" Error "initial unknowns are in the order of indices" "2.2.8" ""
        initial_unknowns_order(v) "Variable {v} is out of order: initial unknowns must be listed in the order of their indices";
    // States.
    DERIVATIVE_REFERENCE "derivative-reference" Error "the variable of a derivative exists" "2.2.7" "2.4.7.5"
        derivative_reference(v, reference_word, reference) "Variable {v} is the derivative of {reference_word} {reference}, which no variable has";
    DERIVATIVE_CYCLE "derivative-cycle" Error "no variable is a derivative of itself" "2.2.7" "2.4.7.5"
        derivative_cycle(v) "Variable {v} is, over its attribute derivative, a derivative of itself";
    DERIVATIVE_TARGET "derivative-target" Error "only continuous real variables have derivatives" "2.2.7" "2.4.7.5"
        derivative_target(v, state, variability, type_name)
            "Variable {v} is the derivative of {state}, which is {variability} of type {type_name} and has no derivative";
    DERIVATIVE_NAME "derivative-name" Error "der(x) is the derivative of x" "2.2.9" "2.4.7.5.1";
    DERIVATIVE_NAME_DOUBTFUL "derivative-name-doubtful" Warning "der(x) is the derivative of x, also in flat names" "" "";
    DERIVATIVE_NOT_CONTINUOUS "derivative-not-continuous" Error "state derivatives are continuous real variables" "2.2.8" "2.4.8"
        derivative_not_continuous(v, variability, type_name)
            "The state derivative {v} is {variability} of type {type_name}, not a continuous floating point number";
    DERIVATIVE_MISSING "derivative-missing" Error "state derivatives name their state" "2.2.8" "2.4.8"
        derivative_missing(v) "The state derivative {v} has no attribute derivative, so its state is not known";
    DERIVATIVE_NOT_LISTED "derivative-not-listed" Warning "Model Exchange lists the derivatives of all states" "2.2.8" "2.4.8"
        derivative_not_listed(v, state) "Variable {v} is the derivative of the local variable {state} but not listed among the state derivatives";
    DERIVATIVE_UNIT "derivative-unit" Error "a derivative has its state's unit per second" "2.2.7" "2.4.7.5"
        derivative_unit(names) "The second is not the first per second: {names}"
        derivative_factor(factor_state, factor_v, names)
            "The factors {factor_state} and {factor_v} differ between {names}, so the numbers cannot be integrated";
    DERIVATIVE_UNIT_TIMELESS "derivative-unit-timeless" Warning "a derivative's unit has the time in it" "2.2.7" "2.4.7.5"
        derivative_unit_timeless(names) "Time is missing between {names}";
    DERIVATIVE_SIZE "derivative-size" Error "state and derivative have the same size" "" "2.4.8"
        derivative_size(state, elements, v, of_derivative) "The state {state} has {elements} elements but its derivative {v} has {of_derivative}";
    STATE_REPEATED "state-repeated" Error "a state has one derivative" "2.2.8" "2.4.8"
        state_repeated(first, v, state) "The variables \"{first}\" and {v} are both listed as derivative of the state {state}";
    STATE_CAUSALITY "state-causality" Error "states are local or output" "2.2.7" "2.4.7.4"
        state_causality(state, causality) "The continuous state {state} has causality {causality}; it must be local or output";
    // FMI 2 aliases.
    ALIAS_START "alias-start" Error "only one variable of an alias set is free" "2.2.7" ""
        alias_start(one, two, reference)
            "The variables {one} and {two} share the value reference {reference}, but both can be set or have a start value";
    ALIAS_CONSTANT "alias-constant" Error "constants are aliases of equal constants only" "2.2.7" ""
        alias_one_constant(first, other, reference)
            "The variables {first} and {other} share the value reference {reference}, but only one of them is constant"
        alias_constants_differ(first, other, reference)
            "The constants {first} and {other} share the value reference {reference} but have different values";
    ALIAS_UNIT "alias-unit" Error "aliases have the same unit" "2.2.7" ""
        alias_unit(first, unit, other, other_unit, reference)
            "The variables {first} (unit {unit}) and {other} (unit {other_unit}) share the value reference {reference} but not the unit";
    // FMI 3 arrays and clocks.
    STRUCTURAL_ARRAY "structural-array" Error "structural parameters are scalars" "" "2.4.7.4"
        structural_array(v) "The structural parameter {v} must not have dimensions itself";
    DIMENSION "dimension" Error "dimensions have a positive size, fixed or by structural parameter" "" "2.4.7.2"
        dimension(v, what) "A dimension of variable {v} {what}";
    START_COUNT "start-count" Error "an array has one start value, or one for each element" "" "2.4.7.5"
        start_count(v, count, elements) "Variable {v} has {count} start values for {elements} elements; one value for all or one for each is allowed";
    CLOCK_CAUSALITY "clock-causality" Error "clocks are input, output or local" "" "2.4.7.4"
        clock_causality(v, causality) "The clock {v} has causality {causality}; it must be input, output or local";
    CLOCK_VARIABILITY "clock-variability" Error "clocks are discrete" "" "2.4.7.4"
        clock_variability(v, variability) "The clock {v} has variability {variability}; it must be discrete";
    CLOCK_INTERVAL "clock-interval" Error "the interval fits the kind of clock" "" "2.4.4"
        clock_interval(v, what) "The clock {v} {what}";
    CLOCK_PRIORITY "clock-priority" Error "priority where Scheduled Execution needs it, not on output clocks" "" "2.4.4"
        clock_priority_of_output(v) "The output clock {v} must not have a priority"
        clock_priority_missing(v) "The input clock {v} needs a priority in Scheduled Execution";
    CLOCKS "clocks" Error "clocked variables name clocks" "" "2.4.7.4"
        clocks(v, what) "Variable {v} {what}";
    PREVIOUS "previous" Error "previous values fit" "" "2.4.7.4"
        previous(v, what) "Variable {v} {what}";
    CLOCKED_STATE "clocked-state" Error "clocked states have a clock and a previous value" "" "2.4.8"
        clocked_state(v) "The clocked state {v} must have the attributes previous and clocks and must not be a clock";
    CLOCKS_WITHOUT_EVENTS "clocks-without-events" Error "Co-Simulation with clocks has event mode" "" "4.4"
        clocks_without_events() "The FMU has clocks, so hasEventMode of <CoSimulation> must be true";
    // Other files.
    NO_IMPLEMENTATION "no-implementation" Error "there are binaries or sources" "2.3" "2.5"
        no_implementation() "The archive has neither binaries nor sources, so the FMU cannot run";
    SVG_WITHOUT_PNG "svg-without-png" Error "an SVG picture comes with its PNG" "2.3" "2.5.1"
        svg_without_png(svg, png) "The archive has {svg} but not {png}, which it then requires";
    PICTURE_UNREADABLE "picture-unreadable" Error "pictures have the format of their names" "2.3" "2.5.1"
        picture_unreadable(reason) "The file cannot be shown as a picture: {reason}";
    DOCUMENTATION_MISSING "documentation-missing" Note "there is documentation" "2.3" "2.5.1.1";
    LICENSE_MISSING "license-missing" Note "there are licences" "2.3" "2.5.1.1.1";
    LICENSE_ENTRY "license-entry" Error "the licence folder has an entry point" "" "2.5.1.1.1";
    TOOL_UNDOCUMENTED "tool-undocumented" Error "a needed tool is documented" "" "2.5.1.1"
        tool_undocumented() "needsExecutionTool is true, but documentation/externalDependencies.{{txt|html}} does not say which tool";
    BUILD_DESCRIPTION_MISSING "build-description-missing" Note "sources come with a build description" "" "2.4.10"
        build_description_missing(file) "The archive has source files but no {file}, so importers cannot compile them";
    SOURCE_FILE_MISSING "source-file-missing" Error "listed source files are present" "2.3" "2.4.10"
        source_file_missing(name) "The source file \"{name}\" is listed but not in the archive";
    VERSION_MISMATCH "version-mismatch" Error "all XML files have the same fmiVersion" "" "2.4.9"
        version_mismatch(here, there) "fmiVersion is \"{here}\" here and \"{there}\" in modelDescription.xml";
    BUILD_IDENTIFIER "build-identifier" Error "build configurations are for an interface type" "2.3" "2.4.10"
        build_identifier(identifier) "The build configuration is for the modelIdentifier \"{identifier}\", which no interface type has";
    BUILD_FALLBACK "build-fallback" Error "one build configuration is the fallback" "2.3" "2.4.10"
        build_fallback(identifier) "There is more than one build configuration without platform for \"{identifier}\"";
    COORDINATE_SYSTEM "coordinate-system" Error "the coordinate system's corners are in order" "2.3.2" "2.4.9.1.2"
        coordinate_system(low, a, high, b) "{low} = {a} of the coordinate system must be less than {high} = {b}";
    TERMINAL_REPEATED "terminal-repeated" Error "terminal names are unique on their level" "2.3.2" "2.4.9.2.2"
        terminal_repeated(name) "The terminal \"{name}\" is defined more than once on its level";
    TERMINAL_VARIABLE "terminal-variable" Error "terminals refer to variables that exist" "2.3.2" "2.4.9.2.3"
        terminal_variable(terminal, name) "The terminal \"{terminal}\" refers to the variable \"{name}\", which does not exist";
    TERMINAL_CAUSALITY "terminal-causality" Error "terminals refer to inputs, outputs and parameters" "2.3.2" "2.4.9.2.3"
        terminal_causality(terminal, causality, name)
            "The terminal \"{terminal}\" refers to the {causality} variable \"{name}\"; only inputs, outputs and parameters are allowed";
    MATCHING_RULE "matching-rule" Warning "matching rules are known or in reverse domain notation" "2.3.2" "2.4.9.2.2"
        matching_rule(rule, name)
            "The matchingRule \"{rule}\" of the terminal \"{name}\" is neither plug, bus nor sequence nor a name in reverse domain notation";
    MEMBER_NAME "member-name" Error "members of plugs and buses have unique names" "2.3.2" "2.4.9.2.3"
        member_name_missing(name, rule) "A member of the terminal \"{name}\" has no memberName, which the matchingRule {rule} requires"
        member_name_repeated(m, name) "The memberName \"{m}\" occurs more than once in the terminal \"{name}\"";
    STREAM_FLOW "stream-flow" Error "a terminal with streams has one flow" "2.3.2" "2.4.9.2.4"
        stream_flow(name, flows) "The terminal \"{name}\" has stream members and {flows} inflow or outflow members; only one is allowed";
    ICON_MISSING "icon-missing" Error "a terminal's icon is present" "2.3.2" "2.4.9.2.5"
        icon_missing(base, terminal, file) "The icon \"{base}\" of the terminal \"{terminal}\" is not in the archive as {file}";
    // Binaries.
    PLATFORM_OF_FMI2 "platform-of-fmi2" Warning "folders of FMI 3 are platform tuples" "" "2.5.1.4.1"
        platform_of_fmi2(folder) "The folder \"{folder}\" is named as in FMI 2; importers of FMI 3 look for a platform tuple such as x86_64-linux";
    PLATFORM_OF_FMI3 "platform-of-fmi3" Warning "folders of FMI 2 have the names of FMI 2" "2.3" ""
        platform_of_fmi3(folder) "The folder \"{folder}\" is named as in FMI 3; FMI 2 has its own name for this platform";
    PLATFORM_UNKNOWN "platform-unknown" Warning "platform folders are those of the standard" "2.3" "2.5.1.4.1"
        platform_unknown(folder) "The platform folder \"{folder}\" is not one of the standard";
    BINARY_MISSING "binary-missing" Error "libraries are named after modelIdentifier" "2.3" "2.5.1"
        binary_missing(folder, file, identifier, join)
            "The folder binaries/{folder} has no \"{file}\", the library that the modelIdentifier \"{identifier}\" names (it has {join})";
    BINARY_FORMAT "binary-format" Error "libraries are shared libraries" "2.3" "2.5.1.4"
        binary_format(path) "The file {path} is not a shared library of any known format";
    BINARY_ARCHITECTURE "binary-architecture" Error "libraries fit their platform folder" "2.3" "2.5.1.4.1"
        binary_architecture(path, join, folder, architecture, system)
            "The library {path} is machine code of {join}, but the folder {folder} promises {architecture} for {system}";
    SYMBOL_MISSING "symbol-missing" Error "libraries export all functions" "2.3" "2.5"
        symbol_missing(path, count, shown, more, hint) "The library {path} does not export {count} required functions: {shown}{more}{hint}";
}
