# Everything this project does, from a clone with nothing but Python 3.11+ and make. `make help` lists it.
PYTHON ?= python3
VENV   ?= .venv
RUN    := $(VENV)/bin/python
READY  := $(VENV)/.ready

.PHONY: help install test test-omc check learn clean
.DEFAULT_GOAL := help

help:  ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | sort

$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "railgrip needs Python 3.11 or newer; set PYTHON=/path/to/python3.11"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(RUN) -m pip install --quiet --upgrade "pip>=25.1"
	$(RUN) -m pip install --quiet --editable . --group dev
	@touch $@

install: $(READY)  ## make .venv with everything declared in pyproject.toml

test: check  ## lint, types and tests
	$(RUN) -m pytest

test-omc: $(READY)  ## compare the built-in compiler with OpenModelica, which must be on the PATH
	@command -v omc >/dev/null || { echo "test-omc needs OpenModelica's omc on the PATH"; exit 2; }
	$(RUN) -m pytest -m omc tests/fmus

check: $(READY)
	$(RUN) -m ruff check .
	$(RUN) -m ruff format --check .
	$(RUN) -m pyright

learn: $(READY)  ## friction from axle-box accelerations: 200 simulated runs, training, honest judgement (cached)
	$(RUN) -m harness learn

clean:  ## remove what was built (not .venv)
	rm -rf build
