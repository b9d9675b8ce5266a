/* Integers that no double holds, and binary data: each output repeats its parameter or input (FMI 3 only). With the quirk "other-start" two
 * parameters start at other values than the XML says: the integer by 1, the binary data in one bit. */
#include "model.h"
enum { LOW = 1, HIGH, BLOB, LOW_OUT, HIGH_OUT, SIZE, ECHO, IN, THROUGH };
#define STATES 0
#define INDICATORS 0
#define HAS_BINARY 1

static void set_defaults(Values *s) {
    memset(s, 0, sizeof *s);
    s->whole[0] = -9007199254740993;
    s->whole[0] += quirk("other-start");
    s->whole[1] = (int64_t)UINT64_MAX;
    memcpy(s->blob, "\x00\xff\x80\x41", s->blob_size = 4);
    s->blob[3] ^= quirk("other-start");
    s->next = INFINITY;
}
static double *real(Values *s, unsigned vr, int for_set) { return vr == TIME && !for_set ? &s->time : 0; }
static int64_t *whole(Values *s, unsigned vr, int for_set) {
    if (vr == LOW || vr == HIGH) return s->whole + vr - LOW;
    if (vr == IN) return s->whole + 3;
    if (for_set) return 0;
    if (vr == THROUGH) return s->whole + 3;
    if (vr == LOW_OUT || vr == HIGH_OUT) return s->whole + vr - LOW_OUT;
    if (vr == SIZE) return s->whole[2] = s->blob_size, s->whole + 2;
    return 0;
}
static void derivatives(const Values *s, double *der) {}
static double indicator(const Values *s) { return 0.0; }
static int event(Values *s) { return 0; }
static void advance(Values *s, double h) { s->time += h; }
