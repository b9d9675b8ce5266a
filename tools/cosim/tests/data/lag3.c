/* An FMI 3.0 Co-Simulation FMU for the tests of the client, written against the standard's text alone. */
#include "lag.h"
#include <stdbool.h>
#include <stdint.h>

typedef void (*Logger)(void *, int, const char *, const char *);
typedef struct {
    Lag m;
    Logger logger;
    void *environment;
    char label[64];
    int dead;
} Instance;

enum { OK, WARNING, DISCARD, ERROR, FATAL };

#define SAY(i, status, text) (i)->logger((i)->environment, status, "all", text)
/* A client that calls after Fatal does not get away with it. */
#define ALIVE(c) Instance *i = c; if (i->dead) abort()

const char *fmi3GetVersion(void) { return "3.0"; }

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                  bool events, bool early, const uint32_t *required, size_t n, void *environment,
                                  Logger logger, void *intermediate)
{
    (void)name; (void)visible; (void)logging; (void)events; (void)early; (void)required; (void)n; (void)intermediate;
    int bad_path = resources && (resources[0] != '/' || resources[strlen(resources) - 1] != '/');
    if (strcmp(token, "lag-guid") || bad_path) {
        logger(environment, ERROR, "all", "the token is not mine");
        return NULL;
    }
    Instance *i = calloc(1, sizeof *i);
    i->m = lag_start;
    i->logger = logger;
    i->environment = environment;
    return i;
}

void fmi3FreeInstance(void *c) { ALIVE(c); free(i); }
int fmi3EnterInitializationMode(void *c, bool td, double tol, double start, bool sd, double stop)
{
    (void)td; (void)tol; (void)sd; (void)stop;
    ALIVE(c);
    i->m.time = start;
    return OK;
}
int fmi3ExitInitializationMode(void *c) { ALIVE(c); return OK; }
int fmi3EnterConfigurationMode(void *c) { ALIVE(c); return OK; }
int fmi3ExitConfigurationMode(void *c) { ALIVE(c); return OK; }
int fmi3Terminate(void *c) { ALIVE(c); return OK; }
int fmi3Reset(void *c) { ALIVE(c); i->m = lag_start; return OK; }

int fmi3GetFloat64(void *c, const uint32_t *vr, size_t n, double *v, size_t nv)
{
    ALIVE(c);
    double *end = v + nv;
    for (size_t k = 0; k < n; k++)
        switch (vr[k]) {
        case 0: *v++ = i->m.time; break;
        case VR_U: *v++ = i->m.u; break;
        case VR_TAU: *v++ = i->m.tau; break;
        case VR_X: *v++ = i->m.x; break;
        case VR_Y: /* x, 2 x, 3 x, ... */
            for (size_t e = 1; e <= i->m.size && v < end; e++) *v++ = e * i->m.x;
            break;
        default: return ERROR;
        }
    return v == end ? OK : ERROR;
}
int fmi3SetFloat64(void *c, const uint32_t *vr, size_t n, const double *v, size_t nv)
{
    (void)nv;
    ALIVE(c);
    for (size_t k = 0; k < n; k++) {
        if (isnan(v[k])) {
            SAY(i, ERROR, "NaN is no value");
            return ERROR;
        }
        switch (vr[k]) {
        case VR_U: i->m.u = v[k]; break;
        case VR_TAU: i->m.tau = v[k]; break;
        default: return ERROR;
        }
    }
    return OK;
}
int fmi3GetFloat32(void *c, const uint32_t *vr, size_t n, float *v, size_t nv)
{
    (void)vr; (void)nv;
    ALIVE(c);
    for (size_t k = 0; k < n; k++) v[k] = (float)i->m.x;
    return OK;
}

/* Each integer variable answers to the functions of its own type only. */
#define SCALAR(Name, type, reference, field)                                                    \
    int fmi3Get##Name(void *c, const uint32_t *vr, size_t n, type *v, size_t nv)                \
    {                                                                                           \
        ALIVE(c); (void)nv;                                                                     \
        for (size_t k = 0; k < n; k++) { if (vr[k] != reference) return ERROR; v[k] = field; }  \
        return OK;                                                                              \
    }                                                                                           \
    int fmi3Set##Name(void *c, const uint32_t *vr, size_t n, const type *v, size_t nv)          \
    {                                                                                           \
        ALIVE(c); (void)nv;                                                                     \
        for (size_t k = 0; k < n; k++) { if (vr[k] != reference) return ERROR; field = v[k]; }  \
        return OK;                                                                              \
    }
#define NOTHING(Name, type)                                                                     \
    int fmi3Get##Name(void *c, const uint32_t *vr, size_t n, type *v, size_t nv)                \
    { (void)c; (void)vr; (void)n; (void)v; (void)nv; return ERROR; }                            \
    int fmi3Set##Name(void *c, const uint32_t *vr, size_t n, const type *v, size_t nv)          \
    { (void)c; (void)vr; (void)n; (void)v; (void)nv; return ERROR; }
SCALAR(Int64, int64_t, VR_MODE, i->m.mode)
SCALAR(UInt64, uint64_t, VR_SIZE, i->m.size)
SCALAR(Int8, int8_t, VR_N, i->m.n)
SCALAR(UInt8, uint8_t, VR_FAULT, i->m.fault)
NOTHING(UInt16, uint16_t)
NOTHING(Int32, int32_t)
NOTHING(UInt32, uint32_t)
int fmi3SetFloat32(void *c, const uint32_t *vr, size_t n, const float *v, size_t nv)
{ (void)c; (void)vr; (void)n; (void)v; (void)nv; return ERROR; }
int fmi3SetInt16(void *c, const uint32_t *vr, size_t n, const int16_t *v, size_t nv)
{ (void)c; (void)vr; (void)n; (void)v; (void)nv; return ERROR; }
int fmi3GetInt16(void *c, const uint32_t *vr, size_t n, int16_t *v, size_t nv)
{
    ALIVE(c); (void)vr; (void)nv;
    for (size_t k = 0; k < n; k++) v[k] = (int16_t)(2 * i->m.n);
    return OK;
}

int fmi3GetBoolean(void *c, const uint32_t *vr, size_t n, bool *v, size_t nv)
{
    ALIVE(c); (void)nv;
    for (size_t k = 0; k < n; k++) v[k] = vr[k] == VR_WARM ? i->m.x > 0.5 : i->m.invert;
    return OK;
}
int fmi3SetBoolean(void *c, const uint32_t *vr, size_t n, const bool *v, size_t nv)
{
    ALIVE(c); (void)nv;
    for (size_t k = 0; k < n; k++) {
        if (vr[k] != VR_INVERT) return ERROR;
        i->m.invert = v[k];
    }
    return OK;
}
int fmi3GetString(void *c, const uint32_t *vr, size_t n, const char **v, size_t nv)
{
    ALIVE(c); (void)nv; (void)vr;
    for (size_t k = 0; k < n; k++) v[k] = i->label;
    return OK;
}
int fmi3SetString(void *c, const uint32_t *vr, size_t n, const char *const *v, size_t nv)
{
    ALIVE(c); (void)nv; (void)vr;
    for (size_t k = 0; k < n; k++) snprintf(i->label, sizeof i->label, "%s", v[k]);
    return OK;
}

int fmi3DoStep(void *c, double t, double h, bool no_rollback, bool *event, bool *end, bool *early, double *last)
{
    (void)no_rollback;
    ALIVE(c);
    *event = *early = false;
    *end = i->m.fault == FAULT_END;
    if (fabs(t - i->m.time) > 1e-9 * (1 + fabs(t))) {
        SAY(i, ERROR, "the communication point does not fit");
        return ERROR;
    }
    switch (i->m.fault) {
    case FAULT_WARNING: SAY(i, WARNING, "plain warning, 100%"); break;
    case FAULT_DISCARD: SAY(i, DISCARD, "step too long"); return DISCARD;
    case FAULT_ERROR: SAY(i, ERROR, "%s at %d"); return ERROR;
    case FAULT_FATAL: SAY(i, FATAL, "memory is broken"); i->dead = 1; return FATAL;
    }
    lag_step(&i->m, h);
    *last = t + h;
    return i->m.fault == FAULT_WARNING ? WARNING : OK;
}

int fmi3GetFMUState(void *c, void **s)
{
    ALIVE(c);
    if (!*s) *s = malloc(sizeof i->m);
    memcpy(*s, &i->m, sizeof i->m);
    return OK;
}
int fmi3SetFMUState(void *c, void *s) { ALIVE(c); memcpy(&i->m, s, sizeof i->m); return OK; }
int fmi3FreeFMUState(void *c, void **s) { ALIVE(c); free(*s); *s = NULL; return OK; }
int fmi3SerializedFMUStateSize(void *c, void *s, size_t *n) { ALIVE(c); (void)s; *n = sizeof i->m; return OK; }
int fmi3SerializeFMUState(void *c, void *s, uint8_t *b, size_t n) { ALIVE(c); memcpy(b, s, n); return OK; }
int fmi3DeserializeFMUState(void *c, const uint8_t *b, size_t n, void **s)
{
    ALIVE(c);
    if (n != sizeof i->m) return ERROR;
    *s = malloc(n);
    memcpy(*s, b, n);
    return OK;
}
