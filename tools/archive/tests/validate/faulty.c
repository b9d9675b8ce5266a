/* A small FMI 2.0 Co-Simulation FMU, x' = -x, that fails in one way: FAULT_... is set by the compiler's -D. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

typedef struct { double x, time; } Model;
#define EXPORT __attribute__((visibility("default")))
#define OK 0
#define ERROR 3

static double start_value = 1;

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT void *fmi2Instantiate(const char *n, int t, const char *g, const char *r, const void *f, int v, int l)
{
#ifdef FAULT_INSTANTIATE
    return NULL;
#endif
    Model *m = calloc(1, sizeof *m);
    m->x = start_value;
    return m;
}
EXPORT void fmi2FreeInstance(void *c) { free(c); }
EXPORT int fmi2SetupExperiment(void *c, int td, double t, double s, int sd, double e) { return OK; }
EXPORT int fmi2EnterInitializationMode(void *c) { return OK; }
EXPORT int fmi2ExitInitializationMode(void *c)
{
#ifdef FAULT_LIFE_CYCLE
    return ERROR;
#endif
    return OK;
}
EXPORT int fmi2Terminate(void *c) { return OK; }
EXPORT int fmi2Reset(void *c)
{
    Model *m = c;
    m->time = 0;
#ifndef FAULT_RESET
    m->x = start_value;
#endif
    return OK;
}
EXPORT int fmi2DoStep(void *c, double t, double h, int n)
{
    Model *m = c;
    m->x *= exp(-h);
    m->time += h;
#ifdef FAULT_CRASH
    abort();
#endif
    return OK;
}
EXPORT int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *v)
{
    for (size_t k = 0; k < n; k++) {
        v[k] = vr[k] == 1 ? ((Model *)c)->x : 0;
#ifdef FAULT_NOT_FINITE
        v[k] = 0.0 / 0.0;
#endif
    }
    return OK;
}

/* The rest of the interface: present, and not asked for here. */
#define ABSENT(name) EXPORT int name(void *c) { return ERROR; }
ABSENT(fmi2SetDebugLogging) ABSENT(fmi2GetInteger) ABSENT(fmi2GetBoolean) ABSENT(fmi2GetString)
ABSENT(fmi2SetReal) ABSENT(fmi2SetInteger) ABSENT(fmi2SetBoolean) ABSENT(fmi2SetString)
ABSENT(fmi2GetFMUstate) ABSENT(fmi2SetFMUstate) ABSENT(fmi2FreeFMUstate) ABSENT(fmi2SerializedFMUstateSize)
ABSENT(fmi2SerializeFMUstate) ABSENT(fmi2DeSerializeFMUstate) ABSENT(fmi2GetDirectionalDerivative)
ABSENT(fmi2SetRealInputDerivatives) ABSENT(fmi2GetRealOutputDerivatives) ABSENT(fmi2CancelStep)
ABSENT(fmi2GetStatus) ABSENT(fmi2GetRealStatus) ABSENT(fmi2GetIntegerStatus) ABSENT(fmi2GetBooleanStatus)
ABSENT(fmi2GetStringStatus)
