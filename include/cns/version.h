/* The version: the Makefile, cns.pc and the program all read it here. */
#ifndef CNS_VERSION_H
#define CNS_VERSION_H

#define CNS_VERSION "0.1.0"

#endif
