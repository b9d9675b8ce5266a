/* A staircase: `level` rises by 1 every quarter of a second. Time events only, no continuous states. */
#include "model.h"
enum { LEVEL = 1 };
#define STATES 0
#define INDICATORS 0
#define PERIOD 0.25

static void set_defaults(Values *s) {
    memset(s, 0, sizeof *s);
    s->next = PERIOD;
}
static double *real(Values *s, unsigned vr, int for_set) { return vr == TIME && !for_set ? &s->time : 0; }
static int64_t *whole(Values *s, unsigned vr, int for_set) { return vr == LEVEL && !for_set ? s->whole : 0; }
static void derivatives(const Values *s, double *der) {}
static double indicator(const Values *s) { return 0.0; }
static int event(Values *s) {
    while (s->time >= s->next - 1e-9) s->whole[0]++, s->next += PERIOD;
    return 0;
}
static void advance(Values *s, double h) {
    s->time += h;
    event(s);
}
