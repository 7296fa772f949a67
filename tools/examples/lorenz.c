/* The Lorenz system from (1, 1, 1) to t = 20, every 5 units of time, with 20 decimals that are all proven.
 *
 *     cc lorenz.c $(pkg-config --cflags --libs cns) -o lorenz && ./lorenz
 */
#include <stdio.h>

#include <cns/cns.h>

int main(void)
{
    cns_error err;
    const cns_setting start[] = {{"x", "1"}, {"y", "1"}, {"z", "1"}, {NULL, NULL}};
    cns_system *lorenz = cns_system_parse(cns_model_find("lorenz"), start, &err);
    const bool good = lorenz != NULL && cns_solve_print(lorenz, "20", "5", 20, stdout, &err) == CNS_OK;
    if (!good)
        fprintf(stderr, "%s\n", err.text);
    cns_system_free(lorenz);
    return good ? 0 : 1;
}
