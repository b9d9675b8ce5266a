/* The C interface of FMI 2.0 around one model (MODEL is its file), written after the text of the standard 2.0.5. */
#include MODEL

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
enum { OK, WARNING, DISCARD, ERROR };

#define LOG(c, status, ...) ((Logger)(c)->logger)((c)->environment, (c)->name, status, "logStatus", __VA_ARGS__)

static int refuse(Instance *c, unsigned vr) {
    LOG(c, ERROR, "no variable has the value reference %u", vr);
    return ERROR;
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
int fmi2SetDebugLogging(void *p, int on, size_t n, const char *const names[]) { ((Instance *)p)->logging = on; return OK; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *callbacks, int visible, int logging) {
    static int instances;
    if (strcmp(guid, "{corpus}") || (quirk("once") && instances++)) {
        callbacks->logger(callbacks->environment, name, ERROR, "logStatus", "instantiation refused: another build, or the second instance");
        return 0;
    }
    Instance *c = calloc(1, sizeof *c);
    set_defaults(&c->now);
    c->logging = logging;
    c->logger = (void *)callbacks->logger;
    c->environment = quirk("log-environment") ? c : callbacks->environment;
    c->memory = quirk("terminate-frees") ? malloc(65536) : 0;
    if (c->memory) memset(c->memory, 1, 65536);
    snprintf(c->name, sizeof c->name, "%s", name);
    return c;
}
void fmi2FreeInstance(void *p) { free(p); }

int fmi2SetupExperiment(void *p, int has_tolerance, double tolerance, double start, int has_stop, double stop) {
    Values *s = &((Instance *)p)->now;
    if (quirk("reset-in-setup")) set_defaults(s);
    s->time = start;
    s->next += start;
    s->has_stop = has_stop;
    s->stop = stop;
    return OK;
}
int fmi2EnterInitializationMode(void *p) { return OK; }
int fmi2ExitInitializationMode(void *p) { return OK; }
int fmi2Terminate(void *p) {
    Instance *c = p;
    free(c->memory);
    c->memory = 0;
    return OK;
}
int fmi2Reset(void *p) { set_defaults(&((Instance *)p)->now); return OK; }

int fmi2GetReal(void *p, const unsigned vr[], size_t n, double value[]) {
    for (size_t i = 0; i < n; i++) {
        double *from = real(&((Instance *)p)->now, vr[i], 0);
        if (!from) return refuse(p, vr[i]);
        value[i] = *from;
    }
    return OK;
}
int fmi2SetReal(void *p, const unsigned vr[], size_t n, const double value[]) {
    for (size_t i = 0; i < n; i++) {
        double *to = real(&((Instance *)p)->now, vr[i], 1);
        if (!to || !isfinite(value[i])) return refuse(p, vr[i]);
        *to = value[i];
    }
    return OK;
}
int fmi2GetInteger(void *p, const unsigned vr[], size_t n, int value[]) {
    for (size_t i = 0; i < n; i++) {
        int64_t *from = whole(&((Instance *)p)->now, vr[i], 0);
        if (!from) return refuse(p, vr[i]);
        value[i] = (int)*from;
    }
    return OK;
}
/* The models have no other variables that FMI 2 can hold. */
#define NONE(name, type) int fmi2##name(void *p, const unsigned vr[], size_t n, type value[]) { return n ? refuse(p, vr[0]) : OK; }
NONE(SetInteger, const int) NONE(GetBoolean, int) NONE(SetBoolean, const int) NONE(GetString, const char *) NONE(SetString, const char *const)

int fmi2GetFMUstate(void *p, void **state) {
    if (!*state) *state = malloc(sizeof(Values));
    memcpy(*state, &((Instance *)p)->now, sizeof(Values));
    return OK;
}
int fmi2SetFMUstate(void *p, void *state) {
    memcpy(&((Instance *)p)->now, state, sizeof(Values));
    ((Instance *)p)->now.restarted = 1;
    return OK;
}
int fmi2FreeFMUstate(void *p, void **state) { free(*state); *state = 0; return OK; }
int fmi2SerializedFMUstateSize(void *p, void *state, size_t *size) { *size = sizeof(Values); return OK; }
int fmi2SerializeFMUstate(void *p, void *state, char bytes[], size_t size) { memcpy(bytes, state, sizeof(Values)); return OK; }
int fmi2DeSerializeFMUstate(void *p, const char bytes[], size_t size, void **state) {
    if (size != sizeof(Values)) return ERROR;
    memcpy(*state = malloc(size), bytes, size);
    return OK;
}
int fmi2GetDirectionalDerivative(void *p, const unsigned u[], size_t nu, const unsigned k[], size_t nk, const double seed[], double out[]) { return ERROR; }

int fmi2EnterEventMode(void *p) { return OK; }
int fmi2NewDiscreteStates(void *p, EventInfo *info) {
    Values *s = &((Instance *)p)->now;
    memset(info, 0, sizeof *info);
    info->values = event(s);
    info->defined = isfinite(s->next);
    info->next = s->next;
    return OK;
}
int fmi2EnterContinuousTimeMode(void *p) { return OK; }
int fmi2CompletedIntegratorStep(void *p, int no_set, int *event, int *terminate) { *event = *terminate = 0; return OK; }
int fmi2SetTime(void *p, double t) { ((Instance *)p)->now.time = t; return OK; }
int fmi2SetContinuousStates(void *p, const double x[], size_t n) { memcpy(((Instance *)p)->now.x, x, n * sizeof *x); return OK; }
int fmi2GetContinuousStates(void *p, double x[], size_t n) { memcpy(x, ((Instance *)p)->now.x, n * sizeof *x); return OK; }
int fmi2GetDerivatives(void *p, double d[], size_t n) { derivatives(&((Instance *)p)->now, d); return OK; }
int fmi2GetEventIndicators(void *p, double z[], size_t n) { if (n) z[0] = indicator(&((Instance *)p)->now); return OK; }
int fmi2GetNominalsOfContinuousStates(void *p, double x[], size_t n) { while (n--) x[n] = 1.0; return OK; }

int fmi2DoStep(void *p, double t, double h, int no_set) {
    Instance *c = p;
    mishap(&c->now);
    if (c->now.has_stop && t + h > c->now.stop + 1e-9) {
        LOG(c, ERROR, "%s", "a step past the stop time");
        return ERROR;
    }
    advance(&c->now, h);
    if (c->now.steps != 3 || !(quirk("log-printf") || quirk("log-environment"))) return OK;
    LOG(c, WARNING, "step %d of %s at %.2f s, %d%% done", c->now.steps, "the lag", t, 30);
    return WARNING;
}
int fmi2SetRealInputDerivatives(void *p, const unsigned vr[], size_t n, const int order[], const double value[]) { return n ? ERROR : OK; }
int fmi2GetRealOutputDerivatives(void *p, const unsigned vr[], size_t n, const int order[], double value[]) { return n ? ERROR : OK; }
int fmi2CancelStep(void *p) { return ERROR; }
#define STATUS(name, type) int fmi2Get##name(void *p, int kind, type *value) { return DISCARD; }
STATUS(Status, int) STATUS(RealStatus, double) STATUS(IntegerStatus, int) STATUS(BooleanStatus, int) STATUS(StringStatus, const char *)
