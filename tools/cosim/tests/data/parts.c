/* Four FMI 2.0 FMUs for tests of systems, written against the standard's text alone. The guid picks one:
 *
 *   rotor   J w' = -torque                                    torque in, speed out
 *   spring  phi' = speed - w2, J w2' = k phi, torque = k phi  speed in, torque out; the far end carries a mass of its own
 *   gain    y = g u                                           passes through without a step in between
 *   mixer   y = g u + k tanh(v) + c                           as gain, with directional derivatives
 *
 * Both mechanical parts are solved exactly for inputs that are lines, so that all error is the coupling's. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

enum { OK, WARNING, DISCARD, ERROR };
/* Value references; `longest` is the longest step that is accepted, `until` the time at which the FMU wants to end. */
enum { VR_U = 1, VR_Y, VR_J, VR_K, VR_W, VR_LONGEST, VR_G, VR_N, VR_TWICE, VR_UNTIL, VR_V, COUNT };

typedef struct {
    double v[COUNT], slope, phi, time;
    int n, flag;
} Part;

typedef struct {
    Part m;
    char kind;
    const Callbacks *callbacks;
    char name[64];
} Instance;

#define SAY(i, status, text) (i)->callbacks->logger((i)->callbacks->environment, (i)->name, status, "all", "%s", text)

const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }

static const Part start = {.v = {[VR_J] = 1, [VR_K] = 1, [VR_LONGEST] = 1e9, [VR_G] = 1, [VR_UNTIL] = 1e99}};

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *f, int visible, int logging)
{
    (void)resources; (void)visible; (void)logging;
    if (type != 1 || (strcmp(guid, "rotor") && strcmp(guid, "spring") && strcmp(guid, "gain") && strcmp(guid, "mixer"))) return NULL;
    Instance *i = f->allocate(1, sizeof *i);
    i->m = start;
    i->kind = guid[0];
    i->callbacks = f;
    snprintf(i->name, sizeof i->name, "%s", name);
    return i;
}
void fmi2FreeInstance(void *c) { Instance *i = c; i->callbacks->release(i); }
int fmi2SetupExperiment(void *c, int td, double tol, double t0, int sd, double stop)
{
    (void)td; (void)tol; (void)sd; (void)stop;
    ((Instance *)c)->m.time = t0;
    return OK;
}
int fmi2EnterInitializationMode(void *c) { (void)c; return OK; }
int fmi2ExitInitializationMode(void *c) { (void)c; return OK; }
int fmi2Terminate(void *c) { (void)c; return OK; }
int fmi2Reset(void *c) { ((Instance *)c)->m = start; return OK; }

static double output(const Instance *i)
{
    const Part *m = &i->m;
    if (i->kind == 'm') return m->v[VR_G] * m->v[VR_U] + m->v[VR_K] * tanh(m->v[VR_V]) + m->v[VR_J];
    return i->kind == 'r' ? m->v[VR_W] : i->kind == 's' ? m->v[VR_K] * m->phi : m->v[VR_G] * m->v[VR_U];
}

int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *v)
{
    Instance *i = c;
    for (size_t k = 0; k < n; k++) v[k] = vr[k] == VR_Y ? output(i) : i->m.v[vr[k]];
    return OK;
}
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *v)
{
    Instance *i = c;
    for (size_t k = 0; k < n; k++) {
        i->m.v[vr[k]] = v[k];
        if (vr[k] == VR_U) i->m.slope = 0;
    }
    return OK;
}
int fmi2GetInteger(void *c, const unsigned *vr, size_t n, int *v)
{
    for (size_t k = 0; k < n; k++) v[k] = vr[k] == VR_N ? ((Instance *)c)->m.n : 2 * ((Instance *)c)->m.n;
    return OK;
}
int fmi2SetInteger(void *c, const unsigned *vr, size_t n, const int *v)
{
    (void)vr;
    for (size_t k = 0; k < n; k++) ((Instance *)c)->m.n = v[k];
    return OK;
}
int fmi2GetBoolean(void *c, const unsigned *vr, size_t n, int *v)
{
    (void)vr;
    for (size_t k = 0; k < n; k++) v[k] = ((Instance *)c)->m.n > 0;
    return OK;
}
int fmi2SetBoolean(void *c, const unsigned *vr, size_t n, const int *v) { (void)c; (void)vr; (void)n; (void)v; return ERROR; }
int fmi2GetString(void *c, const unsigned *vr, size_t n, const char **v) { (void)c; (void)vr; (void)n; (void)v; return ERROR; }
int fmi2SetString(void *c, const unsigned *vr, size_t n, const char *const *v) { (void)c; (void)vr; (void)n; (void)v; return ERROR; }

int fmi2SetRealInputDerivatives(void *c, const unsigned *vr, size_t n, const int *order, const double *v)
{
    for (size_t k = 0; k < n; k++) {
        if (vr[k] != VR_U || order[k] != 1) return ERROR;
        ((Instance *)c)->m.slope = v[k];
    }
    return OK;
}

int fmi2GetDirectionalDerivative(void *c, const unsigned *z, size_t nz, const unsigned *x, size_t nx, const double *dx, double *dz)
{
    Instance *i = c;
    if (i->kind != 'm' || nz != 1 || z[0] != VR_Y) return ERROR;
    double t = tanh(i->m.v[VR_V]);
    dz[0] = 0;
    for (size_t k = 0; k < nx; k++) dz[0] += dx[k] * (x[k] == VR_U ? i->m.v[VR_G] : i->m.v[VR_K] * (1 - t * t));
    return OK;
}

int fmi2DoStep(void *c, double t, double h, int no_rollback)
{
    (void)no_rollback;
    Instance *i = c;
    Part *m = &i->m;
    if (fabs(t - m->time) > 1e-9 * (1 + fabs(t))) {
        SAY(i, ERROR, "the communication point does not fit");
        return ERROR;
    }
    if (h > m->v[VR_LONGEST]) {
        SAY(i, DISCARD, "the step is too long for me");
        return DISCARD;
    }
    if (t + h > m->v[VR_UNTIL]) return DISCARD;
    double u = m->v[VR_U], s = m->slope, J = m->v[VR_J], *w = &m->v[VR_W];
    if (i->kind == 'r') *w -= (u + 0.5 * s * h) * h / J;
    if (i->kind == 's') {
        /* z = w2 - (u + s t) swings freely. */
        double W = sqrt(m->v[VR_K] / J), z = *w - u, dz = m->v[VR_K] * m->phi / J - s;
        double C = cos(W * h), S = sin(W * h);
        *w = z * C + dz / W * S + u + s * h;
        m->phi = J / m->v[VR_K] * (dz * C - z * W * S + s);
    }
    m->v[VR_U] = u + s * h;
    m->time += h;
    return OK;
}
int fmi2GetBooleanStatus(void *c, int kind, int *v)
{
    *v = kind == 3 && ((Instance *)c)->m.v[VR_UNTIL] < 1e99;
    return OK;
}
int fmi2GetFMUstate(void *c, void **s)
{
    Instance *i = c;
    if (!*s) *s = i->callbacks->allocate(1, sizeof i->m);
    memcpy(*s, &i->m, sizeof i->m);
    return OK;
}
int fmi2SetFMUstate(void *c, void *s) { memcpy(&((Instance *)c)->m, s, sizeof(Part)); return OK; }
int fmi2FreeFMUstate(void *c, void **s) { ((Instance *)c)->callbacks->release(*s); *s = NULL; return OK; }
