# libsph: GNU make 4.0 or newer. `make help` lists the targets.
#
# Options (make NAME=value, or keep them with `make configure NAME=value ...`):
#   GSL=1 PETSC=0 OPENMP=1 DEBUG=0 WERROR=0 SAN= CC= CXX= OPT= BUILD= PREFIX= DESTDIR= V=0

MAKEFLAGS += --no-builtin-rules
.SUFFIXES:
.DELETE_ON_ERROR:
.DEFAULT_GOAL := all

# ------------------------------------------------------------------------------------- options
CONFIG_VARIABLES := CC CXX AR NM OPT OP_OPT CFLAGS CPPFLAGS LDFLAGS GSL PETSC OPENMP DEBUG SAN WERROR \
  BUILD PREFIX prefix includedir libdir datadir PKG_CONFIG CLANG_FORMAT CLANG_TIDY DOXYGEN
-include config.mk
# What the command line or config.mk set: this is what `make configure` keeps.
CONFIGURED := $(foreach v,$(CONFIG_VARIABLES),$(if $(filter file command,$(origin $v)),$v))

ifeq ($(origin CC),default)
  CC := gcc
endif
ifeq ($(origin CXX),default)
  CXX := g++
endif
ifeq ($(origin AR),default)
  AR := ar
endif
NM ?= nm
PKG_CONFIG ?= pkg-config
CLANG_FORMAT ?= $(firstword $(shell command -v clang-format-14 clang-format 2>/dev/null) clang-format)
CLANG_TIDY ?= clang-tidy
DOXYGEN ?= doxygen

GSL ?= 1
PETSC ?= 0
OPENMP ?= 1
DEBUG ?= 0
SAN ?=
WERROR ?= 0
V ?= 0
CFLAGS ?=
CPPFLAGS ?=
LDFLAGS ?=
BUILD ?= $(if $(SAN),build-san,build)
ifneq ($(filter $(abspath $(BUILD))/%,$(CURDIR)/ $(patsubst %,$(CURDIR)/%/,include libsph examples tests docs)),)
  $(error BUILD=$(BUILD) would mix objects with sources; take another folder)
endif

PREFIX ?= /usr/local
prefix ?= $(PREFIX)
includedir ?= $(prefix)/include
libdir ?= $(prefix)/lib
datadir ?= $(prefix)/share
DESTDIR ?=

# ------------------------------------------------------------------------------------- version
# Written in include/sph/version.h and nowhere else.
version_part = $(shell sed -n 's/^.define SPH_VERSION_$1 \([0-9][0-9]*\).*/\1/p' include/sph/version.h)
VERSION_MAJOR := $(call version_part,MAJOR)
VERSION_MINOR := $(call version_part,MINOR)
VERSION_PATCH := $(call version_part,PATCH)
VERSION := $(VERSION_MAJOR).$(VERSION_MINOR).$(VERSION_PATCH)
# Before 1.0 a minor version may break the interface.
SOVERSION := $(if $(filter 0,$(VERSION_MAJOR)),0.$(VERSION_MINOR),$(VERSION_MAJOR))

# --------------------------------------------------------------------------------------- flags
comma := ,
empty :=
space := $(empty) $(empty)
DEBUGGING := $(strip $(SAN)$(filter 1,$(DEBUG)))

OPT ?= $(if $(DEBUGGING),-O1 -g -fno-omit-frame-pointer,-O2)
OP_OPT ?= $(if $(DEBUGGING),-O1 -g -fno-omit-frame-pointer,-O3)
WARNINGS := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wstrict-prototypes -Wmissing-prototypes \
  -Wvla $(if $(filter 1,$(OPENMP)),,-Wno-unknown-pragmas) $(if $(filter 1,$(WERROR)),-Werror)
SAN_FLAGS := $(if $(SAN),-fsanitize=$(SAN) -fno-sanitize-recover=all)
OPENMP_FLAGS := $(if $(filter 1,$(OPENMP)),-fopenmp)

TARGET := $(shell $(CC) -dumpmachine 2>/dev/null)
X86_64 := $(filter x86_64% amd64%,$(TARGET))

ifeq ($(GSL),1)
  GSL_FOUND := $(shell $(PKG_CONFIG) --modversion gsl 2>/dev/null)
  GSL_CPPFLAGS := -DSPHI_GSL=1 $(if $(GSL_FOUND),$(shell $(PKG_CONFIG) --cflags gsl))
  GSL_LIBS := $(if $(GSL_FOUND),$(shell $(PKG_CONFIG) --libs gsl))
endif

# Its headers are seen by one file alone, and not warned about.
ifeq ($(PETSC),1)
  PETSC_FOUND := $(firstword $(foreach p,PETSc petsc,$(if $(shell $(PKG_CONFIG) --modversion $p 2>/dev/null),$p)))
  PETSC_MPI := $(firstword $(foreach p,mpi-c ompi mpich mpi,$(if $(shell $(PKG_CONFIG) --modversion $p 2>/dev/null),$p)))
  PETSC_CPPFLAGS := -DSPHI_PETSC=1 $(if $(PETSC_FOUND),$(patsubst -I%,-isystem %,$(filter -I% -D%,$(filter-out \
    -D_FORTIFY_SOURCE%,$(shell $(PKG_CONFIG) --cflags $(PETSC_FOUND) $(PETSC_MPI))))))
  PETSC_LIBS := $(if $(PETSC_FOUND),$(shell $(PKG_CONFIG) --libs $(PETSC_FOUND) $(PETSC_MPI)))
endif

COMMON_FLAGS = -std=c11 $(WARNINGS) $(OPENMP_FLAGS) $(SAN_FLAGS)
LIB_CPPFLAGS = -Iinclude -Ilibsph $(GSL_CPPFLAGS) $(if $(X86_64),,-DSPHI_NO_X86_VARIANTS)
LIB_CFLAGS = $(COMMON_FLAGS) -fPIC -fvisibility=hidden -MMD -MP
LIBS = $(GSL_LIBS) $(PETSC_LIBS) -lm

# ------------------------------------------------------------------------------------ variants
# Files libsph/*/op_*.c hold pair loops. Each is compiled once per variant; sweep/vreal.h turns the
# three macros into types and names. The scalar variant has no relaxed flags: it is the oracle.
VARIANTS := scalar base_f32 base_f64 $(if $(X86_64),avx2_f32 avx2_f64 avx512_f32 avx512_f64)
RELAXED := -fno-math-errno -fno-trapping-math -ffp-contract=fast
AVX2 := -mavx2 -mfma
AVX512 := -mavx512f -mavx512dq -mavx512vl -mavx512bw -mfma -mprefer-vector-width=512
#                      lanes double flags
VARIANT_scalar     := 1  1 $(if $(DEBUGGING),$(OP_OPT),-O2) -ffp-contract=off
VARIANT_base_f32   := 4  0 $(OP_OPT) $(RELAXED)
VARIANT_base_f64   := 2  1 $(OP_OPT) $(RELAXED)
VARIANT_avx2_f32   := 8  0 $(OP_OPT) $(RELAXED) $(AVX2)
VARIANT_avx2_f64   := 4  1 $(OP_OPT) $(RELAXED) $(AVX2)
VARIANT_avx512_f32 := 16 0 $(OP_OPT) $(RELAXED) $(AVX512)
VARIANT_avx512_f64 := 8  1 $(OP_OPT) $(RELAXED) $(AVX512)
variant_flags = -DSPHI_VARIANT=$1 -DSPHI_LANES=$(word 1,$(VARIANT_$1)) \
  -DSPHI_DOUBLE=$(word 2,$(VARIANT_$1)) -Wno-psabi \
  $(wordlist 3,$(words $(VARIANT_$1)),$(VARIANT_$1))

# --------------------------------------------------------------------------------------- files
HEADERS := $(sort $(wildcard include/sph.h include/sph/*.h))
# Files *.inc.c are included by others.
SOURCES := $(filter-out %.inc.c,$(sort $(wildcard libsph/*/*.c)))
OP_SOURCES := $(foreach s,$(SOURCES),$(if $(filter op_%,$(notdir $s)),$s))
PLAIN_SOURCES := $(filter-out $(OP_SOURCES),$(SOURCES))
PLAIN_OBJECTS := $(PLAIN_SOURCES:libsph/%.c=$(BUILD)/obj/%.o)
OP_OBJECTS := $(foreach v,$(VARIANTS),$(OP_SOURCES:libsph/%.c=$(BUILD)/obj/%.$v.o))
OBJECTS := $(PLAIN_OBJECTS) $(OP_OBJECTS)

LIB_STATIC := $(BUILD)/libsph.a
LIB_SHARED := $(BUILD)/libsph.so.$(VERSION)
LIB_SONAME := libsph.so.$(SOVERSION)

TEST_SOURCES := $(sort $(wildcard tests/t[0-9]*.c))
TESTS := $(TEST_SOURCES:tests/%.c=$(BUILD)/tests/%)
# The first series once more, against the shared library.
TESTS_SHARED := $(patsubst tests/%.c,$(BUILD)/tests/shared/%,$(filter tests/t00%,$(TEST_SOURCES)))
EXAMPLES := $(patsubst examples/%.c,$(BUILD)/examples/%,$(sort $(wildcard examples/*.c)))
EXAMPLE_COMMON := $(patsubst examples/%.c,$(BUILD)/examples/obj/%.o,$(wildcard examples/common/*.c))
BENCH_OBJECTS := $(patsubst tests/bench/%.c,$(BUILD)/bench/obj/%.o,$(sort $(wildcard tests/bench/*.c)))
FORMATTED := $(sort $(wildcard include/*.h include/*/*.h libsph/*/*.[ch] tests/*.[ch] tests/*/*.[ch] \
  tests/*/*/*.[ch] examples/*.[ch] examples/*/*.[ch]))

# ---------------------------------------------------------------------------------- how we say it
ifeq ($(V),0)
  say = @printf '  %-7s %s\n' $1 $(or $2,$@);
endif

# ------------------------------------------------------------------------------------- library
.PHONY: all
all: lib
	@echo "built $(LIB_STATIC) and $(LIB_SHARED); 'make help' lists what else there is"

.PHONY: lib
lib: $(LIB_STATIC) $(BUILD)/libsph.so ## build the static and the shared library (the default)

# Rewritten only when a command line would change; everything compiled depends on it.
FLAGS_TEXT = $(CC) $(TARGET) $(COMMON_FLAGS) $(OPT) $(LIB_CPPFLAGS) $(CPPFLAGS) $(CFLAGS) $(LDFLAGS) \
  $(PETSC_CPPFLAGS) $(LIBS) $(foreach v,$(VARIANTS),$(call variant_flags,$v)) $(VERSION)
$(BUILD)/flags: force
	@mkdir -p $(@D)
	@printf '%s\n' '$(subst ','\'',$(strip $(FLAGS_TEXT)))' >$@.new
	@if cmp -s $@.new $@; then rm $@.new; else $(require_gsl) $(require_petsc) mv $@.new $@; fi
.PHONY: force
force:

ifeq ($(GSL)$(GSL_FOUND),1)
  require_gsl = echo "GSL not found by '$(PKG_CONFIG) gsl': install libgsl-dev and pkg-config, or use GSL=0" >&2; \
    rm $@.new; exit 1;
endif

ifeq ($(PETSC)$(PETSC_FOUND),1)
  require_petsc = echo "PETSc not found by '$(PKG_CONFIG) PETSc': install petsc-dev and pkg-config, or use PETSC=0" >&2; \
    rm $@.new; exit 1;
endif

# Rewritten only when a source appears or goes, so that archives hold no objects of the past.
$(BUILD)/sources: force
	@mkdir -p $(@D)
	@echo '$(SOURCES)' | cmp -s - $@ || echo '$(SOURCES)' >$@

# The facts that sph_build_info() tells.
BUILD_FACTS = -DSPHI_BUILD_OPT='"$(strip $(OPT))"' -DSPHI_BUILD_OP_OPT='"$(strip $(OP_OPT) $(RELAXED))"' \
  -DSPHI_BUILD_VARIANTS='"$(strip $(VARIANTS))"' -DSPHI_BUILD_SAN='"$(or $(SAN),no)"' \
  -DSPHI_BUILD_PETSC='"$(if $(filter 1,$(PETSC)),$(shell $(PKG_CONFIG) --modversion $(PETSC_FOUND) 2>/dev/null),no)"'
$(BUILD)/obj/core/build.o: FACTS = $(BUILD_FACTS)
$(BUILD)/obj/solver/petsc.o: FACTS = $(PETSC_CPPFLAGS)

$(BUILD)/obj/%.o: libsph/%.c $(BUILD)/flags
	@mkdir -p $(@D)
	$(call say,CC)$(CC) $(LIB_CFLAGS) $(OPT) $(LIB_CPPFLAGS) $(CPPFLAGS) $(CFLAGS) $(FACTS) -c -o $@ $<

define variant_rule
$(BUILD)/obj/%.$1.o: libsph/%.c $(BUILD)/flags
	@mkdir -p $$(@D)
	$$(call say,CC)$$(CC) $$(LIB_CFLAGS) $$(LIB_CPPFLAGS) $$(CPPFLAGS) $$(CFLAGS) $$(call variant_flags,$1) -c -o $$@ $$<
endef
$(foreach v,$(VARIANTS),$(eval $(call variant_rule,$v)))

$(LIB_STATIC): $(OBJECTS) $(BUILD)/sources
	$(call say,AR)rm -f $@ && $(AR) rcs $@ $(OBJECTS)

$(LIB_SHARED): $(OBJECTS) $(BUILD)/sources
	$(call say,LINK)$(CC) -shared -Wl,-soname,$(LIB_SONAME) $(OPENMP_FLAGS) $(SAN_FLAGS) $(CFLAGS) $(LDFLAGS) \
	  -o $@ $(OBJECTS) $(LIBS)

$(BUILD)/libsph.so: $(LIB_SHARED)
	@ln -sf $(<F) $(@D)/$(LIB_SONAME) && ln -sf $(LIB_SONAME) $@

# One compiler for each processor where the user did not choose.
parallel = $(if $(filter -j% --jobserver%,$(MAKEFLAGS)),,-j$(shell nproc 2>/dev/null || echo 2))

# --------------------------------------------------------------------------------------- tests
PROGRAM_CFLAGS = $(COMMON_FLAGS) $(OPT) -Iinclude -MMD -MP
TEST_CFLAGS = $(PROGRAM_CFLAGS) -Itests -Ilibsph -Wno-psabi $(GSL_CPPFLAGS)

.PHONY: tests
tests: $(TESTS) $(TESTS_SHARED) ## build the test programs

$(BUILD)/tests/shared/%: tests/%.c $(BUILD)/libsph.so $(BUILD)/flags
	@mkdir -p $(@D)
	$(call say,TEST)$(CC) $(TEST_CFLAGS) $(CPPFLAGS) $(CFLAGS) -o $@ $< $(LDFLAGS) -L$(BUILD) \
	  -Wl,-rpath,'$$ORIGIN/../..' -lsph -lcunit -lm

$(BUILD)/tests/%: tests/%.c $(LIB_STATIC) $(BUILD)/flags
	@mkdir -p $(@D)
	$(call say,TEST)$(CC) $(TEST_CFLAGS) $(CPPFLAGS) $(CFLAGS) $(FACTS) -o $@ $< $(LDFLAGS) $(LIB_STATIC) -lcunit $(LIBS)

# A test of programs.
$(BUILD)/tests/t95_study: private FACTS = -DEXAMPLES='"$(abspath $(BUILD)/examples)"'
$(BUILD)/tests/t95_study: $(BUILD)/examples/seawall_study $(BUILD)/examples/movable_seawall

.PHONY: check
check: ## install what is missing, build, run every test; search=t3 runs some
	@CC='$(CC)' tests/tools/need.sh cc pkg-config cunit $(if $(filter 1,$(GSL)),gsl) $(if $(filter 1,$(PETSC)),petsc)
	@$(MAKE) --no-print-directory $(parallel) check-run

.PHONY: check-run
check-run: tests ## run every test without looking for packages
	@tests/tools/run-tests.sh $(foreach t,$(TESTS_SHARED) $(TESTS),$(if $(or $(call not,$(search)),$(findstring $(search),$(notdir $t))),$t))
search ?=
not = $(if $1,,true)

# ------------------------------------------------------------------------------------ examples
.PHONY: examples
examples: $(EXAMPLES) ## build the examples into build/examples

# Made by a pattern rule alone: without this make would remove them after use.
.SECONDARY: $(EXAMPLE_COMMON)
$(BUILD)/examples/obj/%.o: examples/%.c $(BUILD)/flags
	@mkdir -p $(@D)
	$(call say,CC)$(CC) $(PROGRAM_CFLAGS) -pthread -Iexamples $(CPPFLAGS) $(CFLAGS) -c -o $@ $<

$(BUILD)/examples/%: examples/%.c $(EXAMPLE_COMMON) $(LIB_STATIC) $(BUILD)/flags
	@mkdir -p $(@D)
	$(call say,EXAMPLE)$(CC) $(PROGRAM_CFLAGS) -pthread -Iexamples $(CPPFLAGS) $(CFLAGS) -o $@ $< $(EXAMPLE_COMMON) \
	  $(LDFLAGS) $(LIB_STATIC) $(LIBS)


# ------------------------------------------------------------------- demonstration, speed, validation
.PHONY: demo
demo: ## install what is missing, run the examples, leave plots and tables in build/demo
	@CC='$(CC)' tests/tools/need.sh cc pkg-config $(if $(filter 1,$(GSL)),gsl) $(if $(filter 1,$(PETSC)),petsc) gnuplot
	@$(MAKE) --no-print-directory $(parallel) demo-run

.PHONY: demo-run
demo-run: examples
	@if [ -x examples/demo.sh ]; then BUILD='$(BUILD)' examples/demo.sh '$(BUILD)/demo'; \
	else echo "examples/demo.sh does not exist" >&2; exit 1; fi

.PHONY: validate
validate: lib examples ## run the published cases in full and compare with measurements
	@if [ -x tests/validation/run.sh ]; then BUILD='$(BUILD)' tests/validation/run.sh '$(BUILD)/validation'; \
	else echo "tests/validation/run.sh does not exist: nothing to validate"; fi

.PHONY: validate-waves
validate-waves: lib examples ## run the waves and seawalls and compare with exact solutions
	BUILD='$(BUILD)' tests/validation/waves.sh '$(BUILD)/waves'

.PHONY: liang
liang: lib examples ## put every number of Liang et al. (2017) beside ours and the exact ones (LIANG='--study --update' for options)
	BUILD='$(BUILD)' tests/validation/liang.sh '$(BUILD)/liang' $(LIANG)
LIANG ?=

.PHONY: wave-loss
wave-loss: lib examples ## measure what waves lose by resolution, diffusion, viscosity and kernel
	BUILD='$(BUILD)' tests/validation/wave_loss.sh '$(BUILD)/wave_loss'

.PHONY: compare-methods
compare-methods: lib examples ## compute the same waves by three methods (COMPARE='--update' for options)
	BUILD='$(BUILD)' tests/validation/methods.sh '$(BUILD)/methods' $(COMPARE)

.PHONY: compare-interpolators
compare-interpolators: lib examples $(BUILD)/interpolators/interpolators ## measure all interpolators side by side (COMPARE='--update' for options)
	BUILD='$(BUILD)' tests/validation/interpolators.sh '$(BUILD)/interpolators' $(COMPARE)
COMPARE ?=

$(BUILD)/interpolators/interpolators: tests/validation/interpolators.c $(LIB_STATIC) $(BUILD)/flags
	@mkdir -p $(@D)
	$(call say,CC)$(CC) $(PROGRAM_CFLAGS) $(CPPFLAGS) $(CFLAGS) -o $@ $< $(LDFLAGS) $(LIB_STATIC) $(LIBS)

.PHONY: bench
bench: $(BUILD)/bench/bench ## measure the speed; table and build/bench.json (BENCH='--quick' for options)
	GOMP_SPINCOUNT=$${GOMP_SPINCOUNT:-10000} $< --json $(BUILD)/bench.json $(BENCH)
BENCH ?=

.PHONY: bench-compare
BASELINE ?= $(BUILD)/bench.json
bench-compare: $(BUILD)/bench/bench ## measure again; fail if 10 % slower than BASELINE=build/bench.json
	GOMP_SPINCOUNT=$${GOMP_SPINCOUNT:-10000} $< --json $(BUILD)/bench-new.json --compare '$(BASELINE)' $(BENCH)

# With -O3, so that the plain loop which everything is compared with gets what a compiler can give it.
$(BUILD)/bench/obj/%.o: tests/bench/%.c $(BUILD)/flags
	@mkdir -p $(@D)
	$(call say,CC)$(CC) $(PROGRAM_CFLAGS) -O3 $(CPPFLAGS) $(CFLAGS) -c -o $@ $<

$(BUILD)/bench/bench: $(BENCH_OBJECTS) $(LIB_STATIC)
	$(call say,BENCH)$(CC) $(PROGRAM_CFLAGS) $(CFLAGS) -o $@ $(BENCH_OBJECTS) $(LDFLAGS) $(LIB_STATIC) $(LIBS)

.PHONY: bench-solver
bench-solver: $(BUILD)/bench/solver ## measure the linear solvers; the tables of docs/solver.md (BENCH=--quick)
	OMP_WAIT_POLICY=$${OMP_WAIT_POLICY:-passive} $< $(BENCH)

$(BUILD)/bench/solver: tests/bench/solver/solver.c $(LIB_STATIC) $(BUILD)/flags
	@mkdir -p $(@D)
	$(call say,BENCH)$(CC) $(PROGRAM_CFLAGS) $(CPPFLAGS) $(CFLAGS) -o $@ $< $(LDFLAGS) $(LIB_STATIC) $(LIBS)

# -------------------------------------------------------------------------------- rules of the house
HEADER_WARNINGS := -Wall -Wextra -Wpedantic -Werror -Iinclude -fsyntax-only
.PHONY: headers
headers: ## compile every public header alone as C99, C11 and C++17
	@for header in $(HEADERS:include/%=%); do for standard in c99 c11 c++17; do \
	  case $$standard in c++*) compiler='$(CXX) -x c++';; *) compiler='$(CC) -x c -Wstrict-prototypes';; esac; \
	  printf '#include <%s>\ntypedef int sph_alone;\n' $$header | $$compiler -std=$$standard $(HEADER_WARNINGS) - || \
	    { echo "<$$header> does not compile alone as $$standard" >&2; exit 1; }; \
	done; done
	@echo "$(words $(HEADERS)) headers compile alone as C99, C11 and C++17"

.PHONY: layers
layers: ## check who includes whom
	@awk -f tests/tools/layers.awk $(FORMATTED)

.PHONY: abi
abi: lib ## compare the exported symbols with tests/data/libsph.sym
	@NM='$(NM)' tests/tools/abi.sh check $(LIB_SHARED) $(LIB_STATIC) tests/data/libsph.sym

.PHONY: abi-update
abi-update: lib ## accept the exported symbols as they are now
	@NM='$(NM)' tests/tools/abi.sh update $(LIB_SHARED) $(LIB_STATIC) tests/data/libsph.sym

.PHONY: docs-check
docs-check: ## check that every public function has its contract
	@awk -f tests/tools/contracts.awk $(HEADERS)

.PHONY: format
format: ## format the sources in place
	$(CLANG_FORMAT) -i $(FORMATTED)

.PHONY: format-check
format-check: ## check the format of the sources
	@$(CLANG_FORMAT) --dry-run -Werror $(FORMATTED)
	@echo "$(words $(FORMATTED)) files are formatted"

.PHONY: tidy
tidy: compile_commands.json ## run clang-tidy over the library
	@command -v $(CLANG_TIDY) >/dev/null || { echo "$(CLANG_TIDY) not found: install clang-tidy" >&2; exit 1; }
	$(CLANG_TIDY) --quiet -p . $(SOURCES)

# Pair loops appear in their baseline variant: a tool wants one entry a file.
compile_commands.json: $(BUILD)/flags $(SOURCES) ## the database that editors and clang-tidy read
	$(call say,JSON)$(file >$@,[)$(foreach s,$(PLAIN_SOURCES),$(file >>$@,$(call json_entry,$s)))$(foreach \
	  s,$(OP_SOURCES),$(file >>$@,$(call json_entry,$s,$(call variant_flags,base_f32)))):
	@sed -i.new '$$ s/,$$//' $@ && rm -f $@.new && echo ']' >>$@
json_entry = {"directory": "$(CURDIR)", "file": "$1", "command": "$(subst ",\",$(strip $(CC) $(LIB_CFLAGS) \
  $(OPT) $(LIB_CPPFLAGS) $(CPPFLAGS) $(CFLAGS) $2)) -c $1"},

# ---------------------------------------------------------------------------------------- documents
.PHONY: docs
docs: ## build the reference with Doxygen into build/docs/html
	@command -v $(DOXYGEN) >/dev/null || { echo "$(DOXYGEN) not found: install doxygen" >&2; exit 1; }
	@mkdir -p $(BUILD)/docs
	$(call say,DOCS){ cat docs/Doxyfile; echo 'OUTPUT_DIRECTORY = $(BUILD)/docs'; echo 'PROJECT_NUMBER = $(VERSION)'; } | \
	  $(DOXYGEN) -
	@echo "wrote $(BUILD)/docs/html/index.html"

# ------------------------------------------------------------------------------------------ install
INSTALL ?= install
# Below the prefix, paths are written relative to it, so that the tree can be moved.
below_prefix = $(patsubst $(prefix)/%,$${prefix}/%,$1)
CMAKE_DIR = $(libdir)/cmake/sph
UP_FROM_CMAKE_DIR = $(subst $(space),/,$(patsubst %,..,$(subst /, ,$(patsubst $(prefix)/%,%,$(CMAKE_DIR)))))
SUBSTITUTE = sed -e 's|@VERSION@|$(VERSION)|g' -e 's|@SOVERSION@|$(SOVERSION)|g' \
  -e 's|@VERSION_MAJOR@|$(VERSION_MAJOR)|g' -e 's|@VERSION_MINOR@|$(VERSION_MINOR)|g' \
  -e 's|@prefix@|$(prefix)|g' -e 's|@libdir@|$(call below_prefix,$(libdir))|g' \
  -e 's|@includedir@|$(call below_prefix,$(includedir))|g' -e 's|@up@|$(UP_FROM_CMAKE_DIR)|g' \
  -e 's|@requires@|$(strip $(if $(filter 1,$(GSL)),gsl) $(PETSC_FOUND) $(PETSC_MPI))|g' -e 's|@openmp@|$(OPENMP_FLAGS)|g' \
  -e 's|@static_libs@|$(subst $(space),;,$(strip $(LIBS) $(OPENMP_FLAGS)))|g'
EXAMPLE_FILES = $(sort $(wildcard examples/*.c examples/*/*.[ch]))

.PHONY: install
install: lib ## install below DESTDIR and PREFIX (/usr/local)
	@case '$(prefix)' in /*) ;; *) echo "prefix must be an absolute path, got '$(prefix)'" >&2; exit 1;; esac
	$(INSTALL) -d '$(DESTDIR)$(includedir)/sph' '$(DESTDIR)$(libdir)/pkgconfig' '$(DESTDIR)$(CMAKE_DIR)'
	$(INSTALL) -m 644 include/sph.h '$(DESTDIR)$(includedir)/'
	$(INSTALL) -m 644 $(wildcard include/sph/*.h) '$(DESTDIR)$(includedir)/sph/'
	$(INSTALL) -m 644 $(LIB_STATIC) '$(DESTDIR)$(libdir)/'
	$(INSTALL) -m 755 $(LIB_SHARED) '$(DESTDIR)$(libdir)/'
	ln -sf $(notdir $(LIB_SHARED)) '$(DESTDIR)$(libdir)/$(LIB_SONAME)'
	ln -sf $(LIB_SONAME) '$(DESTDIR)$(libdir)/libsph.so'
	$(SUBSTITUTE) libsph/package/sph.pc.in >'$(DESTDIR)$(libdir)/pkgconfig/sph.pc'
	$(SUBSTITUTE) -e 's|$${prefix}|$${SPH_PREFIX}|g' libsph/package/sphConfig.cmake.in \
	  >'$(DESTDIR)$(CMAKE_DIR)/sphConfig.cmake'
	$(SUBSTITUTE) libsph/package/sphConfigVersion.cmake.in >'$(DESTDIR)$(CMAKE_DIR)/sphConfigVersion.cmake'
	$(INSTALL) -d '$(DESTDIR)$(datadir)/sph'
	$(INSTALL) -m 644 LICENSE '$(DESTDIR)$(datadir)/sph/'
	@for file in $(EXAMPLE_FILES); do \
	  $(INSTALL) -d "$(DESTDIR)$(datadir)/sph/$${file%/*}" && \
	  $(INSTALL) -m 644 $$file "$(DESTDIR)$(datadir)/sph/$$file" || exit 1; done

.PHONY: uninstall
uninstall: ## remove what install put there
	rm -rf '$(DESTDIR)$(includedir)/sph' '$(DESTDIR)$(CMAKE_DIR)' '$(DESTDIR)$(datadir)/sph'
	rm -f '$(DESTDIR)$(includedir)/sph.h' '$(DESTDIR)$(libdir)/libsph.a' \
	  '$(DESTDIR)$(libdir)/$(notdir $(LIB_SHARED))' '$(DESTDIR)$(libdir)/$(LIB_SONAME)' \
	  '$(DESTDIR)$(libdir)/libsph.so' '$(DESTDIR)$(libdir)/pkgconfig/sph.pc'

.PHONY: check-installed
check-installed: lib ## install into a scratch folder; build and run a program by pkg-config and by CMake
	@MAKE='$(MAKE)' CC='$(CC)' PKG_CONFIG='$(PKG_CONFIG)' VERSION='$(VERSION)' BUILD='$(BUILD)' \
	  tests/tools/check-installed.sh '$(BUILD)/installed'

# ------------------------------------------------------------------------------------ configuration
.PHONY: configure
configure: ## keep options in config.mk: make configure GSL=0 CC=clang
	@: $(file >config.mk,# Written by `make configure`; `make distclean` removes it.)
	@: $(foreach v,$(CONFIGURED),$(file >>config.mk,$v = $($v)))
	@cat config.mk

print = @printf '  %-12s %s\n' '$1' '$(subst ','\'',$(strip $2))'
.PHONY: info
info: ## show the version, the options and what was found
	$(call print,version,$(VERSION) (soname $(LIB_SONAME)))
	$(call print,CC,$(CC): $(shell $(CC) --version 2>/dev/null | head -n 1))
	$(call print,target,$(TARGET))
	$(call print,OPT,$(OPT))
	$(call print,OP_OPT,$(OP_OPT) $(RELAXED))
	$(call print,variants,$(VARIANTS))
	$(call print,GSL,$(if $(filter 1,$(GSL)),1 ($(if $(GSL_FOUND),found $(GSL_FOUND),not found by $(PKG_CONFIG): install libgsl-dev or use GSL=0)),0 (not used)))
	$(call print,PETSC,$(if $(filter 1,$(PETSC)),1 ($(if $(PETSC_FOUND),found $(PETSC_FOUND),not found by $(PKG_CONFIG): install petsc-dev or use PETSC=0)),0 (not used)))
	$(call print,OPENMP,$(OPENMP))
	$(call print,DEBUG,$(DEBUG))
	$(call print,SAN,$(or $(SAN),none))
	$(call print,WERROR,$(WERROR))
	$(call print,BUILD,$(BUILD))
	$(call print,prefix,$(prefix))
	$(call print,configured,$(or $(strip $(CONFIGURED)),nothing) (make configure))

print-%: ## show one variable of this file: make print-OBJECTS
	@printf '%s\n' '$(subst ','\'',$($*))'

.PHONY: help
help: ## show this list
	@echo "targets of libsph $(VERSION):"
	@awk -F':.*## ' '/^[a-z%._-]+:.*## /{printf "  %-21s %s\n", $$1, $$2}' Makefile
	@echo "options: GSL=1 PETSC=0 OPENMP=1 DEBUG=0 WERROR=0 V=0 SAN=address,undefined CC=clang OPT=-O3 BUILD=dir"
	@echo "         PREFIX=/usr/local DESTDIR=; 'make configure NAME=value ...' keeps them in config.mk"

.PHONY: clean
clean: ## remove the build folders
	rm -rf '$(BUILD)' build build-*

.PHONY: distclean
distclean: clean ## remove also config.mk and compile_commands.json
	rm -f config.mk compile_commands.json

-include $(OBJECTS:.o=.d) $(TESTS:=.d) $(TESTS_SHARED:=.d) $(EXAMPLES:=.d) $(EXAMPLE_COMMON:.o=.d) $(BENCH_OBJECTS:.o=.d) $(BUILD)/interpolators/interpolators.d \
  $(BUILD)/bench/solver.d
