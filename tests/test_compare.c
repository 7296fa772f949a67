/* Tables compared: decimals, grids, separators, missing values, T_c, and what is refused. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cns/study/compare.h"
#include "io/read_table.h"
#include "num/exact_decimal.h"
#include "support.h"

enum { MAX_ROWS = 64, MAX_COLUMNS = 8 };

typedef struct outcome {
    cns_code code;
    cns_error err;
    cns_compare_result r;
    int rows;
    char t[MAX_ROWS][64];
    long least[MAX_ROWS], each[MAX_ROWS][MAX_COLUMNS];
    int columns;
} outcome;

static void on_begin(void *context, int n, const char *const *names)
{
    outcome *o = context;
    (void)names;
    o->columns = n;
}

static void on_row(void *context, const char *t, long least, const long *each)
{
    outcome *o = context;
    ck_assert_int_lt(o->rows, MAX_ROWS);
    snprintf(o->t[o->rows], sizeof o->t[0], "%s", t);
    o->least[o->rows] = least;
    for (int k = 0; k < o->columns && k < MAX_COLUMNS; k++)
        o->each[o->rows][k] = each[k];
    o->rows++;
}

static void write_file(char *path, const char *text, size_t length)
{
    strcpy(path, "/tmp/cns-compare.XXXXXX");
    int fd = mkstemp(path);
    ck_assert_int_ge(fd, 0);
    ck_assert_int_eq((int)write(fd, text, length), (int)length);
    close(fd);
}

/* Values that agree to fewer decimals than this are counted. */
enum { ASKED = 3 };

static void compare(outcome *o, const char *a, const char *b, const char *delta)
{
    char path_a[64], path_b[64];
    cns_number limit;
    memset(o, 0, sizeof *o);
    cns_number_init(&limit);
    ck_assert_int_eq((int)cns_number_parse(&limit, delta, NULL), CNS_OK);
    write_file(path_a, a, strlen(a));
    write_file(path_b, b, strlen(b));
    cns_table_reader *ra = cns_table_reader_open(path_a, &o->err), *rb = NULL;
    if (ra)
        rb = cns_table_reader_open(path_b, &o->err);
    o->code = o->err.code;
    if (rb) {
        const cns_compare_spec spec = {.a = cns_table_reader_rows(ra),
                                       .b = cns_table_reader_rows(rb),
                                       .delta = &limit,
                                       .decimals = ASKED,
                                       .context = o,
                                       .begin = on_begin,
                                       .row = on_row};
        o->code = cns_compare(&spec, &o->r, &o->err);
    }
    cns_table_reader_close(ra);
    cns_table_reader_close(rb);
    unlink(path_a);
    unlink(path_b);
    cns_number_clear(&limit);
}

static void done(outcome *o)
{
    cns_compare_result_clear(&o->r);
}

/* The code is CNS_OK. */
static void compared(outcome *o, const char *a, const char *b, const char *delta)
{
    compare(o, a, b, delta);
    if (o->code)
        ck_abort_msg("code %d: %s", (int)o->code, o->err.text);
}

START_TEST(decimals)
{
    static const struct {
        const char *a, *b;
        long agreed;
    } row[] = {{"1.2346", "1.23456789", 4}, /* a correct rounding */
               {"1.2345", "1.23456789", 3}, /* a wrong one: off by 0.68 units of the last */
               {"1.25", "1.249", 2},        /* within half a unit of 0.01 */
               {"0.5000", "0.5001", 3},
               {"12.5", "13.5", -1},
               {"1.5", "1.0", 0},
               {"1e-5", "0.00001", 5},
               {"-0.25", "0.25", 0},
               {"2.5D+01", "25", 0},
               {"1.00000", "0.99999", 4},
               {"100", "1e2", -2},
               {"5.", ".5e1", 0},
               {"-0.000", "0.0000", 3},
               {"0.123456789012345678901234567890", "0.123456789012345678901234567891", 29}};
    for (int i = 0; i < COUNT(row); i++) {
        char a[256], b[256];
        outcome o;
        snprintf(a, sizeof a, "t,u\n0,%s\n", row[i].a);
        snprintf(b, sizeof b, "t,u\n0,%s\n", row[i].b);
        compared(&o, a, b, "0.01");
        ck_assert_msg(o.least[0] == row[i].agreed, "%s and %s agree to %ld decimals, not %ld", row[i].a,
                      row[i].b, o.least[0], row[i].agreed);
        done(&o);
        compared(&o, b, a, "0.01");
        ck_assert_int_eq(o.least[0], row[i].agreed);
        done(&o);
    }
}
END_TEST

/* The rule by another route: p decimals agree when |a - b| 10^p <= 1/2. */
START_TEST(random_decimals)
{
    uint64_t s = test_seed();
    mpq_t q, half;
    mpq_inits(q, half, (mpq_ptr)0);
    mpq_set_ui(half, 1, 2);
    for (int i = 0; i < 3000; i++) {
        const long e = (long)test_random_below(&s, 40) - 20;
        mpz_t d;
        mpz_init_set_ui(d, 1 + (unsigned long)test_random_below(&s, i % 3 ? 1000000 : 12));
        if (i % 7 == 0)
            mpz_ui_pow_ui(d, 10, (unsigned long)test_random_below(&s, 30));
        if (i % 7 == 1) {
            mpz_ui_pow_ui(d, 10, (unsigned long)test_random_below(&s, 30));
            mpz_mul_ui(d, d, 5);
        }
        const long p = cns_exact_decimal_agreed(d, e);
        for (int more = 0; more < 2; more++) {
            const long shift = e + p + more;
            mpz_ui_pow_ui(mpq_numref(q), 10, (unsigned long)(shift > 0 ? shift : 0));
            mpz_ui_pow_ui(mpq_denref(q), 10, (unsigned long)(shift < 0 ? -shift : 0));
            mpz_mul(mpq_numref(q), mpq_numref(q), d);
            mpq_canonicalize(q);
            ck_assert_int_eq(mpq_cmp(q, half) <= 0, !more);
        }
        mpz_clear(d);
    }
    mpq_clears(q, half, (mpq_ptr)0);
}
END_TEST

START_TEST(three_hundred_digits)
{
    char digits[301], a[400], b[400];
    outcome o;
    memset(digits, '7', 300);
    digits[300] = '\0';
    snprintf(a, sizeof a, "t,u\n1,0.%s\n", digits);
    digits[250] = '8';
    snprintf(b, sizeof b, "t,u\n1.0,0.%s\n", digits);
    compared(&o, a, b, "0.01");
    ck_assert_int_eq(o.least[0], 250);
    ck_assert_ptr_nonnull(o.r.first.t);
    ck_assert_str_eq(o.r.first.t, "1");
    done(&o);
}
END_TEST

START_TEST(grids_meet)
{
    outcome o;
    compared(&o, "t,u\n0,1\n0.10,2\n0.3,4\n1e0,5\n2,6\n", "t,u\n-1,0\n0.0,1\n0.1,2\n0.2,3\n1.00,5\n", "0.01");
    ck_assert_int_eq(o.rows, 3);
    ck_assert_str_eq(o.t[0], "0");
    ck_assert_str_eq(o.t[1], "0.10");
    ck_assert_str_eq(o.t[2], "1e0");
    ck_assert_int_eq(o.r.rows_a, 5);
    ck_assert_int_eq(o.r.rows_b, 5);
    ck_assert_int_eq(o.r.common, 3);
    ck_assert_ptr_null(o.r.first.t);
    ck_assert_ptr_null(o.r.norm_tc);
    ck_assert_str_eq(o.r.norm_last, "1e0");
    done(&o);
    compare(&o, "t,u\n0,1\n2,1\n", "t,u\n1,1\n3,1\n", "0.01");
    ck_assert_int_eq((int)o.code, CNS_USAGE);
    ck_assert_ptr_nonnull(strstr(o.err.text, "no time in common"));
    done(&o);
}
END_TEST

/* The same table in many dresses. */
START_TEST(dresses)
{
    static const char *const dress[] = {
        "t,x,y\n0,1.50,2.25\n1,-3.00,4.50\n",
        "t;x;y\r\n0;1.50;2.25\r\n1;-3.00;4.50\r\n",
        "t\tx\ty\n0\t1.50\t2.25\n1\t-3.00\t4.50\n",
        "   t    x      y\n  0   1.50   2.25\n  1  -3.00   4.50\n",
        "# a comment\n\nt, x, y\n# another\n0, 1.50, 2.25\n\n1, -3.00, 4.50\n# complete\n",
        "\xEF\xBB\xBFt,x,y\n0,1.50,2.25\n1,-3.00,4.50\n",
        "\xEF\xBB\xBFx,t,y\n1.50,0,2.25\n-3.00,1,4.50\n",
        "\"t\",\"x\",\"y\"\n\"0\",\"1.50\",2.25\n1,-3.00,4.50\n",
        "y,x,t\n2.25,1.50,0\n4.50,-3.00,1\n",
        "x,Time,y\n1.50,0,2.25\n-3.00,1,4.50\n",
        "when,x,y\n0,1.50,2.25\n1,-3.00,4.50\n",
        "t,x,y,\n0,1.50,2.25,\n1,-3.00,4.50,\n",
        "t,note,x,y\n0,start,1.50,2.25\n1,end of it,-3.00,4.50\n",
        "t,x,y\n0.0D0,0.15D+01,.225d1\n10e-1,-30.0E-1,+4.50\n",
        "t,x,y\n0,1.50,2.25\n1,-3.00,4.50",   /* no newline at the end */
        "t,x,y\r0,1.50,2.25\r1,-3.00,4.50\r", /* of an old Macintosh */
        "t,x,y\r\r\n0,1.50,2.25\r\r\n1,-3.00,4.50\r\r\n",
        /* numpy.savetxt: names in a comment, separated like the rows or not */
        "# t,x,y\n0.00,1.50,2.25\n1.00,-3.00,4.50\n",
        "# made today\n#t x y\n0.000e+00 1.50e+00 2.25\n1.0e+00 -3.0e+00 4.50\n",
        "# t,x,y\n0.000e+00 1.50e+00 2.25\n1.0e+00 -3.0e+00 4.50\n",
        /* a spreadsheet, in English and in German; what it makes of lines of comment */
        "sep=,\nt,x,y\n0,1.50,2.25\n1,-3.00,4.50\n",
        "\xEF\xBB\xBFsep=;\r\nt;x;y\r\n0,0;1,50;2,25\r\n1,0;-3,00;4,50\r\n",
        "t;\"a, m\";x;y\n0,0;9;1,50;2,25\n1,0;9;-3,00;4,50\n",
        "\"sep=\t\"\nt\tx, m\tx\ty\n0\t7\t1.50\t2.25\n1\t7\t-3.00\t4.50\n",
        "\"# a, b\",,\nt,x,y\n0,1.50,2.25\n1,-3.00,4.50\n",
        "sep=|\nt|x|y\n0|1.50|2.25\n1|-3.00|4.50\n",
        /* quotes */
        "t,\"x, in m\",x,y\n0,9,1.50,2.25\n1,9,-3.00,4.50\n",
        "t,\"a \"\"b\"\", c\",x,y\n0,9,1.50,2.25\n1,9,-3.00,4.50\n",
        "t \"x of 1\" x y\n0 9 1.50 2.25\n1 9 -3.00 4.50\n",
        "t,5\" pipe,6\" pipe,x,y\n0,9,9,1.50,2.25\n1,9,9,-3.00,4.50\n",
        /* notes */
        "t,x,y # names\n0,1.50,2.25 # a start, of course\n1,-3.00,4.50\t# \"end\n",
        "t x y\n0 1.50 2.25 # a start\n1 -3.00 4.50 #end\n",
        "t,x#1,x,y\n0,9,1.50,2.25\n1,9,-3.00,4.50\n",
        /* Fortran */
        "  t   x   y\n 0.000-104 0.15D+001 0.225+001\n .1E+1 -.3Q+1 0.450+001\n",
    };
    for (int i = 0; i < COUNT(dress); i++) {
        outcome o;
        compared(&o, dress[0], dress[i], "0.01");
        ck_assert_msg(o.rows == 2 && o.r.n == 2 && !o.r.first.t, "dress %d is another table: %s", i,
                      dress[i]);
        ck_assert_ptr_null(o.r.norm_tc);
        ck_assert_int_ge(o.least[0], 1);
        done(&o);
    }
}
END_TEST

START_TEST(missing_values)
{
    outcome o;
    compared(&o, "t,x,y\n0,1.0,\n1,nan,NA\n2,5.0,1.0\n3,,2.0\n",
             "t,x,y\n0,1.0,2.0\n1,1.0,1.0\n2,,2.0\n3,1,2.0\n", "0.01");
    ck_assert_int_eq(o.rows, 4);
    ck_assert_int_eq(o.each[0][0], 1);
    ck_assert(o.each[0][1] == CNS_COMPARE_MISSING && o.least[0] == CNS_COMPARE_MISSING);
    ck_assert(o.each[1][0] == CNS_COMPARE_MISSING && o.least[1] == CNS_COMPARE_MISSING);
    ck_assert_int_eq(o.each[2][1], -1);
    ck_assert(o.each[2][0] == CNS_COMPARE_MISSING && o.least[2] == CNS_COMPARE_MISSING);
    ck_assert_str_eq(o.r.first.t, "0"); /* a value against none is a difference */
    ck_assert_int_eq(o.r.first.column, 1);
    ck_assert_ptr_null(o.r.first.a);
    ck_assert_str_eq(o.r.first.b, "2.0");
    ck_assert_str_eq(o.r.tc[1], "2");
    ck_assert_str_eq(o.r.norm_tc, "2"); /* y alone suffices */
    ck_assert_ptr_null(o.r.tc[0]);
    ck_assert_str_eq(o.r.last[0], "0");
    done(&o);
}
END_TEST

static void check_gap(const cns_compare_gap *gap, long count, const char *first)
{
    ck_assert_int_eq(gap->count, count);
    if (first)
        ck_assert_str_eq(gap->first, first);
    else
        ck_assert_ptr_null(gap->first);
}

/* Whatever was not compared is counted and has its place. */
START_TEST(gaps)
{
    outcome o;
    compared(&o, "t,x,y,z\n0,1,1,1\n1,nan,null,1\n2,1,-nan,1\n3,inf,NA,1\n5,1,1,1\n6,1,1,1\n",
             "w,t,x,y,v\n1,0,1,1,1\n1,1,1,N/A,1\n1,2,1,1,1\n1,3,-inf,1,1\n1,4,1,1,1\n1,6,,1,1\n", "0.01");
    ck_assert_int_eq(o.r.n_only[CNS_COMPARE_A], 1);
    ck_assert_str_eq(o.r.only[CNS_COMPARE_A][0], "z");
    ck_assert_int_eq(o.r.n_only[CNS_COMPARE_B], 2);
    ck_assert_str_eq(o.r.only[CNS_COMPARE_B][0], "w");
    ck_assert_str_eq(o.r.only[CNS_COMPARE_B][1], "v");
    check_gap(&o.r.rows[CNS_COMPARE_A], 1, "5");
    check_gap(&o.r.rows[CNS_COMPARE_B], 1, "4");
    check_gap(&o.r.values[0][CNS_COMPARE_A], 1, "1");
    check_gap(&o.r.values[0][CNS_COMPARE_B], 1, "6");
    check_gap(&o.r.values[0][CNS_COMPARE_BOTH], 1, "3");
    check_gap(&o.r.values[1][CNS_COMPARE_A], 2, "2");
    check_gap(&o.r.values[1][CNS_COMPARE_B], 0, NULL);
    check_gap(&o.r.values[1][CNS_COMPARE_BOTH], 1, "1");
    ck_assert(!cns_compare_whole(&o.r));
    done(&o);

    static const struct {
        const char *a, *b;
        bool whole;
    } row[] = {{"t,x\n0,1\n", "t,x\n0,2\n", true},
               {"t,x\n0,1\n", "t,x,y\n0,1,1\n", false},
               {"t,x\n0,1\n", "t,x\n0,1\n1,1\n", false},
               {"t,x\n0,1\n1,\n", "t,x\n0,1\n1,1\n", false},
               {"t,x\n0,1\n1,\n", "t,x\n0,1\n1,\n", false},
               {"# cns 1\nt,x,decimals,growth\n0,1,9,1\n", "t,x\n0,1\n", true}};
    for (int i = 0; i < COUNT(row); i++)
        for (int swap = 0; swap < 2; swap++) {
            compared(&o, swap ? row[i].b : row[i].a, swap ? row[i].a : row[i].b, "0.01");
            ck_assert_msg(cns_compare_whole(&o.r) == row[i].whole, "%s", row[i].a);
            done(&o);
        }
}
END_TEST

/* How programs say that there is no number. */
START_TEST(no_numbers)
{
    static const char *const word[] = {
        "",       "nan",     "NaN",     "-nan",     "nan(0x8000)", "-NaN(ind)", "NA",      "N/A",
        "#N/A",   "<NA>",    "null",    "None",     "inf",         "-Inf",      "+inf",    "Infinity",
        "1.#INF", "-1.#IND", "1.#QNAN", "1.#QNAN0", "-1.#IND00",   "1.#SNAN",   "\"nan\"", " nan "};
    for (int i = 0; i < COUNT(word); i++) {
        char text[64];
        outcome o;
        snprintf(text, sizeof text, "t,x\n0,1\n1,%s\n", word[i]);
        compared(&o, text, "t,x\n0,1\n1,-7\n", "0.01");
        ck_assert_msg(o.each[1][0] == CNS_COMPARE_MISSING, "'%s' is a number", word[i]);
        ck_assert_str_eq(o.r.first.t, "1");
        done(&o);
    }
}
END_TEST

/* Values that agree to fewer than three decimals, equal ones apart, are counted. */
START_TEST(few_decimals)
{
    outcome o;
    compared(&o, "t,x,y\n0,1,1.2346\n1,1.0001,2\n2,1.001,\n3,5,1.25\n",
             "t,x,y\n0,1.0,1.23456789\n1,1.0002,2\n2,1.0021,1\n3,5,1.2500001\n", "0.01");
    ck_assert_int_eq(o.r.n_few, 2);
    ck_assert_str_eq(o.r.few.t, "2");
    ck_assert_str_eq(o.r.few.a, "1.001");
    ck_assert_str_eq(o.r.few.b, "1.0021");
    ck_assert_str_eq(o.r.name[o.r.few.column], "x");
    done(&o);
}
END_TEST

#define OURS(format, d)                                                                                      \
    "# cns 1.0: a model\n# format: " format                                                                  \
    "\n# times: each the nearest fraction with a denominator up to " d "\n"

/* Times that our tables round, against such of other decimals, of another grid, and of another program. */
START_TEST(times_had_back)
{
    outcome o;
    compared(&o, OURS("1", "3") "t,x\n0,1\n0.33333333333333333,2\n0.66666666666666667,3\n1,4\n",
             OURS("1", "9") "t,x\n0,1\n0.1111111,8\n0.3333333,2\n0.4444444,8\n0.6666667,3\n1,4\n", "0.01");
    ck_assert_int_eq(o.rows, 4);
    ck_assert_str_eq(o.t[1], "0.33333333333333333");
    ck_assert_ptr_null(o.r.first.t);
    check_gap(&o.r.rows[CNS_COMPARE_B], 2, "0.1111111");
    done(&o);
    compared(&o, OURS("1", "3") "t,x\n0,1\n0.33333333333333333,2\n", "t,x\n0,1\n0.33333333333333333,2\n",
             "0.01"); /* another program means what it says */
    ck_assert_int_eq(o.rows, 1);
    done(&o);
    /* 0.3333333333 is a time of its own among denominators that large */
    compared(&o, OURS("1", "10000000000") "t,x\n0,1\n0.3333333333,2\n0.333333333333333333333,3\n",
             OURS("1", "3") "t,x\n0,1\n0.3333333333,3\n", "0.01");
    ck_assert_int_eq(o.rows, 2);
    ck_assert_ptr_null(o.r.first.t);
    done(&o);
}
END_TEST

START_TEST(predictable_times)
{
    outcome o;
    /* x: 1 % exactly is not beyond; y: 0/0, then x/0; z: the reference is B. */
    compared(&o, "t,x,y,z\n0,1.01,0,1\n1,1.010000001,0.0,0.99\n2,1,1e-30,0\n",
             "t,x,y,z\n0,1.000,0,1\n1,1,0e5,1.0\n2,1,0,1\n", "0.01");
    ck_assert_str_eq(o.r.tc[0], "1");
    ck_assert_str_eq(o.r.tc[1], "2");
    ck_assert_str_eq(o.r.tc[2], "2");
    ck_assert_str_eq(o.r.norm_tc, "1"); /* 0.0100..01 and 0.01 make 0.0141 */
    ck_assert_ptr_null(o.r.model);
    ck_assert_str_eq(o.r.first.t, "0");
    ck_assert_str_eq(o.r.name[o.r.first.column], "x");
    ck_assert_str_eq(o.r.first.a, "1.01");
    ck_assert_str_eq(o.r.first.b, "1.000");
    done(&o);
}
END_TEST

START_TEST(norm_of_a_model)
{
    outcome o;
    /* x is passive in apw: 9 off in x is nothing; decimals and growth of our tables are no quantities. */
    compared(&o, "# cns 1: disk\n# | model: apw\nt,x,Vx,decimals,growth\n0,1,1,5,0.000\n1,9,1.02,4,0.1\n",
             "t,x,Vx,decimals,growth\n0,10,1,5,0.000\n1,9,1,9,0.2\n", "0.01");
    ck_assert_int_eq(o.r.n, 2);
    ck_assert_str_eq(o.r.model, "apw");
    ck_assert(!o.r.in_norm[0] && o.r.in_norm[1]);
    ck_assert_str_eq(o.r.norm_tc, "1");
    done(&o);
    /* tables of two models have no common norm but that of all columns */
    compared(&o, "# model: apw\nt,x,Vx\n0,1,1\n", "# model: lorenz\nt,x,Vx\n0,10,1\n", "0.01");
    ck_assert_ptr_null(o.r.model);
    ck_assert(o.r.in_norm[0] && o.r.in_norm[1]);
    ck_assert_str_eq(o.r.norm_tc, "0");
    done(&o);
}
END_TEST

START_TEST(refused)
{
    static const struct {
        const char *text, *place, *what;
    } row[] = {{"", ":1:1:", "no header line"},
               {"# only a comment\n", ":1:1:", "no header line"},
               {"0,1\n1,2\n", ":1:1:", "no header: put a line with the names of the 2 columns"},
               {"# t,u,v\n0,1\n1,2\n", ":2:1:", "no header"},
               {"# 1,2\n0,1\n1,2\n", ":2:1:", "no header"},
               {"# t,t\n0,1\n1,2\n", ":1:3:", "a second column"},
               {"t,1\n0,1\n1,2\n", ":1:3:", "a number where the header"},
               {"t,u\n0,1\n1,0,5\n", ":3:5:", "3 values"},
               {"t\tu\n0\t1\n1\t0,5\n", ":3:3:", "decimal comma"},
               {"t;u\n0;1,5\n1;2.500\n", ":3:3:", "a decimal point, but"},
               {"t;u\n0;1.5\n1;2,5\n", ":3:3:", "a decimal comma, but"},
               {"t;u\n0;1\n1;2.500,5\n", ":3:3:", "not a number"},
               {"t,u\n0,1\n1 # 2,2\n", ":3:1:", "is a note"},
               {"t,u\n0,1\n1,2020-01\n", ":3:3:", "not a number"},
               {"t,u\n0,1\n1,2.5-0104\n", ":3:3:", "not a number"},
               {"t,u\n0,1\n1,2.5+10\n", ":3:3:", "not a number"},
               {"t,u\n0,1\n1,********\n", ":3:3:", "not a number"},
               {"t,u\n0,1\n1,\"2\n", ":3:3:", "not a number"},
               {"\xFF\xFEt,u", ":1:1:", "UTF-16"},
               {OURS("2", "3") "t,u\n0,1\n", ":2:1:", "format 2, from a newer cns"},
               {OURS("18446744073709551617", "3") "t,u\n0,1\n", ":2:1:", "format 18446744073709551617"},
               {OURS("one", "3") "t,u\n0,1\n", ":2:1:", "format one"},
               {OURS("1", "x") "t,u\n0,1\n", ":3:1:", "not known"},
               {OURS("1", "0") "t,u\n0,1\n", ":3:1:", "not known"},
               {OURS("1", "3") "t,u\n0,1\n0.3333,1\n0.33333,1\n", ":7:1:", "times must increase"},
               {"t,u\n0,1\n1\n", ":3:1:", "1 value, but the header names 2"},
               {"t,u\n0,1\n1,2,3\n", ":3:5:", "3 values"},
               {"t,u\n0,1\n1,  2x\n", ":3:5:", "'2x' in column 'u'"},
               {"t,u\n0,1\n1,1e\n", ":3:3:", "digits must follow"},
               {"t,u\n0,1\n1,1e99999999\n", ":3:3:", "out of range"},
               {"t,u\n0,1\ninf,1\n", ":3:1:", "a time is missing"},
               {"t,u\n0,1\n1,0x10\n", ":3:3:", "not a number"},
               {"t,u\n0,1\n1,-\n", ":3:3:", "not a number"},
               {"t,u\n0,1\n1,1.2.3\n", ":3:3:", "not a number"},
               {"t,u\n0,1\n0.0,2\n", ":3:1:", "times must increase"},
               {"t,u\n0,1\n,2\n", ":3:1:", "a time is missing"},
               {"t,u\n0,1\nx,2\n", ":3:1:", "in column 't'"},
               {"t,u,u\n0,1,2\n", ":1:5:", "a second column 'u'"},
               {"t,w\n0,1\n", NULL, "no column in common"},
               {"t,u\n5,1\n", NULL, "no time in common"},
               {"t,u\n", NULL, "no time in common"},
               {"t,u\n0,1\n1,2\n2,2\n3,2\n4,2\n9,zwei\n", ":7:3:", "not a number"}};
    for (int i = 0; i < COUNT(row); i++)
        for (int swap = 0; swap < 2; swap++) {
            static const char good[] = "t,u\n0,1\n1,2\n2,3\n9,3\n";
            outcome o;
            compare(&o, swap ? good : row[i].text, swap ? row[i].text : good, "0.01");
            ck_assert_msg(o.code == CNS_USAGE, "code %d for: %s", (int)o.code, row[i].text);
            ck_assert_msg(strstr(o.err.text, row[i].what) != NULL, "'%s' without '%s'", o.err.text,
                          row[i].what);
            if (row[i].place)
                ck_assert_msg(strstr(o.err.text, row[i].place) != NULL, "'%s' without '%s'", o.err.text,
                              row[i].place);
            done(&o);
        }
}
END_TEST

START_TEST(zero_bytes_and_no_file)
{
    char path[64];
    cns_error err;
    write_file(path, "t,u\0\n0,1\n", 10);
    ck_assert_ptr_null(cns_table_reader_open(path, &err));
    ck_assert_int_eq((int)err.code, CNS_USAGE);
    unlink(path);
    ck_assert_ptr_null(cns_table_reader_open(path, &err));
    ck_assert_int_eq((int)err.code, CNS_IO);
    ck_assert_ptr_null(cns_table_reader_open("/", &err));
    ck_assert_int_eq((int)err.code, CNS_IO);
}
END_TEST

Suite *suite_compare(void)
{
    Suite *s = suite_create("compare");
    TCase *t = tcase_create("compare");
    tcase_add_test(t, decimals);
    tcase_add_test(t, random_decimals);
    tcase_add_test(t, three_hundred_digits);
    tcase_add_test(t, grids_meet);
    tcase_add_test(t, dresses);
    tcase_add_test(t, missing_values);
    tcase_add_test(t, gaps);
    tcase_add_test(t, no_numbers);
    tcase_add_test(t, few_decimals);
    tcase_add_test(t, times_had_back);
    tcase_add_test(t, predictable_times);
    tcase_add_test(t, norm_of_a_model);
    tcase_add_test(t, refused);
    tcase_add_test(t, zero_bytes_and_no_file);
    suite_add_tcase(s, t);
    return s;
}
