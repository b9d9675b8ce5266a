/* First-order lag: dx/dt = (gain u - x) / T. */
#include "model.h"
enum { X = 1, DER_X, U, GAIN, T, FIRST_OF_MANY = 1000 };
#define STATES 1
#define INDICATORS 0

/* Number of further variables: the quirk "many-N". */
static unsigned many(void) {
    char text[32];
    for (int i = 0; i < 32; i++) text[i] = quirk_text[16 + i];
    return strncmp(text, "many-", 5) ? 0 : atoi(text + 5);
}
static void set_defaults(Values *s) {
    memset(s, 0, sizeof *s);
    s->u = s->p[0] = s->p[1] = 1.0;
    if (quirk("start-rounded")) s->p[0] = 1.0 + 2.3e-16;
    s->next = INFINITY;
}
static double *real(Values *s, unsigned vr, int for_set) {
    static double scratch;
    if (vr == X) return quirk("nan") && !for_set && s->steps > 2 ? (scratch = NAN, &scratch) : s->x;
    if (vr == U) return &s->u;
    if (vr == GAIN) return s->p;
    if (vr == T) return s->p + 1;
    if (for_set) return 0;
    if (vr == TIME) return &s->time;
    if (vr == DER_X) return derivatives(s, &scratch), &scratch;
    if (vr >= FIRST_OF_MANY && vr - FIRST_OF_MANY < many()) return scratch = vr - FIRST_OF_MANY + s->x[0], &scratch;
    return 0;
}
static int64_t *whole(Values *s, unsigned vr, int for_set) { return 0; }
static void derivatives(const Values *s, double *der) { der[0] = (s->p[0] * s->u - s->x[0]) / s->p[1]; }
static double indicator(const Values *s) { return 0.0; }
static int event(Values *s) { return 0; }
static void advance(Values *s, double h) {
    double end = s->p[0] * s->u, T = s->p[1] * (quirk("loose-solver") ? 1.001 : 1.0);
    s->x[0] = end + (s->x[0] - end) * exp(-h / T);
    /* An internal solver that starts again from a restored state has another step size and another error. */
    if (quirk("solver-restart") && s->restarted) s->x[0] *= 1 + 1e-9;
    s->restarted = 0;
    s->time += h;
}
