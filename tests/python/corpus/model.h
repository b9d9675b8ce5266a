/* What every model of the corpus has. A model is a file that defines the functions below for `Values`; fmi2.c and fmi3.c give it an
 * interface. The name of a special behaviour stands in `quirk_text`, which the test writes into the compiled library. */
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

const volatile char quirk_text[48] = "CORPUS-QUIRK-IS:none";

static int quirk(const char *name) {
    const volatile char *have = quirk_text + 16;
    while (*name && *name == *have) name++, have++;
    return *name == 0 && *have == 0;
}

typedef struct {
    double time, stop, x[2], u, p[4], next;
    int64_t whole[4];
    uint8_t blob[16];
    size_t blob_size;
    int has_stop, restarted, steps, ticking;
} Values;

typedef struct {
    Values now;
    int logging;
    void *environment, *logger, *memory;
    char name[64];
} Instance;

enum { TIME = 0 }; /* the value reference of time in every model */

static void set_defaults(Values *s);
/* The place of a floating point variable, or NULL; `for_set` if it will be written. */
static double *real(Values *s, unsigned vr, int for_set);
/* The place of an integer variable of any width, or NULL. */
static int64_t *whole(Values *s, unsigned vr, int for_set);
static void derivatives(const Values *s, double *der);
static double indicator(const Values *s);
/* Discrete changes at an event; true if a continuous state jumped. */
static int event(Values *s);
/* Solution over `h` with constant input. */
static void advance(Values *s, double h);

/* What goes wrong in the third step. */
static void mishap(Values *s) {
    if (s->steps++ != 2) return;
    if (quirk("print-end")) puts("\"end\""), fflush(stdout); /* as a protocol on standard output might end */
    if (quirk("segfault") || quirk("print-end")) *(volatile int *)8 = 1;
    if (quirk("exit")) exit(0);
    while (quirk("hang")) sleep(1);
    if (quirk("raise")) raise(SIGTERM);
    if (quirk("signal-parent")) kill(getppid(), SIGTERM);
    if (quirk("print")) puts("{\"final\": \"a line of the FMU\"}"), fflush(stdout);
}
