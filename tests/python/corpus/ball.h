/* A ball on a hard floor: dh/dt = v, dv/dt = -g; at h = 0 the speed becomes -e v. The flight has a closed form, so Co-Simulation is exact. */
#include "model.h"
#include <float.h>
enum { H = 1, V, DER_H, DER_V, GRAVITY, RESTITUTION, DISTANCE };
#define STATES 2
#define INDICATORS 1

static void set_defaults(Values *s) {
    memset(s, 0, sizeof *s);
    s->x[0] = 1.0;
    s->p[0] = 9.81;
    s->p[1] = 0.7;
    s->next = INFINITY;
}
static double *real(Values *s, unsigned vr, int for_set) {
    static double scratch[2];
    if (vr == H || vr == V) return s->x + vr - H;
    if (vr == GRAVITY || vr == RESTITUTION) return s->p + vr - GRAVITY;
    if (for_set) return 0;
    if (vr == TIME) return &s->time;
    if (vr == DER_H || vr == DER_V) return derivatives(s, scratch), scratch + vr - DER_H;
    if (vr == DISTANCE) return s->x;
    return 0;
}
static int64_t *whole(Values *s, unsigned vr, int for_set) { return 0; }
static void derivatives(const Values *s, double *der) { der[0] = s->x[1], der[1] = -s->p[0]; }
static double indicator(const Values *s) { return s->x[0]; }
static int event(Values *s) {
    if (s->x[0] > 0 || s->x[1] >= 0) return 0;
    s->x[0] = DBL_MIN; /* above the floor, so that the next contact crosses zero again */
    s->x[1] *= -s->p[1];
    return 1;
}
static void advance(Values *s, double h) {
    s->time += h;
    for (;;) {
        double v = s->x[1], fall = (v + sqrt(v * v + 2 * s->p[0] * s->x[0])) / s->p[0], dt = fall < h ? fall : h;
        s->x[0] += v * dt - 0.5 * s->p[0] * dt * dt;
        s->x[1] -= s->p[0] * dt;
        if (fall > h) return;
        s->x[0] = 0;
        event(s);
        h -= dt;
    }
}
