# Everything a person does with this repository. `make` alone lists it.

PYTHON ?= python3
UV ?= uv
ARGS ?=
TESTS = not soak and not examples and not sweep

BIN := .venv/bin

# Stamps are named by content, not by date: the environment is rebuilt when the lock, this folder's
# place or the interpreter changes; the package is re-installed when its own settings change.
ENVIRONMENT := .venv/.environment-$(shell { pwd; $(PYTHON) -V; cat requirements.lock; } 2>&1 | cksum | cut -d' ' -f1)
PACKAGE := .venv/.package-$(shell cksum < pyproject.toml | cut -d' ' -f1)

.DEFAULT_GOAL := help
.PHONY: help setup run test check bench soak mutate docs examples lock clean

help: ## list these targets
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1|\2/p' $(MAKEFILE_LIST) | awk -F'|' '{printf "%-15s %s\n", $$1, $$2}'

setup: $(PACKAGE) ## create .venv from requirements.lock and install the package

run: $(PACKAGE) ## one automated suction cycle on the twin; options in ARGS="--protocol paper"
	@$(BIN)/opensuction cycle $(ARGS)

test: $(PACKAGE) ## all tests but sweeps and long ones, in two stages; choose some with ARGS="-k name"
	@$(BIN)/python -m tests.stage -m "$(TESTS)" $(ARGS)

check: $(PACKAGE) ## lint, format, types, layers of the architecture, hazards against tests, modules
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports --no-logo
	@$(BIN)/python -m tools.traceability

docs: $(PACKAGE) ## write anew what the documentation takes from the code, and build its site
	@$(BIN)/python -m docs.generator
	@$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet --builder html docs build/site
	@echo "The site: build/site/index.html"

examples: $(PACKAGE) ## run what README, tutorials, guides and notebooks show, and hold the site to its rules
	@$(BIN)/python -m tests.stage -m examples tests/docs $(ARGS)

bench: $(PACKAGE) ## speed of the core; ARGS=--benchmark-disable runs all of it once, without times
	@$(BIN)/python -m pytest benchmarks $(ARGS)

soak: $(PACKAGE) ## the long tests, and all mutants
	@OPENSUCTION_HYPOTHESIS=soak $(BIN)/python -m pytest -m "soak or sweep" $(ARGS)
	@$(BIN)/python -m tools.mutation --out mutation-score.json

mutate: $(PACKAGE) ## mistakes that no test notices; choose modules with ARGS="safety.condition"
	@$(BIN)/python -m tools.mutation --out mutation-score.json $(ARGS)

lock: ## pin every dependency anew; UPGRADE=1 takes newer versions
	@command -v $(UV) > /dev/null || { echo "make lock needs uv: pip install uv, or give its path as UV=..." >&2; exit 1; }
	@$(UV) pip compile pyproject.toml --extra dev --universal --python-version 3.11 --generate-hashes \
		--no-emit-index-url --no-emit-find-links --no-annotate --custom-compile-command "make lock" \
		$(if $(UPGRADE),--upgrade) --quiet --output-file requirements.lock

clean: ## remove the environment and every cache
	@rm -rf .venv build dist .benchmarks .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	@find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

$(ENVIRONMENT):
	@command -v $(PYTHON) > /dev/null || { echo "Python 3.11 or later is needed, and '$(PYTHON)' was not found; try make PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Python 3.11 or later is needed, '$(PYTHON)' is $$($(PYTHON) -V); try make PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2> /dev/null || { echo "Python's venv module is missing; install it, for example: apt-get install python3-venv" >&2; exit 1; }
	@echo "Creating .venv and installing the pinned dependencies (once, one to three minutes) ..."
	@$(PYTHON) -m venv --clear .venv
	@# Two halves at once: pip unpacks on one core. The lock names all that is needed.
	@awk '/^[^ #]/ { n++ } n { print > (".venv/requirements-" n % 2) }' requirements.lock
	@half() { $(BIN)/python -m pip install -qq --disable-pip-version-check --no-input --no-compile --no-deps --require-hashes -r .venv/requirements-$$1; }; \
		half 0 & other=$$!; trap "kill $$other" INT TERM; half 1; ended=$$?; wait $$other && exit $$ended
	@# Some packages bring files that are no Python of this version: nobody imports them.
	@$(BIN)/python -m compileall -qq -j 0 -x '/tests?/' .venv/lib || true
	@touch $@

$(PACKAGE): $(ENVIRONMENT)
	@echo "Installing opensuction into .venv ..."
	@$(BIN)/python -m pip install -qq --disable-pip-version-check --no-input --no-deps --no-build-isolation -e .
	@touch $@
