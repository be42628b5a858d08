# Everything a newcomer types is here: `make demo` and `make test`. `make help` lists the rest.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.PHONY: FORCE help demo check test test-python test-fleet kept-outputs python-tools wheel docs bench-python \
  export-tools bench study article figures clean check-toolchain check-components \
  app page page-tools browser-tools test-browser test-exports smoke-browser release-dry-run fuzz mutants faults \
  page-figure

RECORD := examples/piezo-p885-200hz/identification_1hz.csv
CYCLES := $(wildcard examples/afm-z-scanner/cycle_1_300hz_0*.csv)
OUT := out
HYSTERON := target/release/hysteron

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | \
	  sed -E 's/^([a-z-]+):.*## (.*)/  make \1|\2/' | column -t -s '|'

check-toolchain:
	@command -v cargo >/dev/null || { echo "error: cargo is not installed"; \
	  echo "  try: install a Rust toolchain (1.90 or newer), see https://rustup.rs"; exit 1; }
	@command -v cc >/dev/null || { echo "error: no C linker (cc) is installed"; \
	  echo "  try: your system's compiler package, e.g. 'apt-get install gcc libc6-dev'"; exit 1; }

check-components: check-toolchain
	@cargo fmt --version >/dev/null 2>&1 || rustup component add rustfmt || { \
	  echo "error: rustfmt is missing; try: rustup component add rustfmt"; exit 1; }
	@cargo clippy --version >/dev/null 2>&1 || rustup component add clippy || { \
	  echo "error: clippy is missing; try: rustup component add clippy"; exit 1; }

$(HYSTERON): check-toolchain FORCE
	cargo build --release --locked -p hysteron-cli

demo: $(HYSTERON) ## build, identify the measured example records, print the scores, write models and reports
	@mkdir -p $(OUT)
	$(HYSTERON) identify $(RECORD) -o $(OUT)/model.json --report $(OUT)/report.html
	@echo
	$(HYSTERON) identify $(CYCLES) --continued --input u_V --output y_um -o $(OUT)/scanner.json \
	  --report $(OUT)/scanner.html
	@echo
	@echo "models   $(abspath $(OUT)/model.json), $(abspath $(OUT)/scanner.json)"
	@echo "reports  $(abspath $(OUT)/report.html), $(abspath $(OUT)/scanner.html)  " \
	  "(open them in a browser; they need no network)"

# An environment with the package and what its tests run with, made anew where the list of these changes.
PYTHON := target/python
python-tools: check-toolchain
	@command -v python3 >/dev/null || { echo "error: python3 is not installed"; \
	  echo "  try: your system's package, e.g. 'apt-get install python3 python3-venv'"; exit 1; }
	@cmp -s python/requirements-test.txt $(PYTHON)/installed.txt || { \
	  rm -rf $(PYTHON) && python3 -m venv $(PYTHON) && \
	  $(PYTHON)/bin/pip install --quiet --disable-pip-version-check -r python/requirements-test.txt && \
	  $(PYTHON)/bin/pip install --quiet --disable-pip-version-check --no-deps sysidentpy==0.9.0 && \
	  cp python/requirements-test.txt $(PYTHON)/installed.txt; }

# Of the whole workspace, as the tests are: with the dependencies of the command alone all would be built once more.
COMMAND := cargo build --locked --workspace --bin hysteron

test-python: python-tools ## the Python package: built beside the command, linted, type-checked, tested
	$(COMMAND)
	VIRTUAL_ENV=$(abspath $(PYTHON)) $(PYTHON)/bin/maturin develop --locked --quiet
	@python/tests/install-tools.sh
	$(PYTHON)/bin/ruff check python && $(PYTHON)/bin/ruff format --check python
	$(PYTHON)/bin/mypy && $(PYTHON)/bin/python -m mypy.stubtest hysteron_models._native
	$(PYTHON)/bin/python -m pytest

test-fleet: python-tools ## a night with faults: Dask, 500 simulated devices, workers and client killed, disk full once
	VIRTUAL_ENV=$(abspath $(PYTHON)) $(PYTHON)/bin/maturin develop --locked --quiet
	$(PYTHON)/bin/python python/tests/fleet_faults.py

kept-outputs: ## run the notebooks and keep their outputs; draw the pictures that plots are compared with
kept-outputs: python-tools
	VIRTUAL_ENV=$(abspath $(PYTHON)) $(PYTHON)/bin/maturin develop --locked --quiet
	$(PYTHON)/bin/python python/tests/notebooks.py
	$(PYTHON)/bin/python -m pytest python/tests/test_pictures.py --renew-pictures

docs: python-tools ## the documentation as a site that works offline, in out/site
	$(COMMAND)
	NO_MKDOCS_2_WARNING=1 $(PYTHON)/bin/mkdocs build --quiet
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked
	@mkdir -p $(OUT)/site && rm -rf $(OUT)/site/rust && cp -r target/doc $(OUT)/site/rust
	@echo "site  $(abspath $(OUT)/site)/index.html"

wheel: python-tools ## a wheel for any Linux with glibc 2.17 or newer and CPython 3.10 or newer, in out/wheels
	$(PYTHON)/bin/pip install --quiet --disable-pip-version-check ziglang==0.14.1
	rustup target add x86_64-unknown-linux-gnu >/dev/null 2>&1 || true
	VIRTUAL_ENV=$(abspath $(PYTHON)) PATH=$(abspath $(PYTHON))/bin:$$PATH \
	  $(PYTHON)/bin/maturin build --release --locked --zig \
	  --compatibility manylinux_2_17 --out $(OUT)/wheels

fuzz: check-toolchain ## every entry of fuzz/ in libFuzzer for SECONDS (60); EXECUTIONS=N until each has had so many
	scripts/fuzz.py --jobs $(or $(JOBS),$(shell nproc)) $(if $(EXECUTIONS),--executions $(EXECUTIONS),--seconds $(or $(SECONDS),60))

# Known to print changes as the script applies them.
CARGO_MUTANTS := 27.1.0
mutants: check-toolchain ## 150 changes of the source, one at a time: do the tests notice? (MOST=N: the next N)
	@test -x target/tools/bin/cargo-mutants || \
	  cargo install --quiet --locked --debug --root target/tools --version $(CARGO_MUTANTS) cargo-mutants
	scripts/mutants.py $(if $(MOST),--most $(MOST)) $(if $(JOBS),--jobs $(JOBS))

faults: python-tools ## KILLS (500) at random instants, full disks, closed pipes, two writers: nothing is lost (SEED=N)
	$(COMMAND)
	VIRTUAL_ENV=$(abspath $(PYTHON)) $(PYTHON)/bin/maturin develop --locked --quiet
	python3 scripts/faults target/debug/hysteron --kills $(or $(KILLS),500) $(if $(SEED),--seed $(SEED)) \
	  --fleet $(PYTHON)/bin/python

release-dry-run: python-tools ## what of a release can be tried here: workflows, wheel, binary, crates packaged in order (QUICK=1)
	scripts/release-dry-run.sh

export-tools: ## install what the tests of exported source use: compilers, simulators, Octave, FMPy
	@crates/hysteron-export/tests/install-tools.sh

test-exports: export-tools ## exported source of every model with every compiler, number type and sanitizer
	HYSTERON_EVERY_EXPORT=1 cargo test --workspace --locked --test export -- --nocapture

check: ## before every commit: format, lints, arrows between crates and folders, unit and doc tests
check: check-components
	cargo fmt --all --check
	@command -v python3 >/dev/null || { echo "error: python3 is not installed"; \
	  echo "  try: your system's package, e.g. 'apt-get install python3'"; exit 1; }
	scripts/house.py
	cargo clippy --workspace --all-targets --locked -- -D warnings
	cargo test --workspace --locked --lib --bins
	cargo test --workspace --locked --doc

# Of the whole workspace always: with fewer packages, libraries have other features and are built again.
test: ## everything: check, documentation, no_std proof, integration tests; page and exports come last
test: check
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked
	crates/hysteron-rt/proof/run.sh
	$(MAKE) python-tools
	HYSTERON_PYTHON=$(abspath $(PYTHON))/bin/python \
	  cargo test --workspace --exclude hysteron-export --locked --test '*'
	$(MAKE) test-python docs
	$(MAKE) faults KILLS=12
	$(MAKE) smoke-browser
	$(MAKE) export-tools
	cargo test --workspace --locked --test export

PAGE := crates/hysteron-app/page
app: $(HYSTERON) ## the page in the browser, on the measured examples, in out/app
	$(HYSTERON) app $(OUT)/app --examples --open

page-tools:
	@command -v node >/dev/null || { echo "error: node is not installed"; \
	  echo "  try: your system's package, e.g. 'apt-get install nodejs npm' (20 or newer)"; exit 1; }
	@cmp -s $(PAGE)/package-lock.json $(PAGE)/node_modules/.installed || { \
	  cd $(PAGE) && npm ci --silent && cp package-lock.json node_modules/.installed; }

page: page-tools ## the page of `hysteron app`, from TypeScript into crates/hysteron-app/page/dist
	cd $(PAGE) && npm run --silent build

# A browser of the system; the driver downloads none.
CHROMIUM = $(shell command -v chromium || command -v chromium-browser || command -v google-chrome)
SCENARIOS := tests/*.test.mjs
browser-tools:
	@$(PAGE)/tests/install-tools.sh

test-browser: browser-tools ## the page in a real browser: newcomer, keyboard, accessibility, bad files, pictures in out/
	@test -n "$(CHROMIUM)" || { echo "error: no chromium is installed"; \
	  echo "  try: your system's package, e.g. 'apt-get install chromium'"; exit 1; }
	$(MAKE) page-tools
	cd $(PAGE) && npm run --silent check
	$(COMMAND)
	cd $(PAGE) && CHROMIUM=$(CHROMIUM) HYSTERON=$(abspath target/debug/hysteron) \
	  OUT=$(abspath $(OUT))/browser node --test --test-concurrency=1 $(SCENARIOS)

page-figure: browser-tools page-tools $(HYSTERON) ## the picture of the page in the README
	cd $(PAGE) && CHROMIUM=$(CHROMIUM) HYSTERON=$(abspath $(HYSTERON)) node tests/figure.mjs

smoke-browser: browser-tools
	@if test -z "$(CHROMIUM)" || ! command -v npm >/dev/null || ! $(MAKE) page-tools; then \
	  echo "skipped: the page in a browser (chromium, npm or its packages are missing)"; \
	else $(MAKE) test-browser SCENARIOS=tests/newcomer.test.mjs; fi

article: $(HYSTERON) ## reproduce the article on the simulated bench: tables, figures, page
	$(HYSTERON) article --out-dir $(OUT)/article
	@echo "page  $(abspath $(OUT)/article)/index.html"

bench: check-toolchain ## speed, side by side with the peers, which this installs into bench/.venv
	bench/instructions.sh
	bench/run.sh
	$(MAKE) bench-python

bench-python: python-tools ## what Python costs over the library
	VIRTUAL_ENV=$(abspath $(PYTHON)) $(PYTHON)/bin/maturin develop --release --locked --quiet
	$(PYTHON)/bin/python bench/python_overhead.py
	$(MAKE) $(HYSTERON)
	$(PYTHON)/bin/python bench/fleet.py $(HYSTERON)

STUDIES := optimum full-size seeds parameters rates blocks track coverage information afm bands design plays families levels stamps
study: ## what the joint identification promises, measured on simulated devices (QUICK=1: a rehearsal)
study: check-toolchain
	cargo build --release --locked -p hysteron-bench --bin hysteron-study
	@for study in $(STUDIES); do echo "== $$study"; target/release/hysteron-study $$study $(if $(QUICK),2); done

figures: $(HYSTERON) ## the pictures of README and docs, made by the program
	@mkdir -p $(OUT) docs/figures
	$(HYSTERON) identify $(RECORD) -o $(OUT)/model.json --figures $(OUT)/figures
	cp $(OUT)/figures/figure-*-hysteresis-loop-*.svg docs/figures/hysteresis-loop.svg
	cp $(OUT)/figures/figure-*-start-of-the-record-*.svg docs/figures/start-from-rest.svg
	$(HYSTERON) identify $(CYCLES) --continued --input u_V --output y_um -o $(OUT)/scanner.json \
	  --figures $(OUT)/scanner
	cp $(OUT)/scanner/figure-*-time-curves-cycle-1-300hz-03-csv.svg docs/figures/scanner.svg
	cargo run --release --locked -p hysteron-report --example families -- docs/figures
	cargo run --release --locked -p hysteron-report --example oscillator -- docs/figures/oscillator.svg
	cargo run --release --locked -p hysteron-report --example creep -- docs/figures/creep.svg

FORCE:

clean: ## remove build products and out/
	cargo clean
	rm -rf $(OUT) bench/.venv
