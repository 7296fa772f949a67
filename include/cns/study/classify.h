/* Modes: what a trajectory ends in, found by following it.
 *
 * The motion is watched where it passes a section: where its angle is a multiple of half a turn (in general,
 * of the model's turn), broadside on for a falling disk, or, for a model without an angle, where a state
 * rises through a level. Each return there is reduced by the model's symmetries, turns and the mirror image,
 * and the motion repeats when reduced returns do. Then:
 *
 * - period: the least time after which the state repeats, up to whole revolutions of the angle and up to
 * place (states that nothing feeds back on);
 * - winding: whole revolutions of the angle in a period, signed;
 * - symmetry, what the motion does besides: `mirror` if half a period makes it its own mirror image, `turn`
 * if a part of a period turns it by less than a revolution and otherwise repeats it, `none` if there is
 * neither. Where the section is a level, the model's symmetries, and products of two of them, are tried by
 * their names, as Lorenz's `half-turn`: does the cycle pass through the image of one of its states?
 * - returns: passages through the section until it repeats, up to symmetry. The simplest flutter and the
 * simplest tumble have one; two is what a period doubling makes of that, whatever the symmetry does to the
 * period in time.
 *
 * A mode is decided by the system's own trajectory, not by a nearby one: it is followed twice, with different
 * precisions, and with more digits where its noise could have grown to what decides (as near a saddle); the
 * cycle is then found by Newton's method with the variational equations and must attract, its multiplier
 * being less than one. Chaos is so up to a time, by its
 * largest exponent, statistically: a positive one, by six standard errors, whose growth is stationary by the
 * tests of cns/study/lyapunov.h. A trajectory that does neither is `undecided`. */
#ifndef CNS_STUDY_CLASSIFY_H
#define CNS_STUDY_CLASSIFY_H

#include "cns/monitor.h"
#include "cns/system.h"

CNS_BEGIN_DECLS

typedef enum cns_mode {
    CNS_MODE_UNDECIDED,
    CNS_MODE_STEADY,   /* tends to a fixed point */
    CNS_MODE_FLUTTER,  /* periodic, the angle from side to side: winding 0 */
    CNS_MODE_TUMBLE,   /* periodic, the angle going round */
    CNS_MODE_PERIODIC, /* periodic, in a model without an angle */
    CNS_MODE_CHAOTIC
} cns_mode;

const char *cns_mode_name(cns_mode mode);

typedef struct cns_classify_spec {
    int observable;  /* whose extrema are wanted: a state; -1: the last dynamic one */
    double until;    /* time to follow the motion for at most; 0: 60000 steps, and longer where that does not
                        tell */
    long max_digits; /* that may be used to follow it */
} cns_classify_spec;

#define CNS_SYMMETRY_NAME 64

/* Texts are decimals, all right, NULL where they do not apply. */
typedef struct cns_motion {
    cns_mode mode;
    char note[256]; /* why it is undecided, up to when it is chaotic, or what else to know; may be empty */
    /* Of periodic motions: */
    char symmetry[CNS_SYMMETRY_NAME]; /* "none", or what a part of the period does, as above */
    long winding;
    int returns;
    char *period;
    char *amplitude; /* half the range of the angle; winding 0 only; without an angle, of the observable */
    char *descent;   /* mean speed of fall, if the model has a height */
    char **drift;    /* per state: its change in a period; NULL for dynamic states */
    int n_states;
    double multiplier; /* of one repetition, the largest modulus */
    /* Of all: */
    double lambda, lambda_se; /* largest exponent; lambda_se < 0: not measured. Of periodic motions, which
                                 attract but for a shift along the cycle, it is 0, which is not measured */
    double transient, time;   /* when the late motion begins (chaos: from when on the exponent
                                 was measured); how far it was followed */
    long digits;              /* of the finest run; 0: double */
    int extrema;              /* maxima of the observable: of a period, or of chaos for some time */
    char **maximum;           /* chaos: six digits of a shadowing trajectory's, a sample */
} cns_motion;

/* *motion is to be cleared whatever is returned. That a motion is undecided is a result, not a failure;
 * so it is with CNS_STOPPED, up to then.
 * CNS_NUMERIC: the trajectory runs into a singularity; CNS_STOPPED; CNS_USAGE: less than two dynamic states.
 */
cns_code cns_classify(const cns_system *s, const cns_classify_spec *spec, const cns_monitor *monitor,
                      cns_motion *motion, cns_error *err);
void cns_motion_clear(cns_motion *motion);

CNS_END_DECLS

#endif
