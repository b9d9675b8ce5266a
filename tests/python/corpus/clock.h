/* A counter of the ticks of a periodic input clock of 0.1 s (FMI 3 only, event mode). */
#include "model.h"
enum { TICK = 1, COUNT };
#define STATES 0
#define INDICATORS 0
#define HAS_CLOCK 1

static void set_defaults(Values *s) {
    memset(s, 0, sizeof *s);
    s->next = INFINITY;
}
static double *real(Values *s, unsigned vr, int for_set) { return vr == TIME && !for_set ? &s->time : 0; }
static int64_t *whole(Values *s, unsigned vr, int for_set) { return vr == COUNT && !for_set ? s->whole : 0; }
static void derivatives(const Values *s, double *der) {}
static double indicator(const Values *s) { return 0.0; }
static int event(Values *s) {
    s->whole[0] += s->ticking;
    s->ticking = 0;
    return 0;
}
static void advance(Values *s, double h) { s->time += h; }
