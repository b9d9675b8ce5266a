/* The C interface of FMI 3.0 around one model (MODEL is its file), written after the text of the standard 3.0.2. */
#include MODEL

typedef uint32_t VR;
typedef void (*Logger)(void *, int, const char *, const char *);
enum { OK, WARNING, DISCARD, ERROR };
#ifndef HAS_BINARY
#define HAS_BINARY 0
#endif
#ifndef HAS_CLOCK
#define HAS_CLOCK 0
#endif

static int say(Instance *c, int status, const char *text) {
    if (c->logging) ((Logger)c->logger)(c->environment, status, "logStatus", text);
    return status;
}
static int refuse(Instance *c) { return say(c, ERROR, "no variable of this type has this value reference"); }

const char *fmi3GetVersion(void) { return "3.0"; }
int fmi3SetDebugLogging(void *p, bool on, size_t n, const char *const names[]) { ((Instance *)p)->logging = on; return OK; }

static void *make(const char *token, bool logging, void *environment, Logger logger, bool fits) {
    static int instances;
    if (!fits || strcmp(token, "{corpus}") || (quirk("once") && instances++)) {
        if (logging) logger(environment, ERROR, "logStatus", "instantiation refused: another build, the second instance, or no event mode");
        return 0;
    }
    Instance *c = calloc(1, sizeof *c);
    set_defaults(&c->now);
    c->logging = logging;
    c->logger = (void *)logger;
    c->environment = environment;
    c->memory = quirk("terminate-frees") ? malloc(65536) : 0;
    if (c->memory) memset(c->memory, 1, 65536);
    return c;
}
void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible, bool logging, void *environment, Logger logger) {
    return make(token, logging, environment, logger, true);
}
void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool events, bool early,
                                  const VR intermediate[], size_t n, void *environment, Logger logger, const void *update) {
    return make(token, logging, environment, logger, events == HAS_CLOCK);
}
void *fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *resources, bool visible, bool logging, void *environment,
                                        Logger logger, const void *clock, const void *lock, const void *unlock) {
    return 0;
}
void fmi3FreeInstance(void *p) { free(p); }

int fmi3EnterInitializationMode(void *p, bool has_tolerance, double tolerance, double start, bool has_stop, double stop) {
    Values *s = &((Instance *)p)->now;
    s->time = start;
    s->next += start;
    s->has_stop = has_stop;
    s->stop = stop;
    return OK;
}
int fmi3ExitInitializationMode(void *p) { return OK; }
int fmi3EnterEventMode(void *p) { return OK; }
int fmi3Terminate(void *p) {
    Instance *c = p;
    free(c->memory);
    c->memory = 0;
    return OK;
}
int fmi3Reset(void *p) { set_defaults(&((Instance *)p)->now); return OK; }

int fmi3GetFloat64(void *p, const VR vr[], size_t n, double value[], size_t m) {
    for (size_t i = 0; i < n; i++) {
        double *from = real(&((Instance *)p)->now, vr[i], 0);
        if (!from) return refuse(p);
        value[i] = *from;
    }
    return OK;
}
int fmi3SetFloat64(void *p, const VR vr[], size_t n, const double value[], size_t m) {
    for (size_t i = 0; i < n; i++) {
        double *to = real(&((Instance *)p)->now, vr[i], 1);
        if (!to || !isfinite(value[i])) return refuse(p);
        *to = value[i];
    }
    return OK;
}
#define INTEGER(name, type) \
    int fmi3Get##name(void *p, const VR vr[], size_t n, type value[], size_t m) { \
        for (size_t i = 0; i < n; i++) { \
            int64_t *from = whole(&((Instance *)p)->now, vr[i], 0); \
            if (!from) return refuse(p); \
            value[i] = (type)*from; \
        } \
        return OK; \
    } \
    int fmi3Set##name(void *p, const VR vr[], size_t n, const type value[], size_t m) { \
        for (size_t i = 0; i < n; i++) { \
            int64_t *to = whole(&((Instance *)p)->now, vr[i], 1); \
            if (!to) return refuse(p); \
            *to = (int64_t)value[i]; \
        } \
        return OK; \
    }
INTEGER(Int32, int32_t) INTEGER(Int64, int64_t) INTEGER(UInt64, uint64_t)
int fmi3GetBinary(void *p, const VR vr[], size_t n, size_t sizes[], const uint8_t *value[], size_t m) {
    Values *s = &((Instance *)p)->now;
    for (size_t i = 0; i < n; i++) {
        if (!HAS_BINARY) return refuse(p);
        sizes[i] = s->blob_size;
        value[i] = s->blob;
    }
    return OK;
}
int fmi3SetBinary(void *p, const VR vr[], size_t n, const size_t sizes[], const uint8_t *const value[], size_t m) {
    Values *s = &((Instance *)p)->now;
    for (size_t i = 0; i < n; i++) {
        if (!HAS_BINARY || sizes[i] > sizeof s->blob) return refuse(p);
        memcpy(s->blob, value[i], s->blob_size = sizes[i]);
    }
    return OK;
}
/* The models have no variables of these types. */
#define NONE(name, type) int fmi3##name(void *p, const VR vr[], size_t n, type value[], size_t m) { return n ? refuse(p) : OK; }
NONE(GetFloat32, float) NONE(GetInt8, int8_t) NONE(GetUInt8, uint8_t) NONE(GetInt16, int16_t) NONE(GetUInt16, uint16_t) NONE(GetUInt32, uint32_t)
NONE(SetFloat32, const float) NONE(SetInt8, const int8_t) NONE(SetUInt8, const uint8_t) NONE(SetInt16, const int16_t)
NONE(SetUInt16, const uint16_t) NONE(SetUInt32, const uint32_t) NONE(GetBoolean, bool) NONE(SetBoolean, const bool)
NONE(GetString, const char *) NONE(SetString, const char *const)

int fmi3GetClock(void *p, const VR vr[], size_t n, bool value[]) { return n ? refuse(p) : OK; }
int fmi3SetClock(void *p, const VR vr[], size_t n, const bool value[]) {
    for (size_t i = 0; i < n; i++) {
        if (!HAS_CLOCK) return refuse(p);
        ((Instance *)p)->now.ticking = value[i];
    }
    return OK;
}
int fmi3GetIntervalDecimal(void *p, const VR vr[], size_t n, double interval[], int qualifier[]) {
    while (n--) interval[n] = 0.1, qualifier[n] = 2;
    return HAS_CLOCK ? OK : ERROR;
}
int fmi3GetShiftDecimal(void *p, const VR vr[], size_t n, double shift[]) {
    while (n--) shift[n] = 0.0;
    return HAS_CLOCK ? OK : ERROR;
}
int fmi3GetIntervalFraction(void *p, const VR vr[], size_t n, uint64_t counter[], uint64_t resolution[], int qualifier[]) { return ERROR; }
int fmi3GetShiftFraction(void *p, const VR vr[], size_t n, uint64_t counter[], uint64_t resolution[]) { return ERROR; }
int fmi3SetIntervalDecimal(void *p, const VR vr[], size_t n, const double interval[]) { return ERROR; }
int fmi3SetIntervalFraction(void *p, const VR vr[], size_t n, const uint64_t counter[], const uint64_t resolution[]) { return ERROR; }
int fmi3SetShiftDecimal(void *p, const VR vr[], size_t n, const double shift[]) { return ERROR; }
int fmi3SetShiftFraction(void *p, const VR vr[], size_t n, const uint64_t counter[], const uint64_t resolution[]) { return ERROR; }

int fmi3GetNumberOfVariableDependencies(void *p, VR vr, size_t *n) { return ERROR; }
int fmi3GetVariableDependencies(void *p, VR vr, size_t a[], VR b[], size_t c[], int d[], size_t n) { return ERROR; }
int fmi3GetFMUState(void *p, void **state) {
    if (!*state) *state = malloc(sizeof(Values));
    memcpy(*state, &((Instance *)p)->now, sizeof(Values));
    return OK;
}
int fmi3SetFMUState(void *p, void *state) {
    memcpy(&((Instance *)p)->now, state, sizeof(Values));
    ((Instance *)p)->now.restarted = 1;
    return OK;
}
int fmi3FreeFMUState(void *p, void **state) { free(*state); *state = 0; return OK; }
int fmi3SerializedFMUStateSize(void *p, void *state, size_t *size) { *size = sizeof(Values); return OK; }
int fmi3SerializeFMUState(void *p, void *state, uint8_t bytes[], size_t size) { memcpy(bytes, state, sizeof(Values)); return OK; }
int fmi3DeserializeFMUState(void *p, const uint8_t bytes[], size_t size, void **state) {
    if (size != sizeof(Values)) return say(p, ERROR, "not a state of this FMU");
    memcpy(*state = malloc(size), bytes, size);
    return OK;
}
int fmi3GetDirectionalDerivative(void *p, const VR u[], size_t nu, const VR k[], size_t nk, const double seed[], size_t ns, double out[], size_t no) { return ERROR; }
int fmi3GetAdjointDerivative(void *p, const VR u[], size_t nu, const VR k[], size_t nk, const double seed[], size_t ns, double out[], size_t no) { return ERROR; }
int fmi3EnterConfigurationMode(void *p) { return ERROR; }
int fmi3ExitConfigurationMode(void *p) { return ERROR; }

int fmi3EvaluateDiscreteStates(void *p) { return OK; }
int fmi3UpdateDiscreteStates(void *p, bool *again, bool *terminate, bool *nominals, bool *values, bool *defined, double *next) {
    Values *s = &((Instance *)p)->now;
    *again = *terminate = *nominals = false;
    *values = event(s);
    *defined = isfinite(s->next);
    *next = s->next;
    return OK;
}
int fmi3EnterContinuousTimeMode(void *p) { return OK; }
int fmi3CompletedIntegratorStep(void *p, bool no_set, bool *event, bool *terminate) { *event = *terminate = false; return OK; }
int fmi3SetTime(void *p, double t) { ((Instance *)p)->now.time = t; return OK; }
int fmi3SetContinuousStates(void *p, const double x[], size_t n) { memcpy(((Instance *)p)->now.x, x, n * sizeof *x); return OK; }
int fmi3GetContinuousStates(void *p, double x[], size_t n) { memcpy(x, ((Instance *)p)->now.x, n * sizeof *x); return OK; }
int fmi3GetContinuousStateDerivatives(void *p, double d[], size_t n) { derivatives(&((Instance *)p)->now, d); return OK; }
int fmi3GetEventIndicators(void *p, double z[], size_t n) { if (n) z[0] = indicator(&((Instance *)p)->now); return OK; }
int fmi3GetNominalsOfContinuousStates(void *p, double x[], size_t n) { while (n--) x[n] = 1.0; return OK; }
int fmi3GetNumberOfEventIndicators(void *p, size_t *n) { *n = INDICATORS; return OK; }
int fmi3GetNumberOfContinuousStates(void *p, size_t *n) { *n = STATES; return OK; }

int fmi3EnterStepMode(void *p) { return OK; }
int fmi3GetOutputDerivatives(void *p, const VR vr[], size_t n, const int32_t order[], double value[], size_t m) { return ERROR; }
int fmi3DoStep(void *p, double t, double h, bool no_set, bool *event, bool *terminate, bool *early, double *last) {
    Instance *c = p;
    *event = *terminate = *early = false;
    mishap(&c->now);
    if (c->now.has_stop && t + h > c->now.stop + 1e-9) return say(c, ERROR, "a step past the stop time");
    advance(&c->now, h);
    *last = t + h;
    return c->now.steps == 3 && quirk("log-printf") ? say(c, WARNING, "30% of %s is done") : OK;
}
int fmi3ActivateModelPartition(void *p, VR clock, double t) { return ERROR; }
