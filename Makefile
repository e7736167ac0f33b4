# Everything this project does, from a clone with nothing but Python 3.11+ and make. `make help` lists it.
PYTHON ?= python3
VENV   ?= .venv
RUN    := $(VENV)/bin/python
READY  := $(VENV)/.ready

.PHONY: help install test test-omc check estimate tune clean
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

estimate: $(READY)  ## adhesion and pad friction from recordings: the papers' figures and tables, build/estimate
	$(RUN) -m harness rig
	$(RUN) -m harness observability harness/estimate/library/rig_own.toml
	$(RUN) -m harness observability harness/estimate/library/wagon.toml
	$(RUN) -m harness estimate harness/estimate/library/wagon.toml
	$(RUN) -m harness field

tune: $(READY)  ## find the noises of the field test's filter anew, minutes; harness/field/library
	$(RUN) -m harness tune paper --out harness/field/library/paper.toml
	$(RUN) -m harness tune consistent --out harness/field/library/consistent.toml

clean:  ## remove what was built (not .venv)
	rm -rf build
