# SPDX-License-Identifier: MIT
# make run: install what is missing, reproduce every paper. make test: the same set-up, then every test. make help: the rest.
SHELL := /bin/bash
.DEFAULT_GOAL := help
MAKEFLAGS += --no-print-directory
# Requirements are installed without byte code: what is imported is compiled once, then.
unexport PYTHONDONTWRITEBYTECODE

VENV := .venv
BIN := $(VENV)/bin
OUT := out/report
STEP := scripts/step
BESIDE := nice -n 5 $(STEP)
FUZZ_SECONDS := 60
# Debian's names of what is needed.
FOR_RUN = $(shell scripts/find_python --packages) g++ cmake ninja-build ccache libeigen3-dev libsundials-dev librandom123-dev
FOR_TEST := libgtest-dev libgmock-dev
FOR_PYTEST := chromium chromium-driver
FOR_EMBEDDED := gcc-arm-none-eabi libstdc++-arm-none-eabi-newlib qemu-system-arm
CPP = $(shell find cpp bindings tests benchmarks examples sundials_cfg -name '*.hpp' -o -name '*.cpp')
PACKAGE := CMakeLists.txt pyproject.toml docs/package.md LICENSE $(shell find cpp bindings python cmake licenses sundials_cfg -type f \
        -not -path '*/__pycache__/*')

.PHONY: help run test cpp docs docs-serve headers asan asan-python python pytest types stubs-check lint bench wheel release-check matrix mutants tidy embedded embedded-short fuzz format stubs clean debian-run debian-test debian-pytest \
        debian-make-test debian-bench debian-embedded debian-fuzz debian-docs

help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

run: debian-run $(VENV)/package.stamp  ## install what is missing, reproduce every paper, leave a report in out/report
	@$(BIN)/gyrostat reproduce all --out $(OUT)

# Compilers and pytest use every core themselves; what uses one runs beside them, and yields to them: first the network and
# what needs no compiled module, then what does. What compilers need is installed first, the rest beside them.
test:  ## the same set-up, then all tests, types, stubs and format
	@scripts/debian_packages $(FOR_RUN) $(FOR_TEST) -- $(FOR_PYTEST) $(FOR_EMBEDDED)
	@$(MAKE) -j4 cpp debian-make-test lint types
	@$(MAKE) $(VENV)/package.stamp
	@$(MAKE) -j2 pytest stubs-check embedded-short
	@echo "all tests passed"

cpp: debian-test  ## C++ libraries and all their tests, optimised
	@$(STEP) configure-release cmake --preset release
	@$(STEP) build-release cmake --build --preset release
	@$(STEP) ctest-release ctest --preset release

asan: debian-test  ## C++ tests once more under the address sanitizer, libraries and a short loop per component under that for undefined behaviour too
	@$(STEP) configure-asan cmake --preset asan
	@$(STEP) build-asan cmake --build --preset asan
	@$(STEP) ctest-asan ctest --preset asan

asan-python: debian-test $(VENV)/test.stamp  ## the compiled Python module under the sanitizers
	@$(STEP) configure-asan-python cmake --preset asan-python -DPython_EXECUTABLE=$(abspath $(BIN)/python)
	@$(STEP) build-asan-python cmake --build --preset asan-python
	@$(STEP) asan-python scripts/sanitized $(BIN)/python tests/sanitized/bindings.py build/asan-python/bindings

python: pytest types stubs-check  ## Python tests, types and stubs

pytest: debian-pytest $(VENV)/package.stamp $(VENV)/test.stamp
	@$(STEP) pytest $(BIN)/pytest -n auto --dist loadfile

types: $(VENV)/test.stamp
	@$(BESIDE) mypy $(BIN)/mypy

stubs-check: $(VENV)/package.stamp $(VENV)/test.stamp
	@$(BESIDE) stubs scripts/stubs $(BIN) --check

lint: $(VENV)/test.stamp  ## format and lint, nothing is changed
	@$(BESIDE) ruff-check $(BIN)/ruff check
	@$(BESIDE) ruff-format $(BIN)/ruff format --check
	@$(BESIDE) clang-format $(BIN)/clang-format --dry-run --Werror $(CPP)

format: $(VENV)/test.stamp  ## format everything
	@$(BIN)/ruff check --fix --quiet || true
	@$(BIN)/ruff format --quiet
	@$(BIN)/clang-format -i $(CPP)

stubs: $(VENV)/package.stamp $(VENV)/test.stamp  ## write the type stubs of the compiled module and of the catalogue's modules
	@scripts/stubs $(BIN)

bench: debian-bench  ## benchmarks; each prints its table
	@$(STEP) configure-bench cmake --preset bench
	@$(STEP) build-bench cmake --build --preset bench
	@for b in build/bench/benchmarks/bench_*; do [ -x $$b ] && [ -f $$b ] && echo "== $${b##*/}" && $$b; done

docs: debian-docs $(VENV)/docs.stamp  ## the documentation as a site, build/site/index.html; warns about nothing
	@$(STEP) docs-prepare $(BIN)/python scripts/site/prepare.py build
	@$(STEP) docs-site env -C build ../$(BIN)/zensical build --strict -f mkdocs.yml
	@$(STEP) docs-check $(BIN)/python scripts/site/check.py build/site
	@echo "build/site/index.html"

docs-serve: docs  ## the same, served while one reads it
	@$(BIN)/python -m http.server --directory build/site --bind 127.0.0.1 8000

fuzz: debian-fuzz  ## a minute of coverage-guided fuzzing of every stack, under the sanitizers; FUZZ_SECONDS=600 for longer
	@$(STEP) configure-fuzz cmake --preset fuzz
	@$(STEP) build-fuzz cmake --build --preset fuzz
	@mkdir -p build/fuzz/corpus
	@$(STEP) fuzz env -C build/fuzz tests/fuzz/fuzz_stack -max_total_time=$(FUZZ_SECONDS) -max_len=4096 -jobs=2 -workers=2 corpus

embedded: debian-embedded $(VENV)/package.stamp  ## exported flight stacks on an emulated Cortex-M7, against the host; prints sizes and instructions
	@$(BIN)/python scripts/embedded

embedded-short: debian-embedded $(VENV)/package.stamp  ## the one of these stacks with the most in it, as make test flies it
	@$(BESIDE) embedded-short $(BIN)/python scripts/embedded cubesat_6u

mutants: debian-test $(VENV)/venv.stamp  ## break core and flight in a few hundred places, one at a time: do the C++ tests notice?
	@nice $(BIN)/python scripts/mutants

headers: debian-test  ## every header compiled alone (a minute and a half; make test checks the layers' include roots)
	@$(STEP) configure-release cmake --preset release
	@$(STEP) headers-alone cmake --build --preset release --target all_verify_interface_header_sets

matrix: debian-test headers asan-python embedded $(VENV)/test.stamp  ## the flight code and its tests with every compiler found, and the rest that CI has no time for
	@scripts/matrix

tidy: debian-test  ## clang-tidy over our own sources
	@$(STEP) configure-dev cmake --preset dev
	@$(STEP) clang-tidy run-clang-tidy -quiet -p build/dev 'cpp/(truth|host)/.*\.cpp$$'

wheel: debian-run $(VENV)/wheel.stamp  ## dist/*.whl for any Linux of this processor, by way of the source distribution, and what auditwheel says of it
	@scripts/wheel $(BIN)

release-check: wheel $(VENV)/test.stamp  ## version, changelog, citation, wheel, source distribution and docs agree
	@$(BIN)/python scripts/release_check

clean:  ## everything that was made here
	rm -rf build out dist $(VENV)

debian-run:
	@scripts/debian_packages $(FOR_RUN)

debian-test:
	@scripts/debian_packages $(FOR_RUN) $(FOR_TEST)

debian-pytest:
	@scripts/debian_packages $(FOR_RUN) $(FOR_TEST) $(FOR_PYTEST)

debian-make-test:
	@scripts/debian_packages $(FOR_RUN) $(FOR_TEST) $(FOR_PYTEST) $(FOR_EMBEDDED)

debian-fuzz:
	@scripts/debian_packages $(FOR_RUN) clang libclang-rt-dev libomp-dev

debian-docs:
	@scripts/debian_packages doxygen

debian-embedded:
	@scripts/debian_packages $(FOR_RUN) $(FOR_EMBEDDED)

debian-bench:
	@scripts/debian_packages $(FOR_RUN) $(FOR_TEST) libbenchmark-dev

# The virtual environment carries the build requirements, so that a rebuild compiles only what changed. The module is
# compiled where `make cpp` compiled the libraries, by the same compiler and CMake: the test tools bring one of their own into
# the environment, with which everything would be built once more.
$(VENV)/venv.stamp: pyproject.toml | debian-run
	@scripts/make_venv $(VENV)
	@touch $@

$(VENV)/package.stamp: $(VENV)/venv.stamp $(PACKAGE) | debian-run
	@CXX=$${CXX:-c++} CMAKE_EXECUTABLE=$$(command -v cmake) $(STEP) install-gyrostat $(BIN)/pip install --no-build-isolation --config-settings=build-dir=build/release .
	@touch $@

$(VENV)/docs.stamp: $(VENV)/venv.stamp
	@$(STEP) install-docs-tools scripts/install_requirements $(BIN) project.optional-dependencies.docs
	@touch $@

$(VENV)/wheel.stamp: $(VENV)/venv.stamp
	@$(STEP) install-wheel-tools scripts/install_requirements $(BIN) project.optional-dependencies.wheel
	@touch $@

$(VENV)/test.stamp: $(VENV)/venv.stamp
	@$(STEP) install-test-tools scripts/install_requirements $(BIN) project.dependencies project.optional-dependencies.test
	@touch $@
