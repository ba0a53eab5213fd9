# Two commands do everything: `make demo` and `make test-all`. Both build inside .venv.
# Kept to what GNU make 3.81 and a BSD userland understand, so that macOS needs nothing extra.

JOBS ?= 2
RESULTS ?= results
PARTS ?= lab kernels limit scaling rubber_rod
QUICK ?=
FUZZ_SECONDS ?= 300
FUZZ_HARNESS ?= scenes api solvers robots files stores endings pages
FUZZ_SEED ?=
FUZZ_FILES ?=

VENV := .venv
BIN := $(VENV)/bin
LAB_SCENES := $(sort $(wildcard scenes/lab-*.toml))
MATURIN = $(BIN)/maturin develop --locked
COMPILE := uv pip compile --quiet --universal --python-version 3.11 --upgrade --generate-hashes \
	--no-emit-index-url --no-emit-find-links --no-annotate
WITH_LISSOM := --extra all pyproject.toml

# The tools must act on .venv whatever environment the caller has activated.
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python
export CARGO_BUILD_JOBS := $(JOBS)
export PIP_DISABLE_PIP_VERSION_CHECK := 1
unexport CONDA_PREFIX
unexport PYTHONPATH
unexport PYTHONHOME

.PHONY: help demo bench peers validate stress test test-all test-rust test-python test-browser test-torch test-checked test-oldest test-msrv \
	build build-for-test develop wheel sdist crate sbom docs docs-check links pictures format lock fuzz audit clean \
	measure-house freeze frozen
.DEFAULT_GOAL := help

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1|\2/p' $(firstword $(MAKEFILE_LIST)) | column -t -s '|'

demo: build ## simulate the lab scenes and say where the reports lie
	@set -e; for scene in $(LAB_SCENES); do \
		$(BIN)/lissom run "$$scene" -o "$(RESULTS)/$$(basename "$$scene" .toml)"; \
	done
	@echo; echo "Open in a browser:"
	@find "$(RESULTS)" -name '*.html' | sort | sed 's|^|  |'

# What guards the physics every day. Left to `test-all`: tests marked `slow`, counted instructions, documentation, the crate without Python.
test: build $(VENV)/test.stamp ## the checks and tests that do not take long
	@.ci/toolchain cargo-checks
	cargo fmt --all --check
	cargo clippy --locked --all-targets --features python -- -D warnings
	cargo test --locked
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy --strict
	$(BIN)/python -m pytest -n $(JOBS) -m "not slow"

test-all: test-rust test-python ## run every check and every test; what continuous integration runs

test-rust: $(VENV)/test.stamp ## formatting, lints, documentation and tests of the Rust crate
	@.ci/toolchain cargo
	@.ci/toolchain cargo-checks
	cargo fmt --all --check
	cargo clippy --locked --all-targets --features python -- -D warnings
	cargo clippy --locked --lib -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps
	cargo test --locked
	$(BIN)/python benches/python/instructions.py

test-python: build-for-test ## formatting, types and tests of the Python package
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy --strict
	$(BIN)/python -m mypy.stubtest lissom._lissom --allowlist tests/python/stubtest-allowlist.txt
	$(BIN)/python -m pytest -n $(JOBS)

test-browser: docs $(VENV)/browser.stamp ## reports and the site in headless Chromium (LISSOM_CHROMIUM=path, or playwright's own)
	@test -n "$(LISSOM_CHROMIUM)" || $(BIN)/python -m playwright install chromium
	$(BIN)/python -m pytest tests/browser -o addopts= --timeout 300

test-torch: build-for-test ## with PyTorch, Stable-Baselines3 and OpenUSD, which are large and are installed first (needs the network)
	$(BIN)/python -m pip install --quiet 'torch>=2.6' 'stable-baselines3>=2.6' 'usd-core>=25.2'
	$(BIN)/python -m pytest tests/torch tests/python/drawing/test_usd.py

test-checked: $(VENV)/test.stamp ## the Python tests with debug assertions and overflow checks (slow)
	@.ci/toolchain cargo
	$(BIN)/maturin develop --profile checked --locked
	$(BIN)/python -m pytest -n $(JOBS); status=$$?; $(MAKE) build-for-test; exit $$status

# Those of the tests that take a minute and touch every extra. What old packages use of newer ones is deprecated there: no fault of ours.
OLDEST_TESTS ?= package arrays pickle scene rod rod_input sections roots views modes cli_tools report gym
test-oldest: $(VENV)/test.stamp ## some tests with the oldest Python packages that are allowed (needs uv)
	@.ci/toolchain cargo
	rm -rf target/oldest
	$(BIN)/maturin build --release --locked --out target/oldest
	uv pip compile --quiet --resolution lowest-direct --python-version 3.11 --no-emit-index-url --no-emit-find-links \
		--extra all pyproject.toml --group examples --output-file target/oldest/requirements.txt
	uv venv --quiet --python 3.11 target/oldest/venv
	uv pip install --quiet --python target/oldest/venv --requirement target/oldest/requirements.txt \
		pytest pytest-timeout pytest-xdist hypothesis pyyaml control
	uv pip install --quiet --python target/oldest/venv --no-deps target/oldest/*.whl
	uv pip list --python target/oldest/venv
	target/oldest/venv/bin/python -m pytest -n $(JOBS) -W ignore::DeprecationWarning $(OLDEST_TESTS:%=tests/python/*/test_%.py)

RUST_VERSION = $(shell sed -n 's/^rust-version = "\([0-9.]*\)".*/\1/p' Cargo.toml)
test-msrv: $(VENV)/demo.stamp ## compile everything with the oldest Rust that Cargo.toml allows (rustup toolchain install it)
	CARGO_TARGET_DIR=target/msrv cargo +$(RUST_VERSION) check --locked --all-targets --features python

bench: build-for-test ## measure, and write docs/benchmarks.md (PARTS="lab kernels", QUICK=1)
	$(BIN)/python benches/python/speed/suite.py --parts $(PARTS) $(if $(QUICK),--quick)

peers: build-for-test ## compare robots with Pinocchio, MuJoCo and SoRoMoX, and write docs/peers.md (QUICK=1)
	$(BIN)/python benches/python/peers/robot_peers.py $(if $(QUICK),--quick)

validate: build ## ask questions with known answers, and write docs/validation.md
	$(BIN)/lissom validate -o "$(RESULTS)/validation" --update-docs docs/validation.md

stress: build ## try hard cases, and compare with the committed table (QUICK=1)
	$(BIN)/lissom stress -o $(RESULTS)/stress $(if $(QUICK),--quick)

measure-house: $(VENV)/test.stamp ## sizes of the source: lines, methods of traits, large files, circles
	$(BIN)/python benches/python/house.py

freeze: build-for-test ## record what lissom computes, before code is moved (results/freeze)
	$(BIN)/python tests/python/freeze.py record $(RESULTS)/freeze

frozen: build-for-test ## compare with what `make freeze` has recorded
	$(BIN)/python tests/python/freeze.py compare $(RESULTS)/freeze

fuzz: build-for-test ## try random input (FUZZ_SECONDS=300, FUZZ_SEED=1, FUZZ_HARNESS="files pages", FUZZ_FILES=...)
	PYTHONPATH=tests/python $(BIN)/python -m fuzz $(if $(FUZZ_FILES),$(FUZZ_FILES),--seconds $(FUZZ_SECONDS) --jobs $(JOBS) \
		--harness $(FUZZ_HARNESS) $(if $(FUZZ_SEED),--seed $(FUZZ_SEED)) --findings $(RESULTS)/fuzz)

build: $(VENV)/demo.stamp ## build the package into .venv
	@.ci/toolchain cargo
	$(MATURIN) --release

build-for-test: $(VENV)/test.stamp
	@.ci/toolchain cargo
	$(MATURIN) --release

develop: $(VENV)/test.stamp ## build again after a change: in seconds where it is outside src/core, but not for timings
	@.ci/toolchain cargo
	$(MATURIN) --profile quick

wheel: $(VENV)/demo.stamp ## build a wheel for this system into dist/, and try it in a fresh environment
	@.ci/toolchain cargo
	rm -f dist/*.whl
	$(BIN)/maturin build --locked --release --features portable --strip --compression-level 9 --out dist
	$(BIN)/python -m pip install --quiet --require-hashes --requirement requirements/wheel.txt
	$(BIN)/python .ci/squeeze-wheel dist/*.whl
	.ci/try-wheel dist/*.whl

sdist: $(VENV)/demo.stamp ## pack the sources into dist/, and try to install from them
	rm -f dist/*.tar.gz
	$(BIN)/maturin sdist --out dist
	.ci/try-wheel dist/*.tar.gz

crate: ## pack the crates as `cargo publish` does, and compile them from that (Rust 1.90 or newer)
	@.ci/toolchain cargo
	cargo package --locked --workspace --exclude lissom-extension

sbom: ## write the bill of materials of the wheel, dist/lissom.cdx.json (needs cargo-cyclonedx)
	mkdir -p dist
	cargo cyclonedx --quiet --format json --manifest-path src/extension/Cargo.toml --override-filename lissom.cdx
	sed 's|path+file://$(CURDIR)#||g' src/extension/lissom.cdx.json > dist/lissom.cdx.json
	rm -f lissom.cdx.json derive/lissom.cdx.json src/*/lissom.cdx.json

docs: build $(VENV)/docs.stamp ## build the site into results/site
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going -b html docs "$(RESULTS)/site"
	@echo "Open in a browser: $(RESULTS)/site/index.html"

docs-check: docs ## the site, the links within it and its examples
	$(BIN)/python docs/extensions/local_links.py "$(RESULTS)/site"
	$(BIN)/python -m pytest --quiet tests/python/project/test_docs.py tests/python/project/test_site.py

links: build $(VENV)/docs.stamp ## links from the site to the outside (needs the network)
	$(BIN)/sphinx-build --quiet -b linkcheck docs "$(RESULTS)/links"

pictures: build $(VENV)/docs.stamp ## draw the pictures of the README and the site, and write docs/gallery.md
	$(BIN)/python docs/pictures/moving.py
	$(BIN)/python docs/pictures/gallery.py
	$(BIN)/python docs/pictures/films.py

format: $(VENV)/test.stamp ## format all sources
	cargo fmt --all
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

lock: ## choose the newest versions for requirements/*.txt, with hashes (needs uv)
	UV_CUSTOM_COMPILE_COMMAND="make lock" $(COMPILE) $(WITH_LISSOM) --group build --output-file requirements/demo.txt
	UV_CUSTOM_COMPILE_COMMAND="make lock" $(COMPILE) $(WITH_LISSOM) --group test --output-file requirements/test.txt
	UV_CUSTOM_COMPILE_COMMAND="make lock" $(COMPILE) $(WITH_LISSOM) --group browser --output-file requirements/browser.txt
	UV_CUSTOM_COMPILE_COMMAND="make lock" $(COMPILE) $(WITH_LISSOM) --group docs --output-file requirements/docs.txt
	UV_CUSTOM_COMPILE_COMMAND="make lock" $(COMPILE) --group peers --output-file requirements/peers.txt

audit: ## licences, sources and known weaknesses of the crates (needs cargo-deny)
	cargo deny --locked check

clean: ## remove .venv, build products and results
	rm -rf $(VENV) target dist $(RESULTS) python/lissom/*.so

$(VENV)/%.stamp: requirements/%.txt pyproject.toml
	@.ci/toolchain cargo
	@test -x $(BIN)/python || { python=$$(.ci/toolchain python) && "$$python" -m venv $(VENV); }
	$(BIN)/python -m pip install --quiet --require-hashes --requirement $<
	@touch $@
