# cns: Clean Numerical Simulation of chaotic ODEs.   make help   lists the targets.
#
# Variables: CC, CFLAGS, CPPFLAGS, LDFLAGS, LDLIBS as usual; VARIANT=release|debug|san|coverage;
# WERROR=1; prefix, DESTDIR; CASE, the case file of `make run`; T, the suites or CLI tests of `make check`.
# A new source, test or tool needs no change here: everything is found by its place and name.

VARIANT ?= release
B       := build$(if $(filter-out release,$(VARIANT)),/$(VARIANT))
VERSION := $(shell sed -n 's/^.define CNS_VERSION "\([0-9.]*\)"$$/\1/p' include/cns/status.h)
# File names are made of it, and what is removed.
$(if $(VERSION),,$(error no version in include/cns/status.h))

CFLAGS_release  := -O3 -g
CFLAGS_debug    := -O0 -g
CFLAGS_san      := -O1 -g
CFLAGS_coverage := -O0 -g
CFLAGS          ?= $(CFLAGS_$(VARIANT))

# What a variant is made of, whatever CFLAGS says.
VARIANT_debug    := -DCNS_DEBUG
VARIANT_san      := -DCNS_DEBUG -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
VARIANT_coverage := --coverage -DCNS_DEBUG
ifeq ($(CFLAGS_$(VARIANT)),)
$(error VARIANT is release, debug, san or coverage, not '$(VARIANT)')
endif

WARNINGS    := -Wall -Wextra -Wshadow -Wconversion $(if $(filter 1,$(WERROR)),-Werror)
# No contraction: a fused multiply-add gives other bits than a multiplication and an addition.
# Both libraries are made of the same objects: position-independent ones cost the program nothing that can be
# measured, since only what the public headers declare is visible (CNS_BEGIN_DECLS in include/cns/status.h).
ALL_CFLAGS   = -std=c11 $(CFLAGS) $(VARIANT_$(VARIANT)) $(WARNINGS) -ffp-contract=off -fPIC -fvisibility=hidden \
               -pthread
ALL_CPPFLAGS = -D_POSIX_C_SOURCE=200809L -Iinclude -Isrc $(CPPFLAGS)
ALL_LDLIBS   = $(FLINT) -lmpfr -lgmp -lyaml $(LDLIBS) -lm
COMPILE      = $(CC) $(ALL_CPPFLAGS) $(ALL_CFLAGS)
LINK         = $(CC) $(ALL_CFLAGS) $(LDFLAGS)
# Does the compiler link these options? $(1): options; the answer is the options, or nothing.
links = $(shell echo 'int main(void) { return 0; }' | $(CC) $(LDFLAGS) -x c - $(1) -o /dev/null 2>/dev/null && echo $(1))
# Arb has a library of its own before FLINT 3. Recursive: asked for when tools/install_deps has run.
FLINT   = $(or $(call links,-lflint-arb -lflint),$(call links,-larb -lflint),-lflint)
# Recursive: asked for only when the tests are linked, after tools/install_deps has run.
CHECK_LIBS   = $(shell pkg-config --libs check 2>/dev/null || echo -lcheck -lsubunit -lrt)

LIB_SOURCES   := $(sort $(shell find src -name '*.c' ! -path 'src/cli/*'))
CLI_SOURCES   := $(sort $(shell find src/cli -name '*.c'))
SUITE_SOURCES := $(sort $(wildcard tests/test_*.c))
TEST_SOURCES  := $(sort $(wildcard tests/*.c))
TOOL_SOURCES  := $(sort $(wildcard tools/*.c))
HEADERS       := $(sort $(shell find include -name '*.h'))
FORMATTED     := $(LIB_SOURCES) $(CLI_SOURCES) $(TEST_SOURCES) $(TOOL_SOURCES) $(HEADERS) \
                 $(sort $(shell find src -name '*.h') $(wildcard tests/*.h tools/*.h tools/examples/*.c))

quoted  = '$(subst ','\'',$(1))'
objects = $(patsubst %.c,$(B)/obj/%.o,$(1))
LIB     := $(B)/libcns.a
# libcns.so, for the compiler, is a link to libcns.so.0, for programs, and that to the file libcns.so.0.1.0. The
# first number of the version changes when a program made with an earlier one would no longer run.
SONAME  := libcns.so.$(firstword $(subst ., ,$(VERSION)))
SHARED  := $(B)/libcns.so.$(VERSION)
PROGRAM := $(B)/cns
TESTS   := $(B)/cns-tests
TOOLS   := $(patsubst tools/%.c,$(B)/%,$(TOOL_SOURCES))
BENCHES := $(B)/bench_engine $(B)/bench_rk4 $(B)/bench_table

prefix     ?= /usr/local
LDCONFIG   ?= ldconfig
bindir     ?= $(prefix)/bin
libdir     ?= $(prefix)/lib
includedir ?= $(prefix)/include
# As cns.pc says it, so that an installed tree can be moved.
under_prefix = $(patsubst $(prefix)/%,$${prefix}/%,$(1))
CASE       ?= cases/case4.yaml

# As many jobs as there are processors where the user named no number.
JOBS      = $(shell getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
MAKE_JOBS = --no-print-directory $(if $(findstring -j,$(MAKEFLAGS)),,-j$(JOBS))

# Suites that say most about memory; the others take hours under valgrind.
VALGRIND_SUITES ?= number decimal_text case roots program jet tangent ensemble
VALGRIND = CNS_KERNEL=portable CK_DEFAULT_TIMEOUT=36000 valgrind -q --error-exitcode=99 --leak-check=full \
           --errors-for-leak-kinds=definite

.PHONY: all run check check-san check-valgrind same-bits tune bench-large exponents debug san coverage bench tools install uninstall \
        format format-check clean help install-deps FORCE
.DELETE_ON_ERROR:
.SUFFIXES:

all: $(PROGRAM) $(LIB) $(SHARED)

help:
	@printf '%s\n' \
	'make              the program $(PROGRAM) and the libraries $(LIB) and $(SHARED)' \
	'make run          install what is missing, build, run $(CASE) (CASE=FILE: another)' \
	'make check        install what is missing, build, run all tests (T="number cli": some)' \
	'make check-san    the tests under AddressSanitizer and UBSan' \
	'make check-valgrind   the tests and short runs under valgrind, portable kernel (T="number": some suites)' \
	'make same-bits    random cases: the same table with any kernel, threads, compiler' \
	'make coverage     the tests with gcov; the report is build/coverage/report/index.html' \
	'make debug | san  these variants, in build/debug and build/san' \
	'make bench        the full table of speed, and the engine against loops by hand' \
	'make tune | bench-large | exponents   constants of the rules; many digits; how cost grows' \
	'make tools        build the programs of tools/' \
	'make install      to $(prefix) (prefix=, DESTDIR=); make uninstall' \
	'make format       clang-format all sources; make format-check: only look' \
	'make clean        remove build/' \
	'Variables: CC=clang, CFLAGS=..., WERROR=1, VARIANT=debug|san|coverage'

install-deps:
	@tools/install_deps

run:
	@tools/install_deps
	@$(MAKE) $(MAKE_JOBS) all
	$(PROGRAM) run $(CASE)

check:
	@tools/install_deps --tests
	@$(MAKE) $(MAKE_JOBS) all $(TESTS)
	@tests/run $(B) $(T)

debug san:
	@$(MAKE) $(MAKE_JOBS) VARIANT=$@ all

check-san:
	@$(MAKE) $(MAKE_JOBS) VARIANT=san check

# Valgrind knows no AVX-512: the portable kernel. A branch on memory not set, a leak, a bad address: exit 99.
check-valgrind:
	@tools/install_deps --tests
	@$(MAKE) $(MAKE_JOBS) all $(TESTS)
	$(VALGRIND) $(TESTS) $(or $(T),$(VALGRIND_SUITES))
	$(VALGRIND) $(PROGRAM) run -q cases/case4.yaml --set time.end=3 -o /dev/null
	$(VALGRIND) $(PROGRAM) run -q cases/case4-smooth.yaml --set time.end=1 --set goal.decimals=5 -o /dev/null
	$(VALGRIND) $(PROGRAM) run -q cases/rest.yaml --set time.end=1 -o /dev/null
	$(VALGRIND) $(PROGRAM) check -q cases/lorenz.yaml

same-bits:
	@tools/same_bits

coverage:
	@find build/coverage -name '*.gcda' -delete 2>/dev/null || true
	@$(MAKE) $(MAKE_JOBS) VARIANT=coverage check
	@if command -v gcovr >/dev/null; then \
	    mkdir -p build/coverage/report && \
	    gcovr --root . --filter 'src/' --gcov-executable '$(GCOV)' build/coverage/obj \
	        --html-details build/coverage/report/index.html --txt; \
	else echo 'gcovr is not installed: no report'; fi
GCOV ?= $(if $(findstring clang,$(CC)),llvm-cov gcov,gcov)

tools: $(TOOLS)

# The comparison with heyoka is made where its Python package is there.
bench: $(BENCHES)
	$(B)/bench_engine
	$(B)/bench_rk4
	@if python3 -c 'import heyoka' 2>/dev/null; then $(B)/bench_table -y tools/bench_heyoka.py; \
	else $(B)/bench_table; echo 'heyoka is not installed: the comparison with it is left out'; fi

tune: $(B)/tune
	$(B)/tune
bench-large: $(B)/bench_large
	$(B)/bench_large
exponents: all
	tools/exponents $(PROGRAM)

# Compiling. An object depends on its source, its headers, and the compiler and flags in use.

$(B)/obj/%.o: %.c $(B)/flags | $(B)/libraries
	@mkdir -p $(@D)
	$(COMPILE) $(CPPFLAGS_$(firstword $(subst /, ,$<))) -MMD -MP -c $< -o $@

CPPFLAGS_tests = -I$(B)

$(LIB): $(call objects,$(LIB_SOURCES)) $(B)/sources
	@rm -f $@
	$(AR) rcs $@ $(filter %.o,$^)

$(SHARED): $(call objects,$(LIB_SOURCES)) $(B)/sources
	$(LINK) -shared -Wl,-soname,$(SONAME) $(filter %.o,$^) $(ALL_LDLIBS) -o $@

$(PROGRAM): $(call objects,$(CLI_SOURCES)) $(LIB)
	$(LINK) $(filter %.o %.a,$^) $(ALL_LDLIBS) -o $@

$(TESTS): $(call objects,$(TEST_SOURCES)) $(LIB)
	$(LINK) $(filter %.o %.a,$^) $(CHECK_LIBS) $(ALL_LDLIBS) -o $@

$(TOOLS): $(B)/%: $(B)/obj/tools/%.o $(LIB)
	$(LINK) $(filter %.o %.a,$^) $(ALL_LDLIBS) -o $@

$(B)/obj/tests/main.o: $(B)/suites.def

# Are the libraries there? Asked once for a compiler and its flags; where they are not, it is said what to type.
$(B)/libraries: $(B)/flags
	@CC='$(CC)' CPPFLAGS='$(CPPFLAGS) $(CFLAGS)' LDFLAGS='$(LDFLAGS) $(LDLIBS)' tools/install_deps --look
	@touch $@

# Small files made from variables; each is written only when its text changes, so that installing as another user
# builds nothing anew and writes nothing here.

$(B)/flags:      TEXT = $(COMPILE) $(LDFLAGS) $(ALL_LDLIBS) | $(shell $(CC) --version 2>/dev/null | head -n 1)
$(B)/sources:    TEXT = $(LIB_SOURCES) | $(CLI_SOURCES) | $(TEST_SOURCES)
$(B)/suites.def: TEXT = $(patsubst tests/test_%.c,SUITE(%),$(SUITE_SOURCES))
$(B)/flags $(B)/sources $(B)/suites.def: FORCE
	@mkdir -p $(@D)
	@printf '%s\n' $(call quoted,$(TEXT)) | cmp -s - $@ || printf '%s\n' $(call quoted,$(TEXT)) > $@

-include $(patsubst %.o,%.d,$(call objects,$(LIB_SOURCES) $(CLI_SOURCES) $(TEST_SOURCES) $(TOOL_SOURCES)))

# Installing. The folder include/cns is ours alone; the other folders are shared, and stay.

install: all
	install -d $(DESTDIR)$(bindir) $(DESTDIR)$(libdir)/pkgconfig
	install -m 755 $(PROGRAM) $(DESTDIR)$(bindir)/cns
	install -m 644 $(LIB) $(DESTDIR)$(libdir)/libcns.a
	install -m 644 $(SHARED) $(DESTDIR)$(libdir)
	ln -sf $(notdir $(SHARED)) $(DESTDIR)$(libdir)/$(SONAME)
	ln -sf $(SONAME) $(DESTDIR)$(libdir)/libcns.so
	rm -rf $(DESTDIR)$(includedir)/cns
	for d in $(patsubst include/%,%,$(sort $(dir $(HEADERS)))); do install -d $(DESTDIR)$(includedir)/$$d && \
	    install -m 644 include/$$d*.h $(DESTDIR)$(includedir)/$$d || exit 1; done
	printf '%s\n' 'prefix=$(prefix)' 'libdir=$(call under_prefix,$(libdir))' \
	    'includedir=$(call under_prefix,$(includedir))' '' \
	    'Name: cns' 'Description: Clean Numerical Simulation of chaotic ODEs' 'Version: $(VERSION)' \
	    'Requires: mpfr gmp' 'Requires.private: yaml-0.1' 'Cflags: -I$${includedir}' 'Libs: -L$${libdir} -lcns' \
	    'Libs.private: $(FLINT) -pthread -lm' > $(DESTDIR)$(libdir)/pkgconfig/cns.pc
	@[ -n "$(DESTDIR)" ] || PATH=$$PATH:/sbin:/usr/sbin $(LDCONFIG) 2>/dev/null || true

uninstall:
	rm -f $(addprefix $(DESTDIR),$(bindir)/cns $(libdir)/libcns.a $(libdir)/libcns.so* $(libdir)/pkgconfig/cns.pc)
	rm -rf $(DESTDIR)$(includedir)/cns

CLANG_FORMAT ?= clang-format
format:
	$(CLANG_FORMAT) -i $(FORMATTED)
format-check:
	@bad=; for f in $(FORMATTED); do $(CLANG_FORMAT) $$f | cmp -s - $$f || bad="$$bad $$f"; done; \
	[ -z "$$bad" ] || { echo "not formatted:$$bad"; exit 1; }

clean:
	rm -rf build
