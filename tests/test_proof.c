/* What a proof rests on: the bound of errors, places that are certain, and differences that are no chaos. */
#include <math.h>
#include <string.h>

#include "problem.h"
#include "solve/proof.h"

/* e = 16 max(|fine - coarse|, noise), and the most of what it is asked for. */
START_TEST(errors_are_bounded)
{
    mpfr_t a, b, e;
    mpfr_inits2(200, a, b, e, (mpfr_ptr)0);
    mpfr_set_zero(e, 1);
    mpfr_set_d(a, 1 + 0x1p-40, MPFR_RNDN);
    mpfr_set_ui(b, 1, MPFR_RNDN);
    cns_proof_error(e, a, b, -HUGE_VAL);
    ck_assert_int_eq(mpfr_cmp_ui_2exp(e, 1, -36), 0);
    cns_proof_error(e, b, a, -50); /* less noise than difference */
    ck_assert_int_eq(mpfr_cmp_ui_2exp(e, 1, -36), 0);
    cns_proof_error(e, b, b, -38); /* no difference, by accident */
    ck_assert_int_eq(mpfr_cmp_ui_2exp(e, 1, -34), 0);
    cns_proof_error(e, a, b, -45);
    ck_assert_int_eq(mpfr_cmp_ui_2exp(e, 1, -34), 0);
    mpfr_set_nan(a);
    cns_proof_error(e, a, b, -HUGE_VAL);
    ck_assert_int_eq(mpfr_cmp_ui_2exp(e, 1, -34), 0);
    mpfr_clears(a, b, e, (mpfr_ptr)0);
}
END_TEST

static const struct {
    const char *x, *e;
    cns_places places;
    long most, found;
} certain[] = {
    {"0.123456789", "1e-7", CNS_PLACES_DECIMALS, 40, 6},
    {"0.123456789", "1e-7", CNS_PLACES_DECIMALS, 3, 3},
    {"12.3456789", "1e-7", CNS_PLACES_SIGNIFICANT, 40, 8},
    {"0.12499999999", "1e-7", CNS_PLACES_DECIMALS, 40,
     6}, /* next to a boundary of two decimals, not of six */
    {"0.12499999999", "1e-7", CNS_PLACES_DECIMALS, 2, 1},
    {"0.49999999999", "1e-7", CNS_PLACES_DECIMALS, 0, -1},
    {"0.5", "0.6", CNS_PLACES_DECIMALS, 40, -1},
    {"1e-9", "1e-7", CNS_PLACES_SIGNIFICANT, 40, -1},
    {"1e-9", "0", CNS_PLACES_SIGNIFICANT, 40, 40},
    {"nan", "1e-7", CNS_PLACES_DECIMALS, 40, -1},
    {"1", "nan", CNS_PLACES_DECIMALS, 40, -1},
};

/* Alone, and with a value beside it that is certain to any places. */
START_TEST(places_are_certain)
{
    mpfr_t x, e, one, zero;
    mpfr_inits2(300, x, e, one, zero, (mpfr_ptr)0);
    mpfr_set_str(x, certain[_i].x, 10, MPFR_RNDN);
    mpfr_set_str(e, certain[_i].e, 10, MPFR_RNDN);
    mpfr_set_ui(one, 1, MPFR_RNDN);
    mpfr_set_zero(zero, 1);
    const cns_bounded value[] = {{one, zero}, {x, e}, {one, zero}};
    ck_assert_int_eq(cns_proof_places(&value[1], 1, certain[_i].places, certain[_i].most), certain[_i].found);
    ck_assert_int_eq(cns_proof_places(value, 3, certain[_i].places, certain[_i].most), certain[_i].found);
    mpfr_clears(x, e, one, zero, (mpfr_ptr)0);
}
END_TEST

/* The two runs differ in all that a common error could come from: limbs, order, and every step. */
START_TEST(the_two_runs_differ)
{
    long part[] = {80, 60, 40};
    const cns_schedule schedule = {.n = COUNT(part), .digits = part, .end = 3};
    cns_system *system = system_new(cns_model_find("apw"), NULL);
    const cns_problem p = {.system = system};
    const cns_numerics by_hand[] = {
        {.method = CNS_METHOD_TAYLOR, .arithmetic = CNS_ARITH_FAST, .digits = 40},
        {.method = CNS_METHOD_TAYLOR, .arithmetic = CNS_ARITH_FAST, .digits = 40, .order = 30}};
    for (int i = 0; i < 3; i++) {
        cns_proof_runs r;
        if (i == 0)
            cns_proof_of_goal(&r, &p, part[0] + CNS_ANOTHER_LIMB, &schedule);
        else
            cns_proof_of_numerics(&r, &p, &by_hand[i - 1], CNS_PROOF_TWO_RUNS);
        ck_assert_int_eq(r.fine_digits - r.coarse_digits, CNS_ANOTHER_LIMB);
        ck_assert_int_gt(r.fine.prec, r.coarse.prec + 64);
        ck_assert_int_gt(r.fine.order, r.coarse.order);
        ck_assert_double_gt(r.fine.safety, r.coarse.safety);
        ck_assert(r.fine.verify && r.coarse.verify);
        ck_assert_double_le(r.fine.tolerance_log2, r.coarse.tolerance_log2 - 64);
        if (i == 0)
            for (int k = 0; k < COUNT(part); k++) {
                const double t = k + 0.5;
                const long coarse = cns_schedule_at(r.coarse.schedule, t) + r.coarse.schedule_shift,
                           fine = cns_schedule_at(r.fine.schedule, t) + r.fine.schedule_shift;
                ck_assert_int_eq(coarse, part[k]);
                ck_assert_int_eq(fine, part[k] + CNS_ANOTHER_LIMB);
            }
        cns_proof_runs_clear(&r);
    }
    cns_system_free(system);
}
END_TEST

/* Two runs of case 4 to t, of 120 and 98 digits; the finer one may have another value of I. Both differences
 * in log2: of the states, and what noise has grown to in the coarser run. */
static cns_code two_runs(const char *inertia, const char *t, double *difference, double *noise,
                         cns_error *found)
{
    cns_code code = CNS_OK;
    cns_number *time = numbers_new(1, &t);
    cns_sample sample[2];
    *difference = -HUGE_VAL;
    for (int run = 0; run < 2; run++) {
        const cns_setting settings[] = {
            {"I", run ? "2.2" : inertia}, {"theta", "1"}, {"Vy", "0.01"}, {"omega", "1"}, {NULL, NULL}};
        cns_system *system = system_new(cns_model_find("apw"), settings);
        const cns_program *program = cns_system_program(system);
        cns_error err;
        cns_trajectory_spec spec = {.flow = taylor_spec(program, run ? 98 : 120),
                                    .initial = cns_system_initial(system)};
        cns_trajectory *trajectory = cns_trajectory_new(&spec, &err);
        ck_assert_ptr_nonnull(trajectory);
        ck_assert(cns_sample_init(&sample[run], program, spec.flow.prec));
        check_ok(cns_trajectory_at(trajectory, time->ratio, &sample[run], &err), &err);
        if (run) {
            cns_problem problem = {.system = system};
            code = cns_proof_explained(&problem, &sample[0], &sample[1], 4, found);
        }
        cns_trajectory_free(trajectory);
        cns_system_free(system);
    }
    for (int i = 2; i < 6; i++)
        *difference = fmax(*difference, log2_distance(sample[0].state[i], sample[1].state[i]));
    *noise = sample[1].error_log2;
    cns_sample_clear(&sample[0]);
    cns_sample_clear(&sample[1]);
    numbers_free(time, 1);
    return code;
}

/* A constant that one run has to 60 digits only: the difference is larger than noise times growth explains.
 */
START_TEST(a_rounded_constant_shows)
{
    double difference, noise;
    cns_error found;
    ck_assert_int_eq(two_runs("2.2", "4", &difference, &noise, &found), CNS_OK);
    ck_assert_msg(difference < noise + 24, "2^%.1f of 2^%.1f", difference, noise);
    ck_assert_int_eq(two_runs("2.20000000000000000000000000000000000000000000000000000000000003", "4",
                              &difference, &noise, &found),
                     CNS_NUMERIC);
    ck_assert_msg(strstr(found.text, "not chaos") != NULL, "%s", found.text);
    ck_assert_msg(difference > DECIMALS(64) && difference < DECIMALS(58), "2^%.1f", difference);
    ck_assert_msg(difference > noise + 64, "2^%.1f of 2^%.1f", difference, noise);
}
END_TEST

Suite *suite_proof(void)
{
    Suite *suite = suite_create("proof");
    TCase *tc = tcase_create("proof");
    tcase_add_test(tc, errors_are_bounded);
    add_table_test(tc, places_are_certain, certain);
    tcase_add_test(tc, the_two_runs_differ);
    tcase_add_test(tc, a_rounded_constant_shows);
    suite_add_tcase(suite, tc);
    return suite;
}
