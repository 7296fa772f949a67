/* Where a smooth function has its maximum between the ends of a short interval. Private to src/study/predict.
 */
#ifndef CNS_STUDY_PREDICT_PEAK_H
#define CNS_STUDY_PREDICT_PEAK_H

/* A maximum that is to exceed 1 is looked for from where the parabola has it at this much, being in error. */
#define CNS_PEAK_NEAR 0.99

typedef struct cns_peak {
    double t, value;
} cns_peak;

/* The largest of f from t[0] to t[2], from its values at both and at the middle t[1]. Where the parabola
 * through them has a maximum between the ends, or near them, of a value >= `least`, it is located by golden
 * sections, to some 1e-8 of the interval (nearer, values of double precision do not differ); else it is the
 * largest of the three. f is no parabola: a vertex outside by a quarter of the interval is still followed. */
cns_peak cns_peak_find(double (*f)(void *context, double t), void *context, const double t[3],
                       const double value[3], double least);

#endif
