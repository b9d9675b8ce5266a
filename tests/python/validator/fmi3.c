/* The C interface of FMI 3.0 for the oscillator, written after the standard's text: Model Exchange and Co-Simulation. */
#include "oscillator.h"
#include <stdbool.h>
#include <stdint.h>

typedef uint32_t VR;
typedef void (*Logger)(void *, int, const char *, const char *);
enum { OK, WARNING, DISCARD, ERROR, FATAL };

static int say(Instance *c, int status, const char *text) {
    if (c->logging || status >= DISCARD)
        ((Logger)c->logger)(c->environment, status, fault("log_category") ? "gossip" : "logEvents", text);
    return status;
}

const char *fmi3GetVersion(void) { return fault("version") ? "2.0" : "3.0"; }
int fmi3SetDebugLogging(void *c, bool on, size_t n, const char *const names[]) { ((Instance *)c)->logging = on; return OK; }

static void *make(const char *token, bool logging, void *environment, Logger logger, int exchange) {
    if (fault("instantiate") || (!fault("token") && strcmp(token, "{foreign}"))) return 0;
    Instance *c = calloc(1, sizeof *c);
    set_defaults(&c->now);
    c->exchange = exchange;
    c->logging = logging;
    c->logger = (void *)logger;
    c->environment = environment;
    return c;
}
void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible, bool logging, void *environment, Logger logger) {
    return make(token, logging, environment, logger, 1);
}
void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool events, bool early,
                                  const VR intermediate[], size_t n, void *environment, Logger logger, const void *update) {
    return make(token, logging, environment, logger, 0);
}
void *fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *resources, bool visible, bool logging, void *environment,
                                        Logger logger, const void *clock, const void *lock, const void *unlock) {
    return 0;
}
void fmi3FreeInstance(void *p) {
    if (!p) { if (fault("free_null")) *(volatile int *)8 = 1; return; }
    if (!fault("leak_instance")) free(p);
    else lose(256);
}

int fmi3EnterInitializationMode(void *p, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) {
    Instance *c = p;
    c->now.time = start;
    c->now.has_stop = has_stop;
    c->now.stop = stop;
    return OK;
}
int fmi3ExitInitializationMode(void *p) {
    Instance *c = p;
    c->now.beyond = c->now.x > c->now.limit;
    return say(c, OK, "initialised");
}
int fmi3EnterEventMode(void *p) { return fault("event_mode") ? say(p, ERROR, "no event mode") : OK; }
int fmi3Terminate(void *p) { return fault("terminate") ? say(p, ERROR, "it does not end") : OK; }
int fmi3Reset(void *p) { forget(p); return fault("reset_error") ? say(p, ERROR, "no way back") : OK; }

int fmi3GetFloat64(void *p, const VR vr[], size_t n, double value[], size_t m) {
    for (size_t i = 0; i < n; i++)
        if (!get_real(p, vr[i], value + i)) {
            value[i] = 0;
            if (!fault("reference")) return say(p, ERROR, "no such floating point variable");
        }
    return OK;
}
int fmi3SetFloat64(void *p, const VR vr[], size_t n, const double value[], size_t m) {
    for (size_t i = 0; i < n; i++) {
        int refused = set_real(p, vr[i], value[i]);
        if (refused) return say(p, refused == 1 ? ERROR : DISCARD, "a value is refused");
    }
    return OK;
}
int fmi3GetInt32(void *p, const VR vr[], size_t n, int32_t value[], size_t m) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != SOLVER) return say(p, ERROR, "no such integer");
        value[i] = ((Instance *)p)->now.solver;
    }
    return OK;
}
int fmi3SetInt32(void *p, const VR vr[], size_t n, const int32_t value[], size_t m) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != SOLVER) return say(p, ERROR, "no such integer");
        if (!fault("range_unchecked") && (value[i] < 1 || value[i] > 2)) return say(p, DISCARD, "no such solver");
        ((Instance *)p)->now.solver = value[i];
    }
    return OK;
}
int fmi3GetBoolean(void *p, const VR vr[], size_t n, bool value[], size_t m) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != BEYOND) return say(p, ERROR, "no such Boolean");
        value[i] = ((Instance *)p)->now.beyond;
    }
    return OK;
}
int fmi3GetString(void *p, const VR vr[], size_t n, const char *value[], size_t m) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != LABEL) return say(p, ERROR, "no such string");
        value[i] = ((Instance *)p)->now.label;
    }
    return OK;
}
int fmi3SetString(void *p, const VR vr[], size_t n, const char *const value[], size_t m) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != LABEL) return say(p, ERROR, "no such string");
        snprintf(((Instance *)p)->now.label, 32, "%s", value[i]);
    }
    return OK;
}
/* The types that the oscillator does not have. */
#define NO_GET(name, type) int fmi3Get##name(void *p, const VR vr[], size_t n, type value[], size_t m) { return n ? say(p, ERROR, "no such variable") : OK; }
#define NO_SET(name, type) int fmi3Set##name(void *p, const VR vr[], size_t n, const type value[], size_t m) { return n ? say(p, ERROR, "no such variable") : OK; }
NO_GET(Float32, float) NO_GET(Int8, int8_t) NO_GET(UInt8, uint8_t) NO_GET(Int16, int16_t) NO_GET(UInt16, uint16_t) NO_GET(UInt32, uint32_t)
NO_GET(Int64, int64_t) NO_GET(UInt64, uint64_t)
NO_SET(Float32, float) NO_SET(Int8, int8_t) NO_SET(UInt8, uint8_t) NO_SET(Int16, int16_t) NO_SET(UInt16, uint16_t) NO_SET(UInt32, uint32_t)
NO_SET(Int64, int64_t) NO_SET(UInt64, uint64_t) NO_SET(Boolean, bool)
int fmi3GetBinary(void *p, const VR vr[], size_t n, size_t sizes[], const uint8_t *value[], size_t m) { return n ? ERROR : OK; }
int fmi3SetBinary(void *p, const VR vr[], size_t n, const size_t sizes[], const uint8_t *const value[], size_t m) { return n ? ERROR : OK; }
int fmi3GetClock(void *p, const VR vr[], size_t n, bool value[]) { return n ? ERROR : OK; }
int fmi3SetClock(void *p, const VR vr[], size_t n, const bool value[]) { return n ? ERROR : OK; }
int fmi3GetNumberOfVariableDependencies(void *p, VR vr, size_t *n) { return ERROR; }
int fmi3GetVariableDependencies(void *p, VR vr, size_t a[], VR b[], size_t c[], int d[], size_t n) { return ERROR; }

int fmi3GetFMUState(void *p, void **state) {
    if (!*state || fault("leak_state")) *state = malloc(sizeof(Values));
    save(p, *state);
    return OK;
}
int fmi3SetFMUState(void *p, void *state) { restore(p, state); return OK; }
int fmi3FreeFMUState(void *p, void **state) {
    if (!fault("leak_state")) free(*state);
    else lose(256);
    if (!fault("state_pointer")) *state = 0;
    return OK;
}
int fmi3SerializedFMUStateSize(void *p, void *state, size_t *size) { *size = sizeof(Values); return OK; }
int fmi3SerializeFMUState(void *p, void *state, uint8_t bytes[], size_t size) { pack(state, bytes); return OK; }
int fmi3DeserializeFMUState(void *p, const uint8_t bytes[], size_t size, void **state) {
    if (size != sizeof(Values)) return say(p, ERROR, "not a state of this FMU");
    *state = malloc(size);
    memcpy(*state, bytes, size);
    return OK;
}
int fmi3GetDirectionalDerivative(void *p, const VR u[], size_t nu, const VR k[], size_t nk, const double seed[], size_t ns, double out[], size_t no) {
    for (size_t i = 0; i < nu; i++) {
        out[i] = 0;
        for (size_t j = 0; j < nk; j++) out[i] += partial(p, u[i], k[j]) * seed[j];
    }
    return OK;
}
int fmi3GetAdjointDerivative(void *p, const VR u[], size_t nu, const VR k[], size_t nk, const double seed[], size_t ns, double out[], size_t no) {
    for (size_t j = 0; j < nk; j++) {
        out[j] = 0;
        for (size_t i = 0; i < nu; i++) out[j] += partial(p, u[i], k[j]) * seed[i] * (fault("adjoint") ? 1.02 : 1.0);
    }
    return OK;
}

int fmi3EnterConfigurationMode(void *p) { return OK; }
int fmi3ExitConfigurationMode(void *p) { return OK; }
#define NO_CLOCK(name) int fmi3##name(void *p, const VR vr[], size_t n) { return n ? ERROR : OK; }
NO_CLOCK(GetIntervalDecimal) NO_CLOCK(GetIntervalFraction) NO_CLOCK(GetShiftDecimal) NO_CLOCK(GetShiftFraction)
NO_CLOCK(SetIntervalDecimal) NO_CLOCK(SetIntervalFraction) NO_CLOCK(SetShiftDecimal) NO_CLOCK(SetShiftFraction)
int fmi3EvaluateDiscreteStates(void *p) { return OK; }
int fmi3UpdateDiscreteStates(void *p, bool *again, bool *terminate, bool *nominals, bool *values, bool *defined, double *next) {
    Instance *c = p;
    *terminate = *nominals = *values = false;
    c->now.beyond = c->now.x > c->now.limit;
    *again = fault("events_forever");
    *defined = fault("event_past");
    *next = c->now.time - 1.0;
    return OK;
}
int fmi3EnterContinuousTimeMode(void *p) { return OK; }
int fmi3CompletedIntegratorStep(void *p, bool no_set, bool *event, bool *terminate) { *event = *terminate = false; return OK; }
int fmi3SetTime(void *p, double t) { ((Instance *)p)->now.time = t; return OK; }
int fmi3SetContinuousStates(void *p, const double x[], size_t n) {
    Instance *c = p;
    c->now.x = x[0];
    if (!fault("states_kept")) c->now.v = x[1];
    return OK;
}
int fmi3GetContinuousStateDerivatives(void *p, double d[], size_t n) {
    Instance *c = p;
    d[0] = c->now.v;
    d[1] = acceleration(c, c->now.x, c->now.v, c->now.force);
    if (fault("evaluation_memory")) d[1] += 1e-3 * c->now.calls++;
    return OK;
}
int fmi3GetEventIndicators(void *p, double z[], size_t n) { z[0] = indicator(p); return OK; }
int fmi3GetContinuousStates(void *p, double x[], size_t n) {
    Instance *c = p;
    x[fault("states_order")] = c->now.x;
    x[!fault("states_order")] = c->now.v;
    return OK;
}
int fmi3GetNominalsOfContinuousStates(void *p, double x[], size_t n) { x[0] = x[1] = fault("nominal") ? 0.0 : 1.0; return OK; }
int fmi3GetNumberOfEventIndicators(void *p, size_t *n) { *n = 1; return OK; }
int fmi3GetNumberOfContinuousStates(void *p, size_t *n) { *n = fault("states_number") ? 3 : 2; return OK; }

int fmi3EnterStepMode(void *p) { return OK; }
int fmi3GetOutputDerivatives(void *p, const VR vr[], size_t n, const int32_t order[], double value[], size_t m) {
    for (size_t i = 0; i < n; i++)
        if (order[i] != 1 || !output_slope(p, vr[i], value + i)) return say(p, ERROR, "no slope of this output");
    return OK;
}
int fmi3DoStep(void *p, double t, double h, bool no_set, bool *event, bool *terminate, bool *early, double *last) {
    Instance *c = p;
    *event = *terminate = false;
    *early = fault("early_return");
    if (mishap(c)) return say(c, ERROR, "the step went wrong");
    if (c->now.has_stop && t + h > c->now.stop * (1 + 1e-9) && !fault("stop_time")) return say(c, ERROR, "past the stop time");
    integrate(c, h);
    *last = t + h;
    return OK;
}
int fmi3ActivateModelPartition(void *p, VR clock, double t) { return ERROR; }
