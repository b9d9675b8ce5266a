//! The rules on the behaviour of a running FMU.

use super::rules;

rules! {
    // Behaviour: one life.
    NOT_RUN "not-run" Note "the FMU has a library for this platform and needs no other program" "" ""
        not_run(program, error) "The FMU was not run: {program} {error}"
        needs_another_program(interface) "The FMU was not run for {interface}: it needs another program to be installed"
        cannot_run(reason) "The FMU was not run: {reason}";
    LOAD "load" Error "the library can be loaded" "2.3" "2.5.1.4";
    INSTANTIATE "instantiate" Error "the library makes an instance" "2.1.5" "2.3.1"
        refused_with_logging() "The FMU refused to be instantiated with loggingOn = true"
        refused_with_event_mode() "The FMU refused to be instantiated with eventModeUsed = true although hasEventMode is true"
        refused_instance(kind, words) "The FMU refused to be instantiated for {kind}{words}";
    VERSION_RELEASE "version-release" Warning "the library returns the version without its release" "2.1.4" "2.2.5"
        version_release(function, version, wanted) "{function} returns \"{version}\" instead of \"{wanted}\"";
    VERSION_STRING "version-string" Error "the library returns the version of the standard" "2.1.4" "2.2.5"
        version_string(function, version, wanted) "{function} returns \"{version}\" instead of \"{wanted}\""
        types_platform(types) "fmi2GetTypesPlatform returns \"{types}\" instead of \"default\"";
    LIFE_CYCLE "life-cycle" Error "calls in the standard's order succeed" "2.1.6" "2.3"
        call_failed(function, status, kind, now, words) "{function} returned {status} for {kind} at t = {now} s{words}"
        early_return(now) "fmi3DoStep returned early at t = {now} s although the importer did not allow it";
    EVENT_ITERATION "event-iteration" Error "the event iteration ends, and time events are not in the past" "3.2.2" "2.3.5"
        time_event_in_the_past(next, now) "The next time event is at {next} s, before the present time {now} s"
        event_iteration_diverges(now, most_iterations) "The event iteration at t = {now} s does not converge in {most_iterations} iterations";
    OUTPUT_NOT_FINITE "output-not-finite" Warning "outputs are finite at the start values" "" ""
        indicator_not_finite(number, count, value, now) "Event indicator {number} of {count} is {value} at t = {now} s"
        output_not_finite(v, value, when) "Output {v} is {value} {when} with all variables at their start values";
    VALUE_OUTSIDE "value-outside" Error "variables stay within their declared limits" "2.2.3" "2.2.7.3"
        value_outside(v, value, when, limits) "Variable {v} is {value} {when}, outside its limits ({limits})";
    LOG_CATEGORY_UNDECLARED "log-category-undeclared" Warning "messages come in declared categories" "2.1.5" "2.3.1"
        log_category_undeclared(category, text)
            "The FMU logs in the category \"{category}\", which <LogCategories> does not define (message \"{text}\")";
    LOGGER_ENVIRONMENT "logger-environment" Error "messages come with the environment pointer of the importer" "2.1.5" "2.3.1"
        logger_environment(call) "The FMU calls {call} with another environment pointer than the importer's, which it must pass";
    CRASH "crash" Error "no call ends the process" "2.1.3" "2.2.4";
    HANG "hang" Error "every call returns" "4.2.2" "4.2.1";
    // Behaviour: values.
    START_DIFFERS "start-differs" Error "variables start at their start values" "2.2.7" "2.4.7.5"
        start_text_differs(v, text, wanted) "Variable {v} starts at \"{text}\" instead of its start value \"{wanted}\""
        start_differs(v, value, start) "Variable {v} starts at {value} instead of its start value {start}";
    SET_START "set-start" Error "setting a variable to its own start value changes nothing" "2.2.7" "2.4.7.5"
        set_start(difference, first, second, when)
            "Setting every parameter and input to its own start value changes \"{difference}\" from {first} to {second} ({when})";
    SET_ORDER "set-order" Error "the order in which values are set does not matter" "2.1.7" "2.2.7.2";
    SET_LOST "set-lost" Error "a value that was set is kept" "2.1.7" "2.2.7.2"
        set_lost(v, set, kept) "Variable {v} was set to {set} and is {kept} afterwards";
    TUNABLE_REFUSED "tunable-refused" Error "tunable parameters can be set during the run" "2.2.7" "2.4.7.4"
        tunable_refused(v, value, status, now, words)
            "Parameter {v} is tunable, but setting it to {value} at t = {now} s returned {status}{words}";
    GET_CHANGES "get-changes" Error "reading changes nothing" "2.1.7" "2.2.7.2"
        get_changes(v, first, second) "Variable {v} is read as {first} and then as {second}, with only reading calls in between";
    // Behaviour: the same run again.
    NOT_DETERMINISTIC "not-deterministic" Warning "equal calls give equal results in two instances" "" ""
        not_deterministic(name) "Variable \"{name}\" has other values in a second instance after the same calls";
    RESET "reset" Error "a reset instance runs as a new one" "2.1.6" "2.3.1";
    INSTANCES "instances" Error "instances do not disturb each other" "2.1.5" "2.2.1";
    MEMORY "memory" Error "what was allocated is freed" "2.1.5" "2.3.1"
        leak_of_instance(bytes, instances) "Each instance leaks {bytes:.0} bytes after it has been freed ({instances} instances)"
        leak_of_state(bytes) "Each saved state leaks {bytes:.0} bytes after it has been freed"
        leak_of_step(bytes) "Each step leaks {bytes:.0} bytes";
    ROLLBACK "rollback" Error "a saved state restores all values" "2.1.8" "2.2.7.4";
    ROLLBACK_INEXACT "rollback-inexact" Note "a saved state restores all values bit for bit" "" "";
    SERIALIZE "serialize" Error "serialization does not change a state" "2.1.8" "2.2.7.4";
    STATE_POINTER "state-pointer" Error "freeing a state sets its pointer to NULL" "2.1.8" "2.2.7.4"
        state_pointer(name) "{name} does not set the pointer to the freed state to NULL";
    // Behaviour: steps and derivatives.
    STEP_SIZE "step-size" Error "smaller communication steps converge" "4.3.1" "4.4"
        step_size(v, value, t, step, finer)
            "Variable {v} is {value} at t = {t} s with steps of {step} s but {finer} with steps of half that size, and does not converge";
    STOP_TIME "stop-time" Error "no step goes past the stop time" "2.1.6" "2.3.2"
        stop_time(function, now, stop, status)
            "{function} succeeds up to t = {now} s although the stop time was set to {stop} s; it must return {status}";
    DERIVATIVE_VALUE "derivative-value" Error "a declared derivative equals the time derivative of its variable" "2.2.7" "2.4.7.5"
        derivative_value(slope, value, t, given, measured)
            "Variable {slope} is declared to be the derivative of {value}, but from t = {t} s on it is {given} while {value} changes by {measured} per second";
    OUTPUT_DERIVATIVE "output-derivative" Error "output derivatives equal the time derivatives of the outputs" "4.2.1" "4.1.2"
        output_derivative(v, given, t, measured)
            "The derivative of output {v} is given as {given} from t = {t} s on, but it changes by {measured} per second";
    OUTPUT_DERIVATIVE_ORDER "output-derivative-order" Error "output derivatives are given up to the declared order" "4.3.1" "4.3.1"
        output_derivative_order(declared, order, status, words)
            "maxOutputDerivativeOrder is {declared}, but output derivatives of order {order} are not given (status {status}{words})";
    INPUT_DERIVATIVE "input-derivative" Error "derivatives of inputs have an effect" "4.3.1" ""
        input_derivative(v, effect)
            "A derivative of input {v} has no effect although canInterpolateInputs is true (the input itself moves \"{effect}\")";
    // Behaviour: Model Exchange.
    STATES_NUMBER "states-number" Error "states and event indicators are as many as declared" "" "2.4.8"
        states_number(states, indicators, n, declared)
            "The FMU has {states} continuous states and {indicators} event indicators, its model structure {n} and {declared}";
    STATES_ORDER "states-order" Error "states and derivatives are in the order of the model structure" "2.2.8" "2.4.8"
        states_order(v, value, what, entry) "Variable {v} is {value}, but the entry at its place of the vector of continuous {what}s is {entry}";
    STATES_KEPT "states-kept" Error "states that were set are kept" "3.2.1" "3.2.1"
        states_kept(number, set, kept) "Continuous state {number} was set to {set} and is {kept} afterwards";
    NOMINAL_VALUE "nominal-value" Error "nominal values of states are positive" "3.2.2" "2.3.3"
        nominal_value(number, n, value) "The nominal value of continuous state {number} of {n} is {value}";
    EVALUATION_MEMORY "evaluation-memory" Error "derivatives depend on time, states and inputs only" "3.1" "3.1"
        evaluation_memory(number, count, first, second)
            "Derivative {number} of {count} is {first} and, evaluated again at the same time and states, {second}";
    REINIT "reinit" Error "only states with reinit change at events" "2.2.7" "2.4.7.5"
        reinit_undeclared(v, before, after, t)
            "The state {v} changes from {before} to {after} in the event at t = {t} s, but its attribute reinit is not true";
    INDICATOR_JUMPS "indicator-jumps" Warning "event indicators are continuous at their zero crossings" "3.1" "3.1.1"
        indicator_jumps(number, indicators, low, high, t)
            "Event indicator {number} of {indicators} jumps from {low} to {high} at t = {t} s; importers search for its zero crossing";
    DIRECTIONAL "directional-derivative" Error "directional derivatives are the derivatives" "2.1.9" "2.2.12.1";
    ADJOINT "adjoint-derivative" Error "adjoint derivatives are the derivatives" "" "2.2.12.2";
    DEPENDENCY_UNDECLARED "dependency-undeclared" Error "unknowns depend on declared dependencies alone" "2.2.8" "2.4.8"
        dependency_undeclared(unknown, known, derivative)
            "Variable {unknown} depends on \"{known}\" (derivative {derivative}), which is missing in its list of dependencies";
    EXCHANGE_DIFFERS "exchange-differs" Warning "Model Exchange and Co-Simulation agree" "" ""
        exchange_differs(v, exchange, t, cosimulation)
            "Variable {v} is {exchange} at t = {t} s in Model Exchange and {cosimulation} in Co-Simulation, and the difference does not decrease with the step size";
    // Behaviour: reference results in extra/org.fmi-standard.fmi-ls-ref.
    REFERENCE_FILE "reference-file" Warning "files with reference results are present and are tables" "" ""
        reference_file(source) "The file \"{source}\" is missing or no table over time";
    REFERENCE_COLUMN "reference-column" Warning "columns of reference results are variables of the FMU, with a number in each row" "" ""
        reference_column(name) "The column \"{name}\" of the reference results is no variable of the FMU, so it is not compared"
        reference_input_not_finite() "The inputs of the reference results have rows without a finite number, so the results are not compared"
        reference_not_finite(v, t) "The reference results have no finite number for variable {v} at t = {t} s, so that row is not compared";
    REFERENCE_DIFFERS "reference-differs" Error "the FMU reproduces the reference results of its archive" "" ""
        reference_differs(v, value, t, wanted) "Variable {v} is {value} at t = {t} s, but {wanted} in the reference results of the archive";
    // Behaviour: what importers must not do.
    TOKEN_UNCHECKED "token-unchecked" Warning "a wrong guid or token is refused" "2.1.5" "2.3.1"
        token_unchecked(word, foreign) "The FMU accepts the {word} {foreign}, so a library that does not match the description is not detected";
    NAN_ACCEPTED "nan-accepted" Note "NaN and infinity are refused" "" ""
        nan_accepted(v, bad) "Variable {v} accepts the value {bad}, and the FMU steps with status OK";
    RANGE_UNCHECKED "range-unchecked" Note "values outside the limits are rejected or reported by a warning" "2.2.3" "2.2.7.3"
        range_unchecked(v, bad, limits) "Variable {v} accepts {bad}, which is outside its limits ({limits}), with status OK";
    REFERENCE_UNCHECKED "reference-unchecked" Warning "unknown value references are errors" "2.1.2" "2.2.4"
        reference_unchecked(reference, value) "Reading value reference {reference}, which no variable has, gives {value} and no error";
    CONSTANT_SETTABLE "constant-settable" Warning "constants cannot be set" "2.1.2" "2.2.4"
        constant_settable(v) "The constant {v} can be set without an error";
    CRASH_ON_MISUSE "crash-on-misuse" Warning "no wrong call ends the process" "2.1.3" "2.2.4";
    HANG_ON_MISUSE "hang-on-misuse" Warning "every wrong call returns" "" "";
}
