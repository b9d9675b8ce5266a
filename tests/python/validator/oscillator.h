/* A mass on a spring with a damper, as plain C: the model of a small FMU that has nothing to do with this project.
 *
 *     dx/dt = v,   dv/dt = (force - k x - d v) / m
 *
 * Each fault of the seeded-fault test is a word in `fault_text`, which the test writes into the compiled library. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* 16 bytes of mark, then the name of the fault. */
const volatile char fault_text[48] = "SEEDED-FAULT-IS:none";

static int fault(const char *name) {
    const volatile char *have = fault_text + 16;
    while (*name && *name == *have) name++, have++;
    return *name == 0 && *have == 0;
}

/* Value references; all but the last few are floating point numbers. */
enum { TIME, X, V, DER_X, DER_V, FORCE, POWER, MASS, DAMPING, STIFFNESS, LIMIT, GRAVITY, STRAIN, DISTANCE, BEYOND = 20, SOLVER = 21, LABEL = 22 };

typedef struct {
    double time, x, v, force, slope, mass, damping, stiffness, limit;
    double stop;
    int has_stop, beyond, solver, calls, mode, user;
    char label[32];
} Values;

typedef struct {
    Values now;
    int logging, exchange;
    void *environment;
    void *logger;
} Instance;

static double shared_force;

/* Memory that nobody frees. */
static void *volatile lost;
static void lose(size_t bytes) {
    lost = malloc(bytes);
    memset(lost, 1, bytes);
}

static void set_defaults(Values *s) {
    memset(s, 0, sizeof *s);
    s->x = 0.5;
    s->mass = fault("start") ? 1.1 : 1.0;
    s->damping = 0.4;
    s->stiffness = 25.0;
    s->limit = 0.2;
    s->solver = 1;
    strcpy(s->label, fault("start_text") ? "spring" : "oscillator");
}

static double acceleration(const Instance *c, double x, double v, double force) {
    const Values *s = &c->now;
    double k = s->stiffness;
    if (fault("dynamics_exchange") && c->exchange) k *= 1.02;
    if (fault("dynamics_steps") && !c->exchange) k *= 1.02;
    if (fault("dynamics")) k *= 1.02;
    if (fault("set_disturbs") && s->user) k *= 1.5;
    return (force - k * x - s->damping * v) / s->mass;
}

/* Runge and Kutta's method in steps of a millisecond at most. */
static void integrate(Instance *c, double h) {
    Values *s = &c->now;
    int n = (int)ceil(h / 1e-3 - 1e-9);
    if (fault("step_ignored")) h = 0.01;
    if (n < 1) n = 1;
    double dt = h / n, t = 0;
    for (int i = 0; i < n; i++, t += dt) {
        double f0 = s->force + s->slope * t, f1 = f0 + 0.5 * s->slope * dt, f2 = f0 + s->slope * dt;
        if (fault("instances_share")) f0 = f1 = f2 = shared_force;
        double a1 = acceleration(c, s->x, s->v, f0), v1 = s->v;
        double v2 = s->v + 0.5 * dt * a1, a2 = acceleration(c, s->x + 0.5 * dt * v1, v2, f1);
        double v3 = s->v + 0.5 * dt * a2, a3 = acceleration(c, s->x + 0.5 * dt * v2, v3, f1);
        double v4 = s->v + dt * a3, a4 = acceleration(c, s->x + dt * v3, v4, f2);
        s->x += dt / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
        s->v += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    s->force += s->slope * h;
    s->time += h;
    s->beyond = s->x > s->limit;
    if (fault("random")) s->x += 1e-6 * rand() / RAND_MAX;
}

/* 1 if the value was read. */
static int get_real(Instance *c, unsigned vr, double *value) {
    Values *s = &c->now;
    if (fault("get_changes")) s->x += 1e-6;
    switch (vr) {
    case TIME: *value = s->time; break;
    case X: *value = fault("output_nan") ? NAN : s->x; break;
    case V: *value = s->v; break;
    case DER_X: *value = s->v; break;
    case DER_V: *value = acceleration(c, s->x, s->v, s->force) * (fault("derivative_declared") ? 1.02 : 1.0); break;
    case FORCE: *value = s->force; break;
    case POWER: *value = s->force * s->v + (fault("dependency") ? 0.1 * s->x : 0.0); break;
    case MASS: *value = s->mass; break;
    case DAMPING: *value = s->damping; break;
    case STIFFNESS: *value = s->stiffness; break;
    case LIMIT: *value = s->limit; break;
    case GRAVITY: *value = 9.81; break;
    case DISTANCE: *value = s->x - s->limit; break;
    case STRAIN: *value = fault("value_outside") ? -1.0 : fabs(s->x); break;
    default: return 0;
    }
    return 1;
}

/* 0 done, 1 no such reference or not to be set, 2 value refused. */
static int set_real(Instance *c, unsigned vr, double value) {
    Values *s = &c->now;
    double *target = 0, low = -INFINITY;
    s->user = 1;
    if (fault("tunable_refused") && vr == DAMPING && s->time > 0.0) return 1;
    switch (vr) {
    case FORCE: target = &s->force; shared_force = value; break;
    case MASS: target = &s->mass; low = 0.1; break;
    case DAMPING: target = &s->damping; low = 0.0; break;
    case STIFFNESS: target = &s->stiffness; low = 0.0; break;
    case LIMIT: target = &s->limit; break;
    case X: target = &s->x; break;
    case V: target = &s->v; break;
    case GRAVITY: if (fault("constant_settable")) return 0; return 1;
    default: return 1;
    }
    if (fault("nan_crash") && isnan(value)) abort();
    if (!fault("nan_accepted") && !isfinite(value)) return 2;
    if (!fault("range_unchecked") && value < low) return 2;
    if (fault("set_lost") && vr == DAMPING) return 0;
    *target = value;
    if (fault("set_order") && vr == STIFFNESS) s->damping = 0.02 * value;
    if (fault("set_order") && vr == MASS) s->damping *= value;
    return 0;
}

/* The slope of an unknown over a known. */
static double partial(const Instance *c, unsigned unknown, unsigned of) {
    const Values *s = &c->now;
    double wrong = fault("directional") ? 1.02 : 1.0;
    if (unknown == DER_X) return of == V ? 1.0 : 0.0;
    if (unknown == DER_V && of == X) return -wrong * s->stiffness / s->mass;
    if (unknown == DER_V && of == V) return -s->damping / s->mass;
    if (unknown == DER_V && of == FORCE) return (fault("directional_sign") ? -1.0 : 1.0) / s->mass;
    if (unknown == POWER) return of == FORCE ? (c->exchange ? 1.0 : wrong) * s->v : of == V ? s->force : 0.0;
    if (unknown == X || unknown == V) return unknown == of ? 1.0 : 0.0;
    if (unknown == STRAIN && of == X) return s->x < 0 ? -1.0 : 1.0;
    return 0.0;
}

/* The slope of an output in time. */
static int output_slope(Instance *c, unsigned vr, double *value) {
    Values *s = &c->now;
    switch (vr) {
    case X: *value = s->v * (fault("output_derivative") ? 1.05 : 1.0); return 1;
    case POWER: *value = s->force * acceleration(c, s->x, s->v, s->force) + s->slope * s->v; return 1;
    case STRAIN: *value = s->x < 0 ? -s->v : s->v; return 1;
    default: return 0;
    }
}

static double indicator(const Instance *c) {
    double z = c->now.x - c->now.limit;
    return fault("indicator_jumps") ? (z > 0 ? 1.0 : -1.0) : z;
}

/* Saved states. */
static void save(const Instance *c, Values *to) {
    *to = c->now;
    if (fault("rollback")) to->v = 0.0;
    if (fault("rollback_input")) to->force = 0.0;
}

static void restore(Instance *c, const Values *from) {
    double force = c->now.force;
    c->now = *from;
    if (fault("rollback_input")) c->now.force = force;
}

static void pack(const Values *from, void *bytes) {
    Values copy = *from;
    if (fault("serialize")) copy.x = 0.0;
    memcpy(bytes, &copy, sizeof copy);
}

static void forget(Instance *c) {
    Values old = c->now;
    if (fault("reset_nothing")) return;
    set_defaults(&c->now);
    if (fault("reset_parameter")) c->now.stiffness = old.stiffness;
}

/* What happens inside a step apart from the step. */
static int mishap(Instance *c) {
    if (fault("crash")) *(volatile int *)8 = 1;
    if (fault("abort")) abort();
    if (fault("exit")) exit(0);
    while (fault("hang")) sleep(1);
    if (fault("step_error") && c->now.calls > 3) return 1;
    if (fault("leak_step")) lose(64);
    c->now.calls++;
    return 0;
}
