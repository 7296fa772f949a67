/* How wide a terminal is, and how wide text for people is made there. */
#ifndef CNS_CLI_TERMINAL_H
#define CNS_CLI_TERMINAL_H

#define CNS_TEXT_WIDTH 80 /* of help without a terminal; on a wider one lines are not longer, either */

/* The columns of the terminal that `fd` is; 0: it is none. */
int cns_terminal_columns(int fd);

/* The width for text: that of the terminal, at most CNS_TEXT_WIDTH; 0: `fd` is none. */
int cns_terminal_width(int fd);

#endif
