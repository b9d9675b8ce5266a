/* The model behind both test FMUs: a first-order lag, x' = rate (u - x) / tau, solved exactly for linear u. */
#ifndef LAG_H
#define LAG_H
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Value references, the same in both model descriptions. */
enum { VR_U = 1, VR_TAU, VR_MODE, VR_INVERT, VR_X, VR_WARM, VR_N, VR_TWICE, VR_FAULT, VR_LABEL, VR_SIZE, VR_Y, VR_SINGLE };

/* What `fault` makes doStep do. */
enum { FAULT_NONE, FAULT_WARNING, FAULT_DISCARD, FAULT_ERROR, FAULT_FATAL, FAULT_END };

typedef struct {
    double u, slope, tau, x, time;
    int mode, invert, n, fault;
    unsigned long long size;
} Lag;

static const Lag lag_start = {.u = 0, .tau = 2, .mode = 2, .size = 2};

/* mode 1 stands still, 2 is normal, 3 is twice as fast */
static void lag_step(Lag *m, double h)
{
    double sign = m->invert ? -1 : 1, u = sign * m->u, s = sign * m->slope;
    if (m->mode > 1) {
        double T = m->tau / (m->mode - 1);
        m->x = u + s * (h - T) + (m->x - u + s * T) * exp(-h / T);
    }
    m->time += h;
}
#endif
