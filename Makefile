# The front door.  `make help` lists what there is.  All of it is made in build/.
#
#   JOBS=n      processes that compile and test at a time (default: the cores)
#   SETUP=true  does not look for Debian packages (for other systems)
JOBS ?= $(shell nproc 2>/dev/null || echo 2)
SETUP ?= .ci/setup
PREFIX ?= /usr/local
PYTHON := /usr/bin/python3
SCENE := number-fluctuations
BUILD := build/release
DEMO := build/demo/$(SCENE)
SOURCES = $(shell find include src tests -name '*.cpp' -o -name '*.hpp')

.PHONY: help setup configure build demo test test-slow bench format format-check package install clean
.NOTPARALLEL:

help:  ## this list
	@awk -F ':.*## *' '/^[a-z-]+:.*##/ { printf "  make %-14s%s\n", $$1, $$2 }' Makefile

setup:  ## installs the Debian packages that are missing
	@$(SETUP)

configure: setup
	@cmake --preset release --log-level=WARNING >/dev/null

build: configure  ## compiles everything, optimised, in build/release
	@cmake --build $(BUILD) --parallel $(JOBS)

demo: configure  ## runs a first simulation and draws it: build/demo
	@cmake --build $(BUILD) --parallel $(JOBS) --target drover_program
	@mkdir -p build/demo
	$(BUILD)/drover run models/$(SCENE).toml --overwrite --output $(DEMO).h5
	PYTHONPATH=src/python PYTHONDONTWRITEBYTECODE=1 $(PYTHON) -m drover.figure $(DEMO).h5 --output $(DEMO).png
	@test -s $(DEMO).h5 && test -s $(DEMO).png
	@printf '\nThe run, for h5py, xarray or ParaView:  %s\nIts figure:                             %s\n' $(DEMO).h5 $(DEMO).png

test: build  ## runs the fast tests
	@ctest --test-dir $(BUILD) --label-regex fast --parallel $(JOBS) --output-on-failure --no-tests=error

test-slow: build  ## runs the slow tests
	@ctest --test-dir $(BUILD) --label-regex slow --parallel $(JOBS) --output-on-failure --no-tests=error

bench: setup  ## measures speed
	@cmake --preset release --log-level=WARNING -D DROVER_BENCHMARKS=ON >/dev/null
	@cmake --build $(BUILD) --parallel $(JOBS) --target drover_bench
	$(BUILD)/tests/drover_bench

format: setup  ## puts the C++ sources in the style of .clang-format
	@clang-format-14 -i $(SOURCES)

format-check: setup  ## says where they are not
	@clang-format-14 --dry-run --Werror $(SOURCES)

package: build  ## makes a Debian package, build/release/drover_*.deb
	@cd $(BUILD) && cpack -G DEB

install: build  ## installs below PREFIX (/usr/local)
	@cmake --install $(BUILD) --prefix $(PREFIX)

clean:  ## removes build/
	@cmake -E rm -rf build
