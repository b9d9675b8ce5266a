/* Weighted sum with direct feedthrough: y = a u + b v. */
#include "model.h"
enum { Y = 1, U, V, A, B };
#define STATES 0
#define INDICATORS 0

static void set_defaults(Values *s) {
    memset(s, 0, sizeof *s);
    s->p[0] = s->p[1] = 1.0;
    s->next = INFINITY;
}
static double *real(Values *s, unsigned vr, int for_set) {
    if (vr == U) return &s->u;
    if (vr == V) return s->p + 2;
    if (vr == A) return s->p;
    if (vr == B) return s->p + 1;
    if (for_set) return 0;
    if (vr == TIME) return &s->time;
    if (vr == Y) return s->p[3] = s->p[0] * s->u + s->p[1] * s->p[2], s->p + 3;
    return 0;
}
static int64_t *whole(Values *s, unsigned vr, int for_set) { return 0; }
static void derivatives(const Values *s, double *der) {}
static double indicator(const Values *s) { return 0.0; }
static int event(Values *s) { return 0; }
static void advance(Values *s, double h) { s->time += h; }
