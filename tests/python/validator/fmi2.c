/* The C interface of FMI 2.0 for the oscillator, written after the standard's text: Model Exchange and Co-Simulation. */
#include "oscillator.h"

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;
typedef struct {
    int again, terminate, nominals, values, defined;
    double next;
} EventInfo;
enum { OK, WARNING, DISCARD, ERROR, FATAL };

static int say(Instance *c, int status, const char *text) {
    if (c->logging || status >= DISCARD)
        ((Logger)c->logger)(c->environment, "oscillator", status, fault("log_category") ? "gossip" : "logEvents", "%s", text);
    return status;
}

const char *fmi2GetTypesPlatform(void) { return fault("platform") ? "standard32" : "default"; }
const char *fmi2GetVersion(void) { return fault("version_release") ? "2.0.5" : fault("version") ? "1.0" : "2.0"; }
int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const names[]) { ((Instance *)c)->logging = on; return OK; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *callbacks, int visible, int logging) {
    if (fault("instantiate") || (!fault("token") && strcmp(guid, "{foreign}"))) return 0;
    Instance *c = calloc(1, sizeof *c);
    set_defaults(&c->now);
    c->exchange = type == 0;
    c->logging = logging;
    c->logger = (void *)callbacks->logger;
    c->environment = callbacks->environment;
    return c;
}

void fmi2FreeInstance(void *p) {
    if (!p) { if (fault("free_null")) *(volatile int *)8 = 1; return; }
    if (!fault("leak_instance")) free(p);
    else lose(256);
}

int fmi2SetupExperiment(void *p, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
    Instance *c = p;
    c->now.time = start;
    c->now.has_stop = has_stop;
    c->now.stop = stop;
    return OK;
}
int fmi2EnterInitializationMode(void *p) { return OK; }
int fmi2ExitInitializationMode(void *p) {
    Instance *c = p;
    c->now.beyond = c->now.x > c->now.limit;
    return say(c, OK, "initialised");
}
int fmi2Terminate(void *p) { return fault("terminate") ? say(p, ERROR, "it does not end") : OK; }
int fmi2Reset(void *p) { forget(p); return fault("reset_error") ? say(p, ERROR, "no way back") : OK; }

int fmi2GetReal(void *p, const unsigned vr[], size_t n, double value[]) {
    for (size_t i = 0; i < n; i++)
        if (!get_real(p, vr[i], value + i)) {
            value[i] = 0;
            if (!fault("reference")) return say(p, ERROR, "no such real variable");
        }
    return OK;
}
int fmi2SetReal(void *p, const unsigned vr[], size_t n, const double value[]) {
    for (size_t i = 0; i < n; i++) {
        int refused = set_real(p, vr[i], value[i]);
        if (refused) return say(p, refused == 1 ? ERROR : DISCARD, "a value is refused");
    }
    return OK;
}
int fmi2GetInteger(void *p, const unsigned vr[], size_t n, int value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != SOLVER) return say(p, ERROR, "no such integer");
        value[i] = ((Instance *)p)->now.solver;
    }
    return OK;
}
int fmi2SetInteger(void *p, const unsigned vr[], size_t n, const int value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != SOLVER) return say(p, ERROR, "no such integer");
        if (!fault("range_unchecked") && (value[i] < 1 || value[i] > 2)) return say(p, DISCARD, "no such solver");
        ((Instance *)p)->now.solver = value[i];
    }
    return OK;
}
int fmi2GetBoolean(void *p, const unsigned vr[], size_t n, int value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != BEYOND) return say(p, ERROR, "no such Boolean");
        value[i] = ((Instance *)p)->now.beyond;
    }
    return OK;
}
int fmi2SetBoolean(void *p, const unsigned vr[], size_t n, const int value[]) { return say(p, ERROR, "no Boolean can be set"); }
int fmi2GetString(void *p, const unsigned vr[], size_t n, const char *value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != LABEL) return say(p, ERROR, "no such string");
        value[i] = ((Instance *)p)->now.label;
    }
    return OK;
}
int fmi2SetString(void *p, const unsigned vr[], size_t n, const char *const value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != LABEL) return say(p, ERROR, "no such string");
        snprintf(((Instance *)p)->now.label, 32, "%s", value[i]);
    }
    return OK;
}

int fmi2GetFMUstate(void *p, void **state) {
    if (!*state || fault("leak_state")) *state = malloc(sizeof(Values));
    save(p, *state);
    return OK;
}
int fmi2SetFMUstate(void *p, void *state) { restore(p, state); return OK; }
int fmi2FreeFMUstate(void *p, void **state) {
    if (!fault("leak_state")) free(*state);
    else lose(256);
    if (!fault("state_pointer")) *state = 0;
    return OK;
}
int fmi2SerializedFMUstateSize(void *p, void *state, size_t *size) { *size = sizeof(Values); return OK; }
int fmi2SerializeFMUstate(void *p, void *state, char bytes[], size_t size) { pack(state, bytes); return OK; }
int fmi2DeSerializeFMUstate(void *p, const char bytes[], size_t size, void **state) {
    if (size != sizeof(Values)) return say(p, ERROR, "not a state of this FMU");
    *state = malloc(size);
    memcpy(*state, bytes, size);
    return OK;
}
int fmi2GetDirectionalDerivative(void *p, const unsigned u[], size_t nu, const unsigned k[], size_t nk, const double seed[], double out[]) {
    for (size_t i = 0; i < nu; i++) {
        out[i] = 0;
        for (size_t j = 0; j < nk; j++) out[i] += partial(p, u[i], k[j]) * seed[j];
    }
    return OK;
}

int fmi2EnterEventMode(void *p) { return OK; }
int fmi2NewDiscreteStates(void *p, EventInfo *info) {
    Instance *c = p;
    memset(info, 0, sizeof *info);
    c->now.beyond = c->now.x > c->now.limit;
    if (fault("reinit")) info->values = 1, ((Instance *)p)->now.v *= -0.9;
    info->again = fault("events_forever");
    info->defined = fault("event_past");
    info->next = c->now.time - 1.0;
    return OK;
}
int fmi2EnterContinuousTimeMode(void *p) { return OK; }
int fmi2CompletedIntegratorStep(void *p, int no_set, int *event, int *terminate) { *event = *terminate = 0; return OK; }
int fmi2SetTime(void *p, double t) { ((Instance *)p)->now.time = t; return OK; }
int fmi2SetContinuousStates(void *p, const double x[], size_t n) {
    Instance *c = p;
    c->now.x = x[0];
    if (!fault("states_kept")) c->now.v = x[1];
    return OK;
}
int fmi2GetDerivatives(void *p, double d[], size_t n) {
    Instance *c = p;
    d[0] = c->now.v;
    d[1] = acceleration(c, c->now.x, c->now.v, c->now.force);
    if (fault("evaluation_memory")) d[1] += 1e-3 * c->now.calls++;
    return OK;
}
int fmi2GetEventIndicators(void *p, double z[], size_t n) { z[0] = indicator(p); return OK; }
int fmi2GetContinuousStates(void *p, double x[], size_t n) {
    Instance *c = p;
    x[fault("states_order")] = c->now.x;
    x[!fault("states_order")] = c->now.v;
    return OK;
}
int fmi2GetNominalsOfContinuousStates(void *p, double x[], size_t n) { x[0] = x[1] = fault("nominal") ? 0.0 : 1.0; return OK; }

int fmi2SetRealInputDerivatives(void *p, const unsigned vr[], size_t n, const int order[], const double value[]) {
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != FORCE || order[i] != 1) return say(p, ERROR, "no slope of this input");
        if (!fault("input_derivative")) ((Instance *)p)->now.slope = value[i];
    }
    return OK;
}
int fmi2GetRealOutputDerivatives(void *p, const unsigned vr[], size_t n, const int order[], double value[]) {
    for (size_t i = 0; i < n; i++)
        if (order[i] != 1 || !output_slope(p, vr[i], value + i)) return say(p, ERROR, "no slope of this output");
    return OK;
}
int fmi2DoStep(void *p, double t, double h, int no_set) {
    Instance *c = p;
    if (mishap(c)) return say(c, ERROR, "the step went wrong");
    if (fault("environment")) ((Logger)c->logger)(c, "oscillator", 1, "logEvents", "%s", "a step");
    if (c->now.has_stop && t + h > c->now.stop * (1 + 1e-9) && !fault("stop_time")) return say(c, ERROR, "past the stop time");
    integrate(c, h);
    c->now.slope = 0;
    return OK;
}
int fmi2CancelStep(void *p) { return ERROR; }
int fmi2GetStatus(void *p, int kind, int *value) { return DISCARD; }
int fmi2GetRealStatus(void *p, int kind, double *value) { return DISCARD; }
int fmi2GetIntegerStatus(void *p, int kind, int *value) { return DISCARD; }
int fmi2GetBooleanStatus(void *p, int kind, int *value) { *value = 0; return OK; }
int fmi2GetStringStatus(void *p, int kind, const char **value) { return DISCARD; }
