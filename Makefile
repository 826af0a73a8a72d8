# The entry point.  `make help` lists the targets.  All output is in build/.
#
#   JOBS=n      number of parallel compile and test processes (default: the cores)
#   SETUP=true  skips the installation of Debian packages (for other systems)
JOBS ?= $(shell nproc 2>/dev/null || echo 2)
SETUP ?= .ci/setup
PREFIX ?= /usr/local
PYTHON := /usr/bin/python3
BUILD := build/release
DEMO := build/demo
SOURCES = $(shell find include src tests -name '*.cpp' -o -name '*.hpp')

.PHONY: help setup configure build product demo docs test test-thorough test-slow \
    test-sanitizers bench format format-check package install clean
.NOTPARALLEL:

help:  ## list the targets
	@awk -F ':.*## *' '/^[a-z-]+:.*##/ { printf "  make %-17s%s\n", $$1, $$2 }' Makefile

setup:  ## install missing Debian packages
	@$(SETUP)

configure: setup
	@cmake --preset release --log-level=WARNING >/dev/null

build: configure  ## compile everything, optimised, in build/release
	@cmake --build $(BUILD) --parallel $(JOBS)

product: configure
	@cmake --build $(BUILD) --parallel $(JOBS) --target drover_program drover_python drover_manual

demo: configure  ## a flock of particles, a flock of fields, and theory, on one page in build/demo
	@cmake --build $(BUILD) --parallel $(JOBS) --target drover_program drover_python
	@PYTHONPATH=$(CURDIR)/$(BUILD)/python PYTHONDONTWRITEBYTECODE=1 $(PYTHON) -m drover.demo --output $(DEMO)

docs: product  ## build the manual, build/docs/index.html (ten core-minutes the first time: notebooks, gallery)
	@[ "$(SETUP)" = true ] || $(SETUP) docs
	@PYTHONPATH=$(CURDIR)/$(BUILD)/python PYTHONDONTWRITEBYTECODE=1 $(PYTHON) src/docs/build.py --drover $(BUILD)/drover \
	    --output build/docs

test: build  ## run the fast tests
	@ctest --test-dir $(BUILD) --label-regex fast --parallel $(JOBS) --output-on-failure --no-tests=error

test-thorough: build  ## run the tests of faults, pages, pictures and studies, which every change must pass too
	@ctest --test-dir $(BUILD) --label-regex thorough --parallel $(JOBS) --output-on-failure --no-tests=error

test-slow: build  ## run the slow tests
	@ctest --test-dir $(BUILD) --label-regex slow --parallel $(JOBS) --output-on-failure --no-tests=error

test-sanitizers: setup  ## run the fast and thorough tests under address and undefined-behaviour sanitizers
	@.ci/sanitize

bench: setup  ## run the benchmarks; fail if a ratio of costs is worse than listed
	@cmake --preset release --log-level=WARNING -D DROVER_BENCHMARKS=ON >/dev/null
	@cmake --build $(BUILD) --parallel $(JOBS) --target drover_bench
	$(BUILD)/tests/drover_bench
	$(PYTHON) tests/bench/ratios.py $(BUILD)/tests/drover_bench

format: setup  ## format the C++ sources with clang-format
	@clang-format-14 -i $(SOURCES)

format-check: setup  ## list C++ sources that are not formatted
	@clang-format-14 --dry-run --Werror $(SOURCES)

package: product  ## build a Debian package, build/release/drover_*.deb
	@cd $(BUILD) && cpack -G DEB

install: product  ## install below PREFIX (/usr/local)
	@cmake --install $(BUILD) --prefix $(PREFIX)

clean:  ## remove build/
	@cmake -E rm -rf build
