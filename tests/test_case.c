/* Case files: what is read, what is refused and with which words, and that nothing can hurt. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cns/case.h"
#include "core/memory.h"
#include "io/case_internal.h"
#include "support.h"

#define MINIMAL "model: lorenz\ntime: {end: 1}\n"

/* The case of a text without faults. */
static cns_case *good(const char *text, const char *const *sets, int n_sets)
{
    cns_case *c;
    char *report;
    cns_code code = cns_case_parse("t", text, strlen(text), sets, n_sets, &c, &report);
    if (code != CNS_OK)
        ck_abort_msg("refused:\n%s\n%s", text, report);
    ck_assert_ptr_nonnull(c);
    ck_assert_ptr_null(report);
    return c;
}

/* The text is refused with exactly this report. */
static void bad(const char *text, const char *wanted)
{
    cns_case *c;
    char *report;
    cns_code code = cns_case_parse("t", text, strlen(text), NULL, 0, &c, &report);
    ck_assert_msg(code == CNS_USAGE, "read without a fault:\n%s", text);
    ck_assert_ptr_null(c);
    ck_assert_str_eq(report, wanted);
    free(report);
}

static void bad_set(const char *text, const char *set, const char *wanted)
{
    cns_case *c;
    char *report;
    ck_assert_int_eq(cns_case_parse("t", text, strlen(text), &set, 1, &c, &report), CNS_USAGE);
    ck_assert_ptr_null(c);
    ck_assert_str_eq(report, wanted);
    free(report);
}

static char *printed(const cns_case *c)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    ck_assert_ptr_nonnull(out);
    cns_case_print(c, out);
    fclose(out);
    return text;
}

START_TEST(fills_in_defaults)
{
    cns_case *c = good(MINIMAL, NULL, 0);
    ck_assert_str_eq(c->name, "t");
    ck_assert_str_eq(c->text, MINIMAL);
    ck_assert_uint_eq(c->length, strlen(MINIMAL));
    ck_assert_uint_eq(strlen(c->sha256), 64);
    ck_assert_ptr_null(c->overrides);
    ck_assert_str_eq(c->model->name, "lorenz");
    for (int i = 0; i < c->model->n_parameters; i++)
        ck_assert_str_eq(c->parameters[i].text, c->model->parameters[i].standard);
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(cns_number_sign(&c->initial[i]), 0);
    ck_assert_str_eq(c->end.text, "1");
    ck_assert_str_eq(c->every.text, "1");
    ck_assert(!c->smooth && !c->has_goal && !c->has_numerics);
    ck_assert_int_eq(c->n_columns, 4);
    ck_assert_str_eq(cns_case_column_name(c, 0), "t");
    ck_assert_str_eq(cns_case_column_name(c, 3), "z");
    cns_case_free(c);
    cns_case_free(NULL);
}
END_TEST

START_TEST(reads_a_goal)
{
    cns_case *c = good("model: apw\nparameters: {I: 1.1}\ninitial: {theta: pi/3, Vy: -0.01}\n"
                       "time: {end: 10, every: 1/3}\nabs: {smooth: 1e-30}\n"
                       "goal: {significant: 12, max_digits: 100, max_time: 2.5}\n"
                       "output: {columns: [omega, t, Gamma]}\n"
                       "laws: {delta: 0.05, observable: Vx}\nlyapunov: {}\n",
                       NULL, 0);
    ck_assert_str_eq(c->parameters[0].text, "1.1");
    ck_assert_str_eq(c->initial[2].text, "pi/3");
    ck_assert(cns_number_sign(&c->initial[4]) < 0);
    ck_assert_str_eq(c->every.text, "1/3");
    ck_assert(c->smooth && c->has_goal && !c->has_numerics);
    ck_assert_str_eq(c->eps.text, "1e-30");
    ck_assert_int_eq(c->goal.decimals, 0);
    ck_assert_int_eq(c->goal.significant, 12);
    ck_assert_int_eq(c->goal.max_digits, 100);
    ck_assert(c->goal.max_time == 2.5);
    ck_assert_int_eq(c->n_columns, 3);
    ck_assert_int_eq(c->columns[0].kind, CNS_COLUMN_STATE);
    ck_assert_int_eq(c->columns[0].index, 5);
    ck_assert_int_eq(c->columns[1].kind, CNS_COLUMN_TIME);
    ck_assert_int_eq(c->columns[2].kind, CNS_COLUMN_OUTPUT);
    ck_assert_str_eq(cns_case_column_name(c, 2), "Gamma");
    cns_case_free(c);
}
END_TEST

START_TEST(reads_studies)
{
    cns_case *c =
        good("model: apw\ntime: {end: 1}\nlaws:\n  delta: 0.05\n  observable: Vx\n"
             "  digits: {from: 16, to: 25, by: 3}\n"
             "  steps: {method: taylor, order: 8, digits: 40, from: 1e-2, to: 1e-5, per_decade: 2}\n"
             "  smoothing: {from: 1e-4, to: 1e-30}\n"
             "lyapunov: {time: 500, arithmetic: mpfr, digits: 40}\n"
             "bisect: {parameter: CT, lower: 1.1, upper: 6/5, by: trajectory, decimals: 7}\n",
             NULL, 0);
    ck_assert(c->has_laws && c->laws.has_digits && c->laws.has_steps && c->laws.has_smoothing);
    ck_assert_str_eq(c->laws.delta.text, "0.05");
    ck_assert_int_eq(c->laws.observable, 3);
    ck_assert_int_eq(c->laws.digits.from, 16);
    ck_assert_int_eq(c->laws.digits.to, 25);
    ck_assert_int_eq(c->laws.digits.by, 3);
    ck_assert_int_eq(c->laws.steps.method, CNS_METHOD_TAYLOR);
    ck_assert_int_eq(c->laws.steps.order, 8);
    ck_assert_int_eq(c->laws.steps.digits, 40);
    ck_assert_str_eq(c->laws.steps.sizes.from.text, "1e-2");
    ck_assert_str_eq(c->laws.steps.sizes.to.text, "1e-5");
    ck_assert_int_eq(c->laws.steps.sizes.per_decade, 2);
    ck_assert_str_eq(c->laws.smoothing.to.text, "1e-30");
    ck_assert_int_eq(c->laws.smoothing.per_decade, 1);
    ck_assert(c->has_lyapunov && c->lyapunov.arithmetic == CNS_ARITH_MPFR && c->lyapunov.digits == 40);
    ck_assert_str_eq(c->lyapunov.time.text, "500");
    ck_assert(c->has_bisect && c->bisect.parameter == 1 && !c->bisect.by_manifold);
    ck_assert_str_eq(c->bisect.lower.text, "1.1");
    ck_assert_str_eq(c->bisect.upper.text, "6/5");
    ck_assert_int_eq(c->bisect.decimals, 7);
    cns_case_free(c);
    c = good(MINIMAL, NULL, 0);
    ck_assert(!c->has_laws && !c->has_lyapunov && !c->has_bisect);
    ck_assert_str_eq(c->laws.delta.text, "0.01");
    ck_assert_int_eq(c->laws.observable, CNS_OBSERVABLE_NORM);
    ck_assert(c->lyapunov.arithmetic == CNS_ARITH_DOUBLE && c->lyapunov.digits == 0);
    cns_case_free(c);
    bad(MINIMAL "laws: {digits: {from: 30, to: 20}}\n",
        "t:3:31: 'to' in 'laws.digits' must be above 'from' in 'laws.digits'");
    bad(MINIMAL "laws: {steps: {from: 1e-5, to: 1e-2}}\n",
        "t:3:32: 'to' in 'laws.steps' must be below 'from' in 'laws.steps'");
    bad(MINIMAL "laws: {steps: {from: 1e-2, to: 1e-5, order: 8}}\n",
        "t:3:45: 'order' of 'method: rk4' is 4 (or auto)");
    bad(MINIMAL "laws: {observable: q}\n", "t:3:20: unknown state 'q' of model lorenz; use x, y, z or norm");
    bad(MINIMAL "laws: {smoothing: {from: 1}}\n",
        "t:3:8: missing key 'to' in 'laws.smoothing': a number > 0");
    bad(MINIMAL "lyapunov: {digits: 30}\n",
        "t:3:12: 'digits' does not go with 'arithmetic: double', which has its own 53 bits");
    bad(MINIMAL "bisect: {parameter: R, lower: 2, upper: 1}\n",
        "t:3:41: 'upper' in 'bisect' must be above 'lower' in 'bisect'");
}
END_TEST

START_TEST(reads_numerics)
{
    cns_case *c = good(MINIMAL "numerics: {digits: 60}\n", NULL, 0);
    ck_assert_int_eq(c->numerics.method, CNS_METHOD_TAYLOR);
    ck_assert_int_eq(c->numerics.arithmetic, CNS_ARITH_FAST);
    ck_assert_int_eq(c->numerics.digits, 60);
    ck_assert_int_eq(c->numerics.order, 0);
    ck_assert(cns_number_sign(&c->numerics.step) == 0 && cns_number_sign(&c->numerics.tolerance) == 0);
    cns_case_free(c);
    c = good(MINIMAL "numerics: {digits: 60, order: 100, step: 1e-3, tolerance: 1e-50}\n", NULL, 0);
    ck_assert_int_eq(c->numerics.order, 100);
    ck_assert_str_eq(c->numerics.step.text, "1e-3");
    ck_assert_str_eq(c->numerics.tolerance.text, "1e-50");
    cns_case_free(c);
    c = good(MINIMAL "numerics: {method: rk4, arithmetic: double, step: 1e-3}\n", NULL, 0);
    ck_assert_int_eq(c->numerics.method, CNS_METHOD_RK4);
    ck_assert_int_eq(c->numerics.arithmetic, CNS_ARITH_DOUBLE);
    ck_assert_int_eq(c->numerics.digits, 0);
    ck_assert_int_eq(c->numerics.order, 4);
    cns_case_free(c);
    cns_case_free(good(MINIMAL "numerics: {arithmetic: double, order: 30}\n", NULL, 0));
    cns_case_free(good(MINIMAL "numerics: {method: rk4, order: 4, digits: 40, step: 1/128}\n", NULL, 0));
}
END_TEST

START_TEST(refuses_with_a_place)
{
    bad("", "t:1:1: the file is empty, or all comments; `cns help case` lists what a case file says");
    bad("# only a comment\n",
        "t:1:1: the file is empty, or all comments; `cns help case` lists what a case file says");
    bad("word\n", "t:1:1: a case file is a mapping of keys to values, not a single value");
    bad("- a\n", "t:1:1: a case file is a mapping of keys to values, not a list");
    bad("{}\n", "t:1:1: missing key 'model'\nt:1:1: missing key 'time'");
    bad("model: lorentz\ntime: {end: 1}\n", "t:1:8: unknown model 'lorentz'; did you mean 'lorenz'?");
    bad("modle: lorenz\ntime: {end: 1}\n", "t:1:1: unknown key 'modle'; did you mean 'model'?");
    bad("model: lorenz\ntime: {every: 1}\n",
        "t:2:1: missing key 'end' in 'time': a number between -1e300 and 1e300");
    bad("model: lorenz\ntime:\n", "t:2:6: 'time' has no value; it must be a mapping of keys to values");
    bad("model: lorenz\ntime: 5\n",
        "t:2:7: 'time' must be a mapping of keys to values: write 'time: {end: 5}'");
    bad("model: lorenz\ntime: {end: [1]}\n",
        "t:2:13: 'end' in 'time' must be a number between -1e300 and 1e300, not a list");
    bad("model: lorenz\ntime: {end: 0}\n", "t:2:13: 'end' in 'time' must differ from the start, 0");
    bad("model: lorenz\ntime: {end: 1, every: 1e-8}\n",
        "t:2:23: 'every' in 'time' makes more than 10000000 rows up to the end");
    bad(MINIMAL "abs: smoth\n", "t:3:6: 'abs' must be a mapping, or exact, not 'smoth'");
    bad(MINIMAL "abs: {}\n", "t:3:1: missing key 'smooth' in 'abs': a number > 0");
    bad(MINIMAL "digits: 5\n", "t:3:1: unknown key 'digits'; it belongs in 'numerics'");
    bad(MINIMAL "goal:\n  decimals: 5\n  model: apw\n",
        "t:5:3: unknown key 'model' in 'goal'; it belongs at the top, not indented");
    bad(MINIMAL "parameters: {sigma: ten}\n",
        "t:3:21: 'sigma' in 'parameters': 'ten' is not a number: use decimals, "
        "fractions and pi, as in 2.2, 1e-30, 8/3, 2*pi/3");
    bad(MINIMAL "initial: {w: 1}\n", "t:3:11: unknown state 'w' of model lorenz; use x, y or z");
    bad(MINIMAL "output: {columns: [t, X, t]}\n",
        "t:3:23: unknown column 'X' of model lorenz; did you mean 'x'?\nt:3:26: doubled column 't'");
    bad(MINIMAL "output: {columns: [t, growth]}\n",
        "t:3:23: column 'growth' is always printed, last; leave it out");
    bad(MINIMAL "output: {columns: []}\n",
        "t:3:19: 'columns' in 'output' must be a list of names, such as [t, x]");
    bad(MINIMAL "laws: 3\n", "t:3:7: 'laws' must be a mapping of keys to values: write 'laws: {delta: 3}'");
}
END_TEST

START_TEST(refuses_goals)
{
    bad(MINIMAL "goal: {}\n", "t:3:1: missing key in 'goal': 'decimals' or 'significant'");
    bad(MINIMAL "goal: {decimals: 5, significant: 5}\n",
        "t:3:21: 'goal' takes either 'decimals' or 'significant', not both");
    bad(MINIMAL "goal: {decimals: -5}\n",
        "t:3:18: 'decimals' in 'goal' must be an integer from 1 to 10000, not '-5'");
    bad(MINIMAL "goal: {decimals: 1e1}\n",
        "t:3:18: 'decimals' in 'goal' must be an integer from 1 to 10000, not '1e1'");
    bad(MINIMAL "goal: {decimals: 50, max_digits: 40}\n",
        "t:3:18: 'decimals' in 'goal' is above 'max_digits' (40)");
    bad(MINIMAL "goal: {decimals: 6000}\n",
        "t:3:18: 'decimals' in 'goal' is above 'max_digits' (5000, its default)");
    bad(MINIMAL "numerics: {digits: 5}\ngoal: {decimals: 5}\n",
        "t:4:1: 'goal' and 'numerics' exclude each other: keep one");
}
END_TEST

START_TEST(refuses_numerics)
{
    bad(MINIMAL "numerics: {}\n", "t:3:1: missing key 'digits' in 'numerics': an integer from 1 to 100000");
    bad(MINIMAL "numerics: {digts: 5}\n",
        "t:3:12: unknown key 'digts' in 'numerics'; did you mean 'digits'?");
    bad(MINIMAL "numerics: {digits: 100001}\n",
        "t:3:20: 'digits' in 'numerics' must be an integer from 1 to 100000, not '100001'");
    bad(MINIMAL "numerics: {digits: 20, arithmetic: quad}\n",
        "t:3:36: 'arithmetic' in 'numerics' must be fast, mpfr or double, not 'quad'; fast and mpfr "
        "compute with as many 'digits' as asked for");
    bad(MINIMAL "numerics: {method: rk4, digits: 20, arithmetic: fast, step: 1e-3}\n",
        "t:3:49: 'method: rk4' computes in mpfr or double");
    bad(MINIMAL "numerics: {digits: 20, order: full}\n",
        "t:3:31: 'order' in 'numerics' must be an integer from 1 to 100000, or auto, not 'full'");
    bad(MINIMAL "numerics: {digits: 20, arithmetic: double}\n",
        "t:3:12: 'digits' does not go with 'arithmetic: double', which has its own 53 bits");
    bad(MINIMAL "numerics: {arithmetic: double, order: 31}\n",
        "t:3:39: 'order' is at most 30 with 'arithmetic: double'");
    bad(MINIMAL "numerics: {method: rk4, digits: 20}\n",
        "t:3:1: 'method: rk4' needs a fixed 'step', such as 1e-3");
    bad(MINIMAL "numerics: {method: rk4, digits: 20, step: adaptive, order: 5}\n",
        "t:3:43: 'method: rk4' needs a fixed 'step', such as 1e-3\n"
        "t:3:60: 'order' of 'method: rk4' is 4 (or auto)");
    bad(MINIMAL "numerics: {digits: 20, step: 1e-16}\n",
        "t:3:30: 'step' makes more than 1e15 steps up to the end");
    bad(MINIMAL "numerics: {digits: 20, tolerance: 1}\n",
        "t:3:35: 'tolerance' in 'numerics' must be a number between 0 and 1, or auto, not '1'");
}
END_TEST

START_TEST(refuses_what_yaml_allows)
{
    bad("model: &m lorenz\ntime: {end: 1}\n", "t:1:8: anchors and aliases are not accepted: '&m'");
    bad("model: lorenz\ntime: {end: *e}\n", "t:2:13: anchors and aliases are not accepted: '*e'");
    bad("model: lorenz\ntime: {end: !!int 1}\n", "t:2:13: tags are not accepted: 'tag:yaml.org,2002:int'");
    bad(MINIMAL "---\nmodel: apw\n", "t:3:1: a second document begins; a case file holds one");
    bad(MINIMAL "time: {end: 2}\n", "t:3:1: doubled key 'time'; it is already on line 2");
    bad("model: lorenz\ntime:\n  end: 1\n  end: 2\n",
        "t:4:3: doubled key 'end' in 'time'; it is already on line 3");
    bad(MINIMAL "[a]: 1\n", "t:3:1: a key must be a word");
    bad("model: lor\xffnz\n", "t:1:11: byte 0xFF is not UTF-8 text; save the file as UTF-8");
    bad("model: lor\001nz\n", "t:1:11: control character 0x01; is this a text file?");
    bad("model: lorenz\ntime: {end: \"1\\0\"}\n", "t:2:13: a NUL character inside a text");
    bad(MINIMAL "goal: [[[[[[[[[[[[[[[[[[[[\n", "t:3:22: nested more than 16 deep; reading stops here");
    cns_case_free(good("%YAML 1.1\n---\n" MINIMAL "...\n", NULL, 0));
    cns_case_free(good("\xef\xbb\xbf" MINIMAL, NULL, 0));
    cns_case_free(good("{\"model\": 'lorenz', time: {end: \"2*3/7\"}}", NULL, 0));
}
END_TEST

START_TEST(reports_all_in_order)
{
    bad("numerics: {digits: -1, order: x}\nmodel: lorenz\nfoo: 1\ntime: {every: 0}\n",
        "t:1:20: 'digits' in 'numerics' must be an integer from 1 to 100000, not '-1'\n"
        "t:1:31: 'order' in 'numerics' must be an integer from 1 to 100000, or auto, not 'x'\n"
        "t:3:1: unknown key 'foo'; use model, parameters, initial, time, max_time, abs, goal, numerics, "
        "output, laws, "
        "lyapunov, orbit or bisect\n"
        "t:4:1: missing key 'end' in 'time': a number between -1e300 and 1e300\n"
        "t:4:15: 'every' in 'time' must be a number between 0 and 1e300, not '0'");
    /* a flood is cut off, and counted */
    char *text = cns_xalloc(4000, 8);
    strcpy(text, MINIMAL "initial:\n");
    for (int i = 0; i < 1000; i++)
        sprintf(text + strlen(text), " a%d: 1\n", i);
    cns_case *c;
    char *report;
    ck_assert_int_eq(cns_case_parse("t", text, strlen(text), NULL, 0, &c, &report), CNS_USAGE);
    int lines = 1;
    for (const char *p = report; *p != '\0'; p++)
        lines += *p == '\n';
    ck_assert_int_eq(lines, 101);
    ck_assert_ptr_nonnull(strstr(report, "\nt: 900 more"));
    free(report);
    free(text);
}
END_TEST

START_TEST(stops_at_limits)
{
    size_t size = 1024 * 1024 + 1;
    char *text = cns_xalloc(size + 1, 1);
    memset(text, '\n', size);
    memcpy(text, MINIMAL, strlen(MINIMAL));
    text[size] = '\0';
    bad(text, "t:1:1: larger than 1 MiB; this cannot be a case file");
    text[size - 1] = '\0';
    cns_case_free(good(text, NULL, 0));
    /* many keys, in few bytes */
    char *to = text + sprintf(text, "%s", MINIMAL "laws: [");
    for (int i = 0; i < 100000; i++)
        to += sprintf(to, "1,");
    strcpy(to, "]\n");
    cns_case *c;
    char *report;
    ck_assert_int_eq(cns_case_parse("t", text, strlen(text), NULL, 0, &c, &report), CNS_USAGE);
    ck_assert_ptr_nonnull(strstr(report, "more than 4096 keys and values; reading stops here"));
    free(report);
    free(text);
}
END_TEST

START_TEST(overrides)
{
    static const char *const sets[] = {"goal.decimals=20", "parameters.R = 30", "abs.smooth=1e-20",
                                       "goal.decimals=25", "time.every=1/2",    "laws.delta=0.1"};
    cns_case *c = good(MINIMAL "abs: exact\n", sets, 6);
    ck_assert(c->has_goal && c->smooth);
    ck_assert_int_eq(c->goal.decimals, 25);
    ck_assert_str_eq(c->eps.text, "1e-20");
    ck_assert_str_eq(c->every.text, "1/2");
    ck_assert_str_eq(c->overrides, "goal.decimals=20\nparameters.R = 30\nabs.smooth=1e-20\ngoal.decimals=25\n"
                                   "time.every=1/2\nlaws.delta=0.1");
    cns_case_free(c);
    static const char *const exact[] = {"abs=exact"};
    c = good(MINIMAL "abs: {smooth: 1e-3}\n", exact, 1);
    ck_assert(!c->smooth);
    cns_case_free(c);
    /* whatever could stand in the file, and the whole of it; later ones add to it */
    static const char *const whole[] = {"parameters={R: 3}", "output.columns = [t, y]",
                                        "laws={digits: {from: 16, to: 20}}", "laws.digits.by=2",
                                        "model='lorenz' # of 1963"};
    c = good(MINIMAL "parameters: {b: 3}\nlaws: {steps: {from: 1e-2, to: 1e-3}}\n", whole, 5);
    ck_assert_str_eq(c->parameters[1].text, "3");
    ck_assert_str_eq(c->parameters[2].text, "8/3");
    ck_assert_int_eq(c->n_columns, 2);
    ck_assert_str_eq(cns_case_column_name(c, 1), "y");
    ck_assert(c->laws.has_digits && !c->laws.has_steps);
    ck_assert_int_eq(c->laws.digits.by, 2);
    cns_case_free(c);
    /* a fault of the file that an override mends is none */
    static const char *const mended[] = {"time.end=5"};
    cns_case_free(good("model: lorenz\ntime: {end: x}\n", mended, 1));
}
END_TEST

START_TEST(refuses_overrides)
{
    bad_set(MINIMAL, "time.every=-1",
            "--set time.every=-1: 'every' in 'time' must be a number between 0 and 1e300, not '-1'");
    bad_set(MINIMAL, "time.ende=1", "--set time.ende=1: unknown key 'ende' in 'time'; did you mean 'end'?");
    bad_set(MINIMAL, "tim.end=1", "--set tim.end=1: unknown key 'tim'; did you mean 'time'?");
    bad_set(MINIMAL, "time.end", "--set time.end: write SECTION.KEY=VALUE, as in numerics.digits=80");
    bad_set(MINIMAL, "=1", "--set =1: write SECTION.KEY=VALUE, as in numerics.digits=80");
    bad_set(MINIMAL, "a..b=1", "--set a..b=1: write SECTION.KEY=VALUE, as in numerics.digits=80");
    bad_set(MINIMAL, "a.=1", "--set a.=1: write SECTION.KEY=VALUE, as in numerics.digits=80");
    bad_set(MINIMAL, "time.end=1\n2", "--set time.end=1?2: not one line of text in UTF-8 without tabs");
    bad_set(MINIMAL, "time.end=",
            "--set time.end=: 'end' in 'time' has no value; it must be a number between -1e300 and 1e300");
    bad_set(MINIMAL "goal: {decimals: 5}\n", "numerics.method=rk4",
            "--set numerics.method=rk4: missing in 'numerics': 'digits' and a fixed 'step'; add --set "
            "numerics.digits=40 --set numerics.step=1e-3");
    bad_set("model: lorenz\ntime: {end: 1, every: x}\n", "initial.q=1",
            "t:2:23: 'every' in 'time' must be a number between 0 and 1e300; 'x' is not a number: use "
            "decimals, fractions "
            "and pi, "
            "as in 2.2, 1e-30, 8/3, 2*pi/3\n"
            "--set initial.q=1: unknown state 'q' of model lorenz; use x, y or z");
    bad_set(MINIMAL, "output.columns=[t, q]",
            "--set output.columns=[t, q]: unknown column 'q' of model lorenz; use t, x, y or z");
    bad_set(
        MINIMAL, "output.columns=[t",
        "--set output.columns=[t: not YAML: did not find expected ',' or ']', while parsing a flow sequence");
    bad_set(MINIMAL, "initial={x: 1, x: 2}", "--set initial={x: 1, x: 2}: doubled key 'x' in 'initial'");
    bad_set(MINIMAL, "initial={x: [1]}",
            "--set initial={x: [1]}: 'x' in 'initial' must be a number, not a list");
    bad_set(MINIMAL, "initial=&a {x: 1}",
            "--set initial=&a {x: 1}: anchors and aliases are not accepted: '&a'");
    bad_set(
        MINIMAL, "time.end=3: 4",
        "--set time.end=3: 4: not YAML: a second ': ' on one line; keys of a section stand in braces, as in "
        "time: {end: 1}, or on lines of their own");
    bad("[\n", "t:2:1: not YAML: did not find expected node content, while parsing a flow node");
}
END_TEST

/* What is printed reads back to the same print. */
static void check_print(const char *text)
{
    cns_case *c = good(text, NULL, 0);
    char *once = printed(c);
    cns_case *again = good(once, NULL, 0);
    char *twice = printed(again);
    ck_assert_str_eq(once, twice);
    free(once);
    free(twice);
    cns_case_free(c);
    cns_case_free(again);
}

START_TEST(prints_what_reads_back)
{
    check_print(MINIMAL);
    static const char tenth[] = MINIMAL "goal: {decimals: 7, max_time: 0.1}\n";
    cns_case *c = good(tenth, NULL, 0);
    char *text = printed(c);
    ck_assert_ptr_nonnull(strstr(text, "max_time: 0.1\n"));
    free(text);
    cns_case_free(c);
    check_print(tenth);
    check_print(MINIMAL "goal: {decimals: 7, max_time: 1/3}\n");
    check_print(MINIMAL "goal: {decimals: 7, max_time: 1e3}\nabs: {smooth: 1e-30}\n");
    check_print(MINIMAL "goal: {significant: 7, max_digits: 70}\noutput: {columns: [z, t]}\n");
    check_print(MINIMAL "numerics: {digits: 50, order: 60, step: 1/64, tolerance: 1e-40}\n");
    check_print(MINIMAL "numerics: {method: rk4, arithmetic: double, step: 0.001}\n");
    check_print("model: apw\ntime: {start: 1/3, end: -2, every: 0.1}\n");
    check_print("model: apw\ntime: {start: 1, at: [1, 2/3, -0.5]}\n");
    check_print("model: apw\ninitial: {theta: ' -2 * pi / 3 ', x: +1}\ntime: {end: 3, every: 0.1}\n");
}
END_TEST

START_TEST(loads_files)
{
    cns_case *c;
    char *report;
    ck_assert_int_eq(cns_case_load("/nonexistent/a.yaml", NULL, 0, &c, &report), CNS_IO);
    ck_assert_str_eq(report, "cannot read /nonexistent/a.yaml: No such file or directory");
    ck_assert_ptr_null(c);
    free(report);
    ck_assert_int_eq(cns_case_load("/", NULL, 0, &c, &report), CNS_IO);
    ck_assert_str_eq(report, "cannot read /: Is a directory");
    free(report);
    char path[] = "/tmp/cns-case-XXXXXX";
    int fd = mkstemp(path);
    ck_assert_int_ge(fd, 0);
    FILE *out = fdopen(fd, "w");
    fputs(MINIMAL, out);
    fclose(out);
    ck_assert_int_eq(cns_case_load(path, NULL, 0, &c, &report), CNS_OK);
    ck_assert_str_eq(c->name, path);
    cns_case_free(c);
    remove(path);
}
END_TEST

/* Random changes of good files: read or refused, and what is read prints and reads back. */
START_TEST(survives_mutations)
{
    static const char *const seeds[] = {
        "model: apw\nparameters: {I: 2.2, CR: pi}\ninitial: {theta: 1, Vy: 0.01}\n"
        "time: {end: 300, every: 0.5}\nabs: {smooth: 1e-30}\ngoal: {decimals: 10, max_time: 5}\n"
        "output:\n  columns: [t, x, \"speed\"]\nlaws: {digits: {from: 16, to: 21}}\nbisect: {parameter: I, "
        "lower: 1, upper: 2}\n",
        "model: lorenz\ninitial:\n    x: -15.8\n    y: 8/3\ntime:\n    end: 100\n    every: 1\n"
        "numerics: {method: rk4, digits: 60, order: auto, step: 1e-3} # end\n"};
    static const char *const pieces[] = {
        ":",     "{",  "}",  "[",  "]",   ",",         "\n",     " ",   "- ",   "&a",  "*a",       "!!x",
        "---\n", "\"", "'",  "#",  "|",   ">",         "? ",     "%",   "1e99", "nan", "numerics", "\xc3",
        "\xe2",  "\t", "\r", "-1", "0x1", "digits: 3", "goal: ", "1/0", "pi",   "<<",  "\\0"};
    uint64_t s = test_seed();
    for (int round = 0; round < 4000; round++) {
        char text[2048];
        const char *seed = seeds[test_random_below(&s, 2)];
        size_t n = strlen(seed);
        memcpy(text, seed, n);
        for (int changes = 1 + (int)test_random_below(&s, 6); changes > 0; changes--) {
            size_t at = test_random_below(&s, n + 1);
            const char *piece = pieces[test_random_below(&s, COUNT(pieces))];
            size_t m = strlen(piece);
            size_t cut = test_random_below(&s, 3) == 0 ? test_random_below(&s, 20) : 0;
            if (cut > n - at)
                cut = n - at;
            memmove(text + at + m, text + at + cut, n - at - cut);
            memcpy(text + at, piece, m);
            n += m - cut;
        }
        text[n] = '\0';
        cns_case *c;
        char *report;
        cns_code code = cns_case_parse("t", text, n, NULL, 0, &c, &report);
        ck_assert(code == CNS_OK || code == CNS_USAGE);
        ck_assert((code == CNS_OK) == (report == NULL) && (code == CNS_OK) == (c != NULL));
        if (code == CNS_OK)
            check_print(text);
        cns_case_free(c);
        free(report);
    }
    mpfr_free_cache();
}
END_TEST

/* What the code that reads and prints values takes for granted of a row. */
START_TEST(keeps_each_key_in_a_field_of_its_kind)
{
    static const char *const identifier[] = {
#define KEY(id, ...) #id,
#include "io/case_keys.def"
#undef KEY
    };
    for (int i = 0; i < CNS_KEYS; i++) {
        const cns_key *k = &cns_keys[i], *section = cns_key_section(k);
        const bool number = k->type == FIELD_NUMBER || k->type == FIELD_DOUBLE;
        const bool integer = k->type == FIELD_INT || k->type == FIELD_LONG;
        for (size_t at = 0; at <= strlen(k->path); at++)
            ck_assert_msg(identifier[i][at] == (k->path[at] == '.' ? '_' : toupper(k->path[at])),
                          "%s is K_%s", k->path, identifier[i]);
        for (int j = 0; j < i; j++)
            ck_assert_msg(strcmp(cns_keys[j].path, k->path) != 0, "doubled: %s", k->path);
        ck_assert_msg((section != NULL) == (strchr(k->path, '.') != NULL), "no section: %s", k->path);
        ck_assert_msg(section == NULL || (section < k && section->kind == KEY_SECTION), "%s", k->path);
        switch (k->kind) {
        case KEY_SECTION:
            ck_assert_msg(k->type == FIELD_BOOL || k->type == FIELD_NONE, "%s", k->path);
            break;
        case KEY_STATE:
        case KEY_PARAMETER:
            ck_assert_msg(k->type == FIELD_INT, "%s", k->path);
            break;
        case KEY_INTEGER:
            ck_assert_msg(integer && k->least <= k->most, "%s", k->path);
            break;
        case KEY_NUMBER:
            ck_assert_msg(number && (k->words[0].text == NULL || k->above != NULL), "%s", k->path);
            break;
        case KEY_WORD:
            ck_assert_msg((integer || k->type == FIELD_BOOL) && k->words[1].text != NULL, "%s", k->path);
            break;
        default:
            ck_assert_msg(k->type == FIELD_NONE && k->standard == NULL, "%s", k->path);
            break;
        }
        for (int w = 0; w < CNS_KEY_WORDS && k->kind == KEY_NUMBER; w++)
            ck_assert_msg(k->words[w].value == 0, "%s", k->path);
        for (int j = 0; j < i; j++) /* it is initialised and cleared once */
            ck_assert_msg(k->type != FIELD_NUMBER || cns_keys[j].field != k->field, "%s", k->path);
    }
}
END_TEST

START_TEST(lists_the_keys)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    cns_case_print_keys(out);
    fclose(out);
    static const char *const keys[] = {"model",     "every",   "smooth", "max_digits",
                                       "tolerance", "columns", "laws"};
    for (int i = 0; i < COUNT(keys); i++)
        ck_assert_ptr_nonnull(strstr(text, keys[i]));
    free(text);
}
END_TEST

Suite *suite_case(void)
{
    Suite *suite = suite_create("case");
    TCase *reading = tcase_create("reading");
    tcase_add_test(reading, fills_in_defaults);
    tcase_add_test(reading, reads_a_goal);
    tcase_add_test(reading, reads_numerics);
    tcase_add_test(reading, reads_studies);
    tcase_add_test(reading, overrides);
    tcase_add_test(reading, loads_files);
    suite_add_tcase(suite, reading);
    TCase *faults = tcase_create("faults");
    tcase_add_test(faults, refuses_with_a_place);
    tcase_add_test(faults, refuses_goals);
    tcase_add_test(faults, refuses_numerics);
    tcase_add_test(faults, refuses_what_yaml_allows);
    tcase_add_test(faults, reports_all_in_order);
    tcase_add_test(faults, stops_at_limits);
    tcase_add_test(faults, refuses_overrides);
    suite_add_tcase(suite, faults);
    TCase *whole = tcase_create("whole");
    tcase_add_test(whole, prints_what_reads_back);
    tcase_add_test(whole, survives_mutations);
    tcase_add_test(whole, keeps_each_key_in_a_field_of_its_kind);
    tcase_add_test(whole, lists_the_keys);
    suite_add_tcase(suite, whole);
    return suite;
}
