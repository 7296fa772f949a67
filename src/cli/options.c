#include "options.h"

#include <stdlib.h>
#include <string.h>

#include "cns/study/equilibria.h"
#include "cns/study/tc.h"
#include "commands.h"
#include "core/memory.h"
#include "core/text.h"

/* clang-format off */
static const cns_command commands[] = {
    {"run", cns_cmd_run, "CASE", 1, 1, "compute a trajectory and print it as a table",
     "CASE is a case file, or - for standard input; `cns help case` lists its keys.\n"
     "With `goal` the program finds digits, order and steps by itself and proves every decimal\n"
     "it prints with a second, finer run. With `numerics` it computes as told; --prove adds the\n"
     "second run.\n"
     "--events writes a second table, when the first is complete: the moments at which the angle\n"
     "is a multiple of half a turn and its rate is zero (APW: theta = k pi, omega = 0), and those of\n"
     "--section, with the states there; proven like the rows, by runs of its own. A section is\n"
     "STATE=VALUE, STATE=VALUE mod PERIOD, or STATE=extremum. `direction` is the sign of the\n"
     "change (at a maximum -1), 0 where the state only touches. For the events alone: -o /dev/null.\n"},
    {"tc", cns_cmd_tc, "CASE", 1, 1, "critical predictable time of a run by numerics",
     "How long the run that `numerics` describes can be trusted: the first row at which it differs\n"
     "from a finer run by more than delta, refined inside the interval before that row. For an\n"
     "observable u that is |1 - u1/u2| > delta; for `norm`, the distance of the states that feed\n"
     "back, each divided by its typical size, > delta. With `digits: K` every state is rounded to K\n"
     "significant decimals after every step. The finer run is a Taylor run with more digits, chosen\n"
     "so that its own error stays far below delta.\n"},
    {"laws", cns_cmd_laws, "CASE", 1, 1, "T_c against digits, step and smoothing: runs, fits, errors",
     "Runs of K digits, of fixed steps and of smoothed absolute values, as `laws` in the case says, all\n"
     "against one finer reference, and straight lines through their critical predictable times. Errors\n"
     "of slopes allow for the fluctuation of growth, which all runs share. Runs stop by themselves;\n"
     "`time: end` is only where to give up, `time: every` the rows. With -o DIR every run is kept, and\n"
     "the same command does what is missing.\n"},
    {"compare", cns_cmd_compare, "A B", 2, 2, "compare two tables: agreed decimals, first difference, T_c",
     "A and B are tables of `cns run`, or any columns of numbers with a header, separated by commas,\n"
     "semicolons, tabs or blanks. Columns are matched by name and rows by time, exactly; nothing is\n"
     "interpolated. Printed are the decimals to which both agree in every common row, the first\n"
     "difference, and T_c with B as the reference; -v adds a column for each quantity.\n"},
    {"plan", cns_cmd_plan, "CASE", 1, 1, "digits, order, steps, memory and time that a goal will need",
     "The growth of noise is measured along a preliminary run in double precision with tangents,\n"
     "the speed of this machine on some steps. A run with `goal` makes the same plan first. The\n"
     "time is that of a machine with nothing else to do. CASE may have `goal`, `numerics` or\n"
     "neither; what is left out: the case's end and goal, or 10 decimals.\n"},
    {"lyapunov", cns_cmd_lyapunov, "CASE", 1, 1, "the largest Lyapunov exponent, with its standard error",
     "A tangent is carried along a long trajectory and its mean growth is printed as a table of\n"
     "t, lambda and standard error; --yaml: as a summary. The section `lyapunov` of the case says\n"
     "how long (time: 20000) and in which arithmetic: double, or mpfr or fast with digits. A tenth\n"
     "of that time comes before it and is left out. The error falls like 1/sqrt(time).\n"},
    {"classify", cns_cmd_classify, "CASE", 1, 1, "find the mode of a motion: steady, flutter, tumble, chaotic",
     "Follows the case's own trajectory until its late motion shows, twice, in different precisions,\n"
     "and finds the cycle that it tends to. Keys:\n"
     "  mode      steady, flutter (periodic, from side to side), tumble (periodic, going round),\n"
     "            periodic (in a model without an angle), chaotic (the largest exponent is positive,\n"
     "            by six standard errors), undecided (exit status 1; a note says why)\n"
     "  period    after which the motion repeats, up to place and whole revolutions of its angle\n"
     "  winding   whole revolutions in a period\n"
     "  symmetry  mirror: half a period makes the motion its own mirror image; turn: a part of a\n"
     "            period turns it by half a revolution and otherwise repeats it; none\n"
     "  returns   passages through broadside (angle = k pi) until it repeats, up to symmetry: 1 is\n"
     "            the simplest motion of its kind, 2 what is called period two\n"
     "With --sweep it does so for many values of a parameter, on all cores, and prints a table; with\n"
     "-o DIR every finished value is kept in DIR, and none is computed again.\n"},
    {"equilibria", cns_cmd_equilibria, "CASE", 1, 1, "fixed points, eigenvalues, stability",
     "Fixed points of the states that feed back, such as the ways in which a disk can fall steadily,\n"
     "with the eigenvalues of the equations linearised there. All digits are proven in ball\n"
     "arithmetic. Only the case's model, parameters and abs matter.\n"},
    {"bisect", cns_cmd_bisect, "CASE", 1, 1, "the critical value of a parameter between two modes",
     "The section `bisect` of the case names a parameter, a bracket and how many decimals to find.\n"
     "by: trajectory follows the case's own trajectory until its late motion shows, in halves of\n"
     "the bracket, with as many digits as the passage by the saddle takes. by: manifold follows the\n"
     "unstable manifold of a saddle to the next one and asks on which side it passes; the zero of the\n"
     "distance is found by secants of rising precision. Both ends of the last bracket are probed\n"
     "twice, with different digits, orders and steps. With -o DIR every probe is kept there, and\n"
     "the same command goes on where it was stopped.\n"},
    {"check", cns_cmd_check, "CASE", 1, 1, "check a case file and print it with all defaults filled in",
     "All faults are reported, one per line, with line and column. What is printed is a case\n"
     "file again (sections of studies left out), with the overrides of --set applied.\n"
     "With -q nothing is printed: the exit status tells.\n"},
    {"models", cns_cmd_models, "[MODEL]", 0, 1, "list the models: states, parameters, derived quantities",
     NULL},
    {"bench", cns_cmd_bench, "", 0, 0, "measure the speed of the arithmetics on this machine",
     "Processor time per unit of integrated time, on built-in problems at 60, 120, 300 and 1000\n"
     "digits: the plain engine (MPFR) and the fast arithmetic with each kernel that the machine\n"
     "has. x: times as fast as the plain engine; right: digits right at the end, the least of all.\n"
     "What would not fit into the time is left out.\n"},
    {"help", cns_cmd_help, "[COMMAND]", 0, 1, "describe a command, or the keys of case files (`help case`)",
     NULL},
};
/* clang-format on */

enum { N_COMMANDS = sizeof commands / sizeof *commands };

typedef enum option_id {
    O_OUTPUT,
    O_YAML,
    O_SET,
    O_PROVE,
    O_EVENTS,
    O_SECTION,
    O_DELTA,
    O_REFERENCE_DIGITS,
    O_UNTIL,
    O_DECIMALS,
    O_SWEEP,
    O_OBSERVABLE,
    O_DIGITS,
    O_SECONDS,
    O_THREADS,
    O_QUIET,
    O_VERBOSE,
    O_VERSION,
    O_HELP,
    N_OPTION_IDS
} option_id;

typedef struct option_row {
    option_id id;
    const char *name; /* without the -- */
    char letter;      /* 0: none */
    const char *argument;
    const char *commands; /* names with spaces around; NULL: all, and none */
    const char *meaning;
} option_row; /* several rows with one id: an option that means different things to different commands */

/* clang-format off */
static const option_row options[] = {
    {O_OUTPUT,  "output",  'o', "FILE", " run lyapunov bench ", "write the table to FILE, aside, and rename it"},
    {O_OUTPUT,  "output",  'o', "DIR",  " laws classify bisect ", "keep every run in this directory"},
    {O_YAML,    "yaml",     0,  NULL,   " run tc laws compare plan lyapunov classify equilibria bisect bench ", "a summary as YAML; the table only with -o"},
    {O_SET,     "set",      0,  "K=V",  " run tc laws plan lyapunov classify equilibria bisect check ", "override a value: --set numerics.digits=80 (repeatable)"},
    {O_PROVE,   "prove",    0,  NULL,   " run ", "prove a run by hand with a second, finer one"},
    {O_EVENTS,  "events",   0,  "FILE", " run ", "write the table of events to FILE, beside the trajectory"},
    {O_SECTION, "section",  0,  "S=V",  " run ", "an event for --events: state S has the value V (repeatable)"},
    {O_DELTA,   "delta",    0,  "X",    " tc compare ", "the difference that ends predictability (default 0.01)"},
    {O_REFERENCE_DIGITS, "reference-digits", 0, "N", " tc ", "digits of the finer run (default: what it takes)"},
    {O_UNTIL,   "until",    0,  "T",    " plan ", "up to this time instead of the case's end"},
    {O_UNTIL,   "until",    0,  "T",    " classify ", "follow the motion up to this time at most"},
    {O_DECIMALS, "decimals", 0, "D",    " plan ", "so many right decimals instead of the case's goal"},
    {O_SWEEP,   "sweep",    0,  "P=A:B:STEP", " classify ", "one row for every value of parameter P from A to B"},
    {O_OBSERVABLE, "observable", 0, "STATE", " classify ", "the state whose maxima are listed; default: the last dynamic one"},
    {O_DIGITS,  "digits",   0,  "N",    " equilibria ", "digits after the point (default 30)"},
    {O_SECONDS, "seconds",  0,  "S",    " bench ", "how long to measure, about (default 20)"},
    {O_THREADS, "threads",  0,  "N",    " run tc laws plan classify bisect ", "at most N threads; the results do not depend on it"},
    {O_QUIET,   "quiet",   'q', NULL,   " run tc laws compare plan lyapunov classify equilibria bisect check bench ", "no progress and no notes; errors only"},
    {O_VERBOSE, "verbose", 'v', NULL,   " run tc laws compare lyapunov bisect ", "say more about what is done"},
    {O_VERSION, "version",  0,  NULL,   NULL,    "print the version and those of the libraries"},
    {O_HELP,    "help",    'h', NULL,   NULL,    "describe the command"},
};
/* clang-format on */

enum { N_OPTIONS = sizeof options / sizeof *options };

int cns_command_count(void)
{
    return N_COMMANDS;
}

const cns_command *cns_command_at(int i)
{
    return &commands[i];
}

const cns_command *cns_command_find(const char *name)
{
    for (int i = 0; i < N_COMMANDS; i++)
        if (strcmp(commands[i].name, name) == 0)
            return &commands[i];
    return NULL;
}

static const char *command_name(int i, const void *context)
{
    (void)context;
    return commands[i].name;
}

const char *cns_command_nearest(const char *name)
{
    return cns_text_nearest(name, N_COMMANDS, command_name, NULL);
}

static const char *option_name(int i, const void *context)
{
    (void)context;
    return options[i].name;
}

static bool applies(const option_row *row, const cns_command *command)
{
    if (row->commands == NULL)
        return true;
    if (command == NULL)
        return false;
    size_t n = strlen(command->name);
    for (const char *at = row->commands; (at = strstr(at, command->name)) != NULL; at += n)
        if (at[-1] == ' ' && at[n] == ' ')
            return true;
    return false;
}

void cns_options_print(const cns_command *command, FILE *out)
{
    for (int i = 0; i < N_OPTIONS; i++) {
        const option_row *row = &options[i];
        if (!applies(row, command))
            continue;
        char shown[64];
        snprintf(shown, sizeof shown, "--%s%s%s", row->name, row->argument != NULL ? " " : "",
                 row->argument != NULL ? row->argument : "");
        if (row->letter != 0)
            fprintf(out, "  -%c, %-20s %s\n", row->letter, shown, row->meaning);
        else
            fprintf(out, "      %-20s %s\n", shown, row->meaning);
    }
}

/* Parsing. */

typedef struct parser {
    cns_options *o;
    cns_error *err;
    int argc, at; /* at: the argument to read next */
    char *const *argv;
    const char **sets, **operands, **sections;
    bool seen[N_OPTION_IDS];
} parser;

static cns_code parse_integer(parser *p, const option_row *row, const char *text, long least, long most,
                              long *value)
{
    char *end;
    long n = text[0] >= '0' && text[0] <= '9' ? strtol(text, &end, 10) : least - 1;
    if (n < least || n > most || *end != '\0')
        return cns_fail(p->err, CNS_USAGE, "--%s takes an integer from %ld to %ld, not '%s'", row->name,
                        least, most, cns_quote(text).text);
    *value = n;
    return CNS_OK;
}

static cns_code parse_seconds(parser *p, const char *text)
{
    char *end;
    double seconds = text[0] >= '0' && text[0] <= '9' ? strtod(text, &end) : 0;
    if (!(seconds > 0 && seconds <= CNS_MAX_SECONDS) || *end != '\0')
        return cns_fail(p->err, CNS_USAGE, "--seconds takes a number above 0 and up to %d, not '%s'",
                        CNS_MAX_SECONDS, cns_quote(text).text);
    p->o->seconds = seconds;
    return CNS_OK;
}

static cns_code take(parser *p, const option_row *row, const char *value)
{
    cns_options *o = p->o;
    if (p->seen[row->id] && row->argument != NULL && row->id != O_SET && row->id != O_SECTION)
        return cns_fail(p->err, CNS_USAGE, "--%s is given twice", row->name);
    p->seen[row->id] = true;
    switch (row->id) {
    case O_OUTPUT:
        if (value[0] == '\0')
            return cns_fail(p->err, CNS_USAGE, "--output needs a name");
        o->output = value;
        break;
    case O_YAML:
        o->yaml = true;
        break;
    case O_SET:
        p->sets[o->n_sets++] = value;
        break;
    case O_PROVE:
        o->prove = true;
        break;
    case O_EVENTS:
        if (value[0] == '\0')
            return cns_fail(p->err, CNS_USAGE, "--events needs the name of a file");
        o->events = value;
        break;
    case O_SECTION:
        p->sections[o->n_sections++] = value;
        break;
    case O_DELTA:
        o->delta = value;
        break;
    case O_REFERENCE_DIGITS:
        return parse_integer(p, row, value, 10, CNS_TC_MAX_DIGITS, &o->reference_digits);
    case O_UNTIL:
        o->until = value;
        break;
    case O_DECIMALS:
        return parse_integer(p, row, value, 1, CNS_MAX_DECIMALS, &o->decimals);
    case O_SWEEP:
        o->sweep = value;
        break;
    case O_OBSERVABLE:
        o->observable = value;
        break;
    case O_DIGITS:
        return parse_integer(p, row, value, 1, CNS_EQUILIBRIA_MAX_DECIMALS, &o->digits);
    case O_SECONDS:
        return parse_seconds(p, value);
    case O_THREADS:
        return parse_integer(p, row, value, 1, CNS_MAX_THREADS, &o->threads);
    case O_QUIET:
        o->quiet = true;
        break;
    case O_VERBOSE:
        o->verbose++;
        break;
    case O_VERSION:
        o->version = true;
        break;
    case O_HELP:
        o->help = true;
        break;
    case N_OPTION_IDS:
        break;
    }
    return CNS_OK;
}

/* The value of an option: what is attached to it, or the next argument. */
static const char *value_of(parser *p, const char *attached)
{
    if (attached != NULL)
        return attached;
    return p->at < p->argc ? p->argv[p->at++] : NULL;
}

static cns_code needs_value(parser *p, const option_row *row)
{
    return cns_fail(p->err, CNS_USAGE, "--%s needs a value: --%s %s", row->name, row->name, row->argument);
}

static cns_code parse_long(parser *p, const char *text)
{
    const char *equals = strchr(text, '=');
    size_t n = equals != NULL ? (size_t)(equals - text) : strlen(text);
    for (int i = 0; i < N_OPTIONS; i++) {
        const option_row *row = &options[i];
        if (strlen(row->name) != n || strncmp(row->name, text, n) != 0)
            continue;
        if (row->argument == NULL && equals != NULL)
            return cns_fail(p->err, CNS_USAGE, "--%s takes no value", row->name);
        if (row->argument == NULL)
            return take(p, row, NULL);
        const char *value = value_of(p, equals != NULL ? equals + 1 : NULL);
        return value != NULL ? take(p, row, value) : needs_value(p, row);
    }
    char *name = cns_xcopy_n(text, n);
    const char *nearest = cns_text_nearest(name, N_OPTIONS, option_name, NULL);
    cns_code code = nearest != NULL
                        ? cns_fail(p->err, CNS_USAGE, "unknown option --%s; did you mean --%s?",
                                   cns_quote(name).text, nearest)
                        : cns_fail(p->err, CNS_USAGE, "unknown option --%s; `cns help` lists the options",
                                   cns_quote(name).text);
    free(name);
    return code;
}

/* -q, -qv, -o FILE, -oFILE */
static cns_code parse_letters(parser *p, const char *letters)
{
    for (; *letters != '\0'; letters++) {
        const option_row *row = NULL;
        for (int i = 0; i < N_OPTIONS; i++)
            if (options[i].letter == *letters)
                row = &options[i];
        if (row == NULL) {
            char *name = cns_xcopy(letters);
            cns_code code = cns_fail(p->err, CNS_USAGE, "unknown option -%s; `cns help` lists the options",
                                     cns_quote(name).text);
            free(name);
            return code;
        }
        if (row->argument != NULL) {
            const char *value = value_of(p, letters[1] != '\0' ? letters + 1 : NULL);
            return value != NULL ? take(p, row, value) : needs_value(p, row);
        }
        cns_code code = take(p, row, NULL);
        if (code != CNS_OK)
            return code;
    }
    return CNS_OK;
}

static cns_code parse_word(parser *p, const char *word)
{
    cns_options *o = p->o;
    if (o->command != NULL) {
        p->operands[o->n_operands++] = word;
        return CNS_OK;
    }
    o->command = cns_command_find(word);
    if (o->command != NULL)
        return CNS_OK;
    size_t n = strlen(word);
    const char *nearest = cns_command_nearest(word);
    if (nearest != NULL)
        return cns_fail(p->err, CNS_USAGE, "unknown command '%s'; did you mean '%s'?", cns_quote(word).text,
                        nearest);
    if ((n > 5 && strcmp(word + n - 5, ".yaml") == 0) || (n > 4 && strcmp(word + n - 4, ".yml") == 0))
        return cns_fail(p->err, CNS_USAGE, "a command is missing before '%s', such as `cns run`",
                        cns_quote(word).text);
    return cns_fail(p->err, CNS_USAGE, "unknown command '%s'; `cns help` lists the commands",
                    cns_quote(word).text);
}

static cns_code check_use(parser *p)
{
    const cns_options *o = p->o;
    const cns_command *c = o->command;
    if (c == NULL)
        return cns_fail(p->err, CNS_USAGE, "a command is missing; `cns help` lists the commands");
    bool fits[N_OPTION_IDS] = {false};
    for (int i = 0; i < N_OPTIONS; i++)
        fits[options[i].id] |= applies(&options[i], c);
    for (int i = 0; i < N_OPTIONS; i++)
        if (p->seen[options[i].id] && !fits[options[i].id])
            return cns_fail(p->err, CNS_USAGE, "--%s does not go with `cns %s`", options[i].name, c->name);
    if (o->n_operands < c->least)
        return cns_fail(p->err, CNS_USAGE, "%s is missing: cns %s %s", c->operands, c->name, c->operands);
    if (o->n_operands > c->most)
        return cns_fail(p->err, CNS_USAGE, "one argument too many, '%s': cns %s %s",
                        cns_quote(o->operands[c->most]).text, c->name, c->operands);
    if (o->quiet && o->verbose > 0)
        return cns_fail(p->err, CNS_USAGE, "--quiet and --verbose contradict each other");
    return CNS_OK;
}

cns_code cns_options_parse(cns_options *o, int argc, char *const *argv, cns_error *err)
{
    *o = (cns_options){0};
    size_t room = argc > 0 ? (size_t)argc : 1;
    o->list = cns_xalloc(3 * room, sizeof *o->list);
    parser p = {.o = o, .err = err, .argc = argc, .at = 1, .argv = argv};
    p.sets = o->list;
    p.operands = o->list + room;
    p.sections = o->list + 2 * room;
    o->sections = p.sections;
    o->sets = p.sets;
    o->operands = p.operands;
    bool only_words = false;
    while (p.at < argc) {
        const char *word = argv[p.at++];
        cns_code code;
        if (!only_words && strcmp(word, "--") == 0) {
            only_words = true;
            continue;
        }
        if (!only_words && word[0] == '-' && word[1] == '-')
            code = parse_long(&p, word + 2);
        else if (!only_words && word[0] == '-' && word[1] != '\0')
            code = parse_letters(&p, word + 1);
        else
            code = parse_word(&p, word);
        if (code != CNS_OK)
            return code;
    }
    if (o->help || o->version)
        return CNS_OK;
    return check_use(&p);
}

void cns_options_clear(cns_options *o)
{
    free(o->list);
    *o = (cns_options){0};
}
