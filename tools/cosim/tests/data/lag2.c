/* An FMI 2.0 Co-Simulation FMU for the tests of the client, written against the standard's text alone. */
#include "lag.h"

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    Lag m;
    const Callbacks *callbacks;
    char name[64], label[64];
    int dead;
} Instance;

enum { OK, WARNING, DISCARD, ERROR, FATAL };

#define SAY(i, status, ...) (i)->callbacks->logger((i)->callbacks->environment, (i)->name, status, "all", __VA_ARGS__)
/* A client that calls after Fatal does not get away with it. */
#define ALIVE(c) Instance *i = c; if (i->dead) abort()

const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *f, int visible, int logging)
{
    (void)visible; (void)logging;
    if (strcmp(guid, "lag-guid") || type != 1 || strncmp(resources, "file:///", 8)) {
        f->logger(f->environment, name, ERROR, "all", "%s", "the guid is not mine");
        return NULL;
    }
    Instance *i = f->allocate(1, sizeof *i);
    i->m = lag_start;
    i->callbacks = f;
    snprintf(i->name, sizeof i->name, "%s", name);
    return i;
}

void fmi2FreeInstance(void *c) { ALIVE(c); i->callbacks->release(i); }
int fmi2SetupExperiment(void *c, int td, double tol, double start, int sd, double stop)
{
    (void)td; (void)tol; (void)sd; (void)stop;
    ALIVE(c);
    i->m.time = start;
    return OK;
}
int fmi2EnterInitializationMode(void *c) { ALIVE(c); return OK; }
int fmi2ExitInitializationMode(void *c) { ALIVE(c); return OK; }
int fmi2Terminate(void *c) { ALIVE(c); return OK; }
int fmi2Reset(void *c) { ALIVE(c); i->m = lag_start; return OK; }

int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *v)
{
    ALIVE(c);
    for (size_t k = 0; k < n; k++)
        switch (vr[k]) {
        case 0: v[k] = i->m.time; break;
        case VR_U: v[k] = i->m.u; break;
        case VR_TAU: v[k] = i->m.tau; break;
        case VR_X: v[k] = i->m.x; break;
        default: return ERROR;
        }
    return OK;
}

int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *v)
{
    ALIVE(c);
    for (size_t k = 0; k < n; k++) {
        if (isnan(v[k])) {
            SAY(i, ERROR, "%s", "NaN is no value");
            return ERROR;
        }
        switch (vr[k]) {
        case VR_U: i->m.u = v[k]; i->m.slope = 0; break;
        case VR_TAU: i->m.tau = v[k]; break;
        default: return ERROR;
        }
    }
    return OK;
}

static int *integer(Instance *i, unsigned vr)
{
    return vr == VR_MODE ? &i->m.mode : vr == VR_N ? &i->m.n : vr == VR_FAULT ? &i->m.fault : NULL;
}
int fmi2GetInteger(void *c, const unsigned *vr, size_t n, int *v)
{
    ALIVE(c);
    for (size_t k = 0; k < n; k++) {
        int *p = integer(i, vr[k]);
        if (!p && vr[k] != VR_TWICE) return ERROR;
        v[k] = p ? *p : 2 * i->m.n;
    }
    return OK;
}
int fmi2SetInteger(void *c, const unsigned *vr, size_t n, const int *v)
{
    ALIVE(c);
    for (size_t k = 0; k < n; k++) {
        int *p = integer(i, vr[k]);
        if (!p) return ERROR;
        *p = v[k];
    }
    return OK;
}
int fmi2GetBoolean(void *c, const unsigned *vr, size_t n, int *v)
{
    ALIVE(c);
    for (size_t k = 0; k < n; k++)
        v[k] = vr[k] == VR_WARM ? i->m.x > 0.5 : i->m.invert;
    return OK;
}
int fmi2SetBoolean(void *c, const unsigned *vr, size_t n, const int *v)
{
    ALIVE(c);
    for (size_t k = 0; k < n; k++) {
        if (vr[k] != VR_INVERT) return ERROR;
        i->m.invert = v[k];
    }
    return OK;
}
int fmi2GetString(void *c, const unsigned *vr, size_t n, const char **v)
{
    ALIVE(c);
    for (size_t k = 0; k < n; k++) {
        if (vr[k] != VR_LABEL) return ERROR;
        v[k] = i->label;
    }
    return OK;
}
int fmi2SetString(void *c, const unsigned *vr, size_t n, const char *const *v)
{
    ALIVE(c);
    for (size_t k = 0; k < n; k++) {
        if (vr[k] != VR_LABEL) return ERROR;
        snprintf(i->label, sizeof i->label, "%s", v[k]);
    }
    return OK;
}

int fmi2SetRealInputDerivatives(void *c, const unsigned *vr, size_t n, const int *order, const double *v)
{
    ALIVE(c);
    for (size_t k = 0; k < n; k++) {
        if (vr[k] != VR_U || order[k] != 1) return ERROR;
        i->m.slope = v[k];
    }
    return OK;
}

int fmi2DoStep(void *c, double t, double h, int no_rollback)
{
    (void)no_rollback;
    ALIVE(c);
    if (fabs(t - i->m.time) > 1e-9 * (1 + fabs(t))) {
        SAY(i, ERROR, "%s", "the communication point does not fit");
        return ERROR;
    }
    switch (i->m.fault) {
    case FAULT_WARNING: SAY(i, WARNING, "plain warning, 100%"); break;
    case FAULT_DISCARD: SAY(i, DISCARD, "%s", "step too long"); return DISCARD;
    case FAULT_ERROR: SAY(i, ERROR, "%s at %d", "raw", 1); return ERROR;
    case FAULT_FATAL: SAY(i, FATAL, "%s", "memory is broken"); i->dead = 1; return FATAL;
    case FAULT_END: return DISCARD;
    }
    lag_step(&i->m, h);
    return i->m.fault == FAULT_WARNING ? WARNING : OK;
}
int fmi2GetBooleanStatus(void *c, int kind, int *v)
{
    ALIVE(c);
    *v = kind == 3 && i->m.fault == FAULT_END;
    return OK;
}

int fmi2GetFMUstate(void *c, void **s)
{
    ALIVE(c);
    if (!*s) *s = i->callbacks->allocate(1, sizeof i->m);
    memcpy(*s, &i->m, sizeof i->m);
    return OK;
}
int fmi2SetFMUstate(void *c, void *s) { ALIVE(c); memcpy(&i->m, s, sizeof i->m); return OK; }
int fmi2FreeFMUstate(void *c, void **s) { ALIVE(c); i->callbacks->release(*s); *s = NULL; return OK; }
int fmi2SerializedFMUstateSize(void *c, void *s, size_t *n) { ALIVE(c); (void)s; *n = sizeof i->m; return OK; }
int fmi2SerializeFMUstate(void *c, void *s, char *b, size_t n) { ALIVE(c); memcpy(b, s, n); return OK; }
int fmi2DeSerializeFMUstate(void *c, const char *b, size_t n, void **s)
{
    ALIVE(c);
    if (n != sizeof i->m) return ERROR;
    *s = i->callbacks->allocate(1, n);
    memcpy(*s, b, n);
    return OK;
}
