# Everything this project does, from a clone with nothing but Python 3.11+ and make. `make help` lists it.
# tests/cli/test_every_command.py runs each target in its smallest form.
PYTHON ?= python3
# The file by which make knows an environment that it made, so that it never changes one of the user.
MADE   := .made-by-make
made_by_make = $(wildcard $(1)/$(MADE) $(1)/.ready)
ifndef VENV
VENV   := $(if $(wildcard .venv),$(if $(call made_by_make,.venv),.venv,.venv-dev),.venv)
endif
ifneq ($(words $(VENV)),1)
$(error VENV='$(VENV)': make takes no path with blanks; name a folder without them, relative to this one)
endif
BIN    := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
RUN    := $(BIN)/python
# Not `python -m`, which imports what lies in the current folder.
PROGRAM := $(BIN)/railgrip
READY  := $(VENV)/.ready
DEV    := $(VENV)/.ready-dev

# The compiler in the wheel ziglang, 0.4 GB, if neither the words of CC nor cc, gcc and clang are programs.
EXTRA   = $(shell for name in $$CC cc gcc clang; do command -v "$$name" >/dev/null 2>&1 && exit; done; echo '[compiler]')

.PHONY: help typed strict-types rest install fmus simulate searched shapes unseen adverse report conditioning conditioning-omc discretisation convergence headlines validation regress regress-long accept calibrate \
        tune-control type-test bench target mutants test test-all suite floors kept portable test-omc regress-omc suites fuzz check estimate tune lateral learn monitor k-factors trains docs clean
.DEFAULT_GOAL := help

help:  ## list the targets
	@grep -E '^[a-z0-9-]+:.*##' $(firstword $(MAKEFILE_LIST)) | sed -E 's/:.*## /\t/' | sort
	@echo "OPTIONS='…' passes options to the commands of a target, as in make bench OPTIONS=--quick and"
	@echo "make searched OPTIONS='--only controller=full_brake'; TESTS='…' chooses tests, BASELINES=… a folder of baselines."

# Assigned here so that variables of the shell with these names have no effect.
BASELINES := tests/baselines
OPTIONS   :=
TESTS     :=
TYPES     :=
REASON    :=
SUITE     :=
KIND      :=

# What is imported first writes its bytecode, whatever the shell says: without it every process compiles for five seconds.
unexport PYTHONDONTWRITEBYTECODE

# Without --no-compile pip spends longer on bytecode, most of which is never imported, than on everything else.
$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "railgrip needs Python 3.11 or newer; set PYTHON=/path/to/python3.11"; exit 2; }
	@test -n "$(call made_by_make,$(VENV))" || test -z "$$(ls -A $(VENV) 2>/dev/null)" || { \
	  echo "$(VENV): make did not create this environment and does not install into it; set VENV to a new folder"; exit 2; }
	@test $(VENV) != .venv-dev || echo "make leaves .venv, which it did not create, as it is and uses .venv-dev"
	@mkdir -p $(VENV) && touch $(VENV)/$(MADE)
	$(PYTHON) -m venv $(VENV)
	$(RUN) -m pip install --quiet --no-compile --editable '.$(EXTRA)'
	@touch $@

# What only developing needs takes as long to install again, so whoever just simulates does without.
$(DEV): $(READY)
	$(RUN) -m pip install --quiet --no-compile --upgrade "pip>=25.1"
	$(RUN) -m pip install --quiet --no-compile --group dev
	$(RUN) -m pip install --quiet --no-compile --target $(VENV)/cluster --upgrade --group cluster
	@touch $@

install: $(DEV)  ## make .venv, or .venv-dev if .venv is yours, with everything declared in pyproject.toml

fmus: $(READY)  ## build the FMUs that are not up to date
	$(PROGRAM) build

# FMUs are built while stops that do not need them run: a stop waits for an FMU that another process builds.
TABLE1    := $(PROGRAM) campaign harness/scenario/campaigns/table1.toml --panels none
PUBLISHED := --only controller=full_brake,slip_two_state,slip_three_state,slip_three_state_read,adhesion_literal,adhesion_based,slope_seeking,ideal_bound

simulate: $(READY)  ## braking distances next to the published ones, build/table1/index.html
	@mkdir -p build/table1 && cp docs/stop.html build/table1
	@$(PROGRAM) build --quiet TwoPartTrain TrainPrediction TwoPartTrainPneumatic & $(TABLE1) $(PUBLISHED) $(OPTIONS); code=$$?; wait; exit $$code
	@echo "More: \`make searched\` adds further slip-based control with searched thresholds, \`make shapes\` has other"
	@echo "creep curves, \`make report\` adds the signals of every stop."

searched: $(READY)  ## the same with all slip-based control with searched thresholds, build/table1
	$(TABLE1) $(OPTIONS)

shapes: $(READY)  ## the controllers of the published table on other creep curves, build/shapes
	$(PROGRAM) campaign harness/scenario/campaigns/shapes.toml $(OPTIONS)

unseen: fmus  ## controllers on a hundred draws of a rail and others they were not tuned on, build/unseen (minutes)
	$(PROGRAM) campaign harness/scenario/campaigns/unseen.toml $(OPTIONS)

adverse: fmus  ## controllers under creep curves, sensors and trains that do not suit them, build/adverse
	$(PROGRAM) campaign harness/scenario/campaigns/adverse.toml $(OPTIONS)

report: searched shapes  ## both with a page of the signals of every stop (minutes)
	$(PROGRAM) report build/table1
	$(PROGRAM) report build/shapes

conditioning: fmus  ## repeat the stops of the table with the plant's parameters moved by 1e-7, shown beside distances (minutes)
	$(RUN) tools conditioning harness/scenario/campaigns/table1.toml $(OPTIONS)
	$(RUN) tools conditioning harness/scenario/campaigns/shapes.toml --repeats 8 --stops '*-adhesion_literal' $(OPTIONS)

conditioning-omc: $(READY)  ## add distances with FMUs of OpenModelica, which must be on the PATH, for docs/validation.md (an hour)
	@command -v omc >/dev/null || { echo "conditioning-omc needs OpenModelica's omc on the PATH"; exit 2; }
	$(RUN) tools conditioning harness/scenario/campaigns/table1.toml --repeats 3 $(OPTIONS)
	$(RUN) tools conditioning harness/scenario/campaigns/table1.toml --repeats 8 --stops '*-adhesion_literal' $(OPTIONS)
	$(RUN) tools conditioning harness/scenario/campaigns/adverse.toml --repeats 3 $(OPTIONS)
	$(RUN) tools conditioning $(CONVERGENCE).toml $(NUDGED) --stops '*-detailed-*' $(OPTIONS)
	$(RUN) tools conditioning $(CONVERGENCE)_trains.toml $(NUDGED) --stops '*-detailed-*' $(OPTIONS)

discretisation: fmus  ## repeat the stops of the table with smaller communication steps (hours)
	$(RUN) tools discretisation harness/scenario/campaigns/table1.toml --only steps $(OPTIONS)

CONVERGENCE := harness/scenario/campaigns/convergence
NUDGED      := --repeats 10 --relative 1e-5 --lots 0
TOLERANCES  := --repeats 8 --only tolerances

# Parameters move by as much as the tolerance of the recipe, so that ranges include what errors of that size do to a stop.
convergence: $(READY)  ## stops with both mechanics at four tolerances of the solver, for docs/validation.md (hours)
	$(RUN) tools conditioning $(CONVERGENCE).toml $(NUDGED) $(OPTIONS)
	$(RUN) tools conditioning $(CONVERGENCE)_trains.toml $(NUDGED) $(OPTIONS)
	$(RUN) tools discretisation $(CONVERGENCE).toml $(TOLERANCES) $(OPTIONS)
	$(RUN) tools discretisation $(CONVERGENCE)_trains.toml $(TOLERANCES) $(OPTIONS)
	$(RUN) tools validation

headlines: conditioning discretisation  ## all numbers of the table anew, into baselines and docs: make headlines REASON='…'
	-$(PROGRAM) maintain regress --baselines $(BASELINES) --import-from docs/studies
	$(PROGRAM) maintain accept --baselines $(BASELINES) --reason '$(REASON)'
	$(RUN) tools validation

validation: $(READY)  ## write the accepted braking distances into docs/validation.md
	$(RUN) tools validation $(OPTIONS)

regress: fmus  ## compare braking distances and headline figures with tests/baselines
	$(PROGRAM) maintain regress --baselines $(BASELINES) --import-from docs/studies

regress-long: BASELINES := tests/baselines/long
regress-long: $(READY)  ## the same for a train whose FMU takes minutes to build
	$(PROGRAM) maintain regress --baselines $(BASELINES) --out build/regress-long

mutants: $(DEV) fmus  ## count the small defects that the regression notices, docs/regression.md (half an hour)
	$(RUN) tools mutants --first --write $(OPTIONS)

accept: $(READY)  ## move the baselines to the last regress: make accept REASON='why the new distances are right'
	$(PROGRAM) maintain accept --baselines $(BASELINES) --reason '$(REASON)'

calibrate: fmus  ## fit the levels of the scenarios to the published distances of slip-based control (minutes)
	$(RUN) tools calibrate $(OPTIONS)

tune-control: fmus  ## search the parameters of slip- and adhesion-based control on rails kept for that (an hour)
	$(PROGRAM) maintain tune-control $(OPTIONS)

type-test: fmus  ## all controllers in hundreds of cases that none was tuned on, build/type_test (an hour)
	$(PROGRAM) study type_test $(OPTIONS)

trains: $(READY)  ## trains of this project against published stops, UIC 540 and a trial of sanders, docs/studies/trains.md
	$(RUN) tools pages trains $(OPTIONS)

bench: fmus  ## speed, as medians and ratios in one run
	$(PROGRAM) study bench $(OPTIONS)

target: $(READY)  ## the onboard part on a Cortex-M7 in QEMU: memory, instructions, outputs, docs/how_to/real_time_target.md (minutes)
	$(RUN) tools target $(OPTIONS)

# The tests fill two cores, but for their end; types and distances, in one process each, fill what is left of them.
test: $(DEV)  ## lint, types, the tests that decide, and distances and figures against the accepted ones; prints its processor time
	@$(RUN) tests/processor_time.py $(MAKE) --no-print-directory --jobs 2 suite kept

kept: check fmus
	$(PROGRAM) maintain regress --workers 1 --baselines $(BASELINES) --import-from docs/studies

# A file stays in one process: its tests share what they have built and run. tests/conftest.py has the longest first.
XDIST := --numprocesses 2 --dist loadfile --no-loadscope-reorder

suite: $(DEV) fmus
	$(RUN) -m pytest $(XDIST) $(if $(TESTS),,--floor deciding) $(TESTS)

test-all: $(DEV)  ## strict types, and the tests that `make test` leaves out, since others run the same lines and branches
	@$(RUN) tests/processor_time.py $(MAKE) --no-print-directory --jobs 2 rest strict-types

rest: $(DEV) fmus
	$(RUN) -m pytest $(XDIST) --floor rest $(TESTS)

floors: $(DEV)  ## measure what each test runs, and choose those that decide, tests/left_out.toml (an hour)
	$(RUN) tools floors $(OPTIONS) $(TESTS)

PORTABLE := tests/test_portability.py tests/test_containers.py tests/test_units.py tests/scenario tests/docs/test_code_blocks.py \
            tests/estimate/test_text_formats.py tests/estimate/test_inspection.py tests/estimate/test_specification.py \
            tests/fmus/test_platforms.py tests/fmus/test_under_wine.py

portable: TESTS = $(PORTABLE)
portable: $(DEV)  ## what may depend on the platform: installation, compiler, files, a stop, the tutorials
	$(PROGRAM) doctor
	$(PROGRAM) run trapezoid --out build/portable
	RAILGRIP_LINK_WINDOWS=1 $(RUN) -m pytest $(TESTS)

test-omc: TESTS := tests/fmus tests/stops tests/test_suites.py
test-omc: $(DEV)  ## compare the built-in compiler with OpenModelica, which must be on the PATH
	@command -v omc >/dev/null || { echo "test-omc needs OpenModelica's omc on the PATH"; exit 2; }
	$(RUN) -m pytest --numprocesses 2 --dist worksteal -m omc $(TESTS)

# What else its stops and figures rest on is built when it is asked for.
regress-omc: $(DEV)  ## compare braking distances with OpenModelica's FMUs with tests/baselines, to 0.5 %
	@command -v omc >/dev/null || { echo "regress-omc needs OpenModelica's omc on the PATH"; exit 2; }
	$(PROGRAM) maintain regress --across-compilers --baselines $(BASELINES) --out build/regress-omc

monitor: $(READY)  ## simulate lives of brakes; print how early and how rarely the monitor alarms (10 min)
	$(PROGRAM) study pad_monitor $(OPTIONS)

fuzz: TESTS = $$(grep -lrE 'RAILGRIP_FUZZ|^from (sampling|hypothesis)' --include='test_*.py' tests)
fuzz: $(DEV)  ## wrong questions by the thousand, and all cases of which the tests run a sample (an hour)
	RAILGRIP_FUZZ=1000 $(RUN) -m pytest $(TESTS)

suites: $(DEV)  ## run a copy of a Modelica test suite: make suites SUITE=/path KIND=compliance|omc|reference [OPTIONS=…]
	@test -n "$(SUITE)" || { echo "suites needs SUITE=/path of a copy of the suite, and KIND=compliance, omc or reference"; exit 2; }
	$(RUN) tools suites $(KIND) $(SUITE) $(OPTIONS)

TYPED := build/typed/railgrip

typed:
	@rm -rf $(TYPED) && mkdir -p $(TYPED) && cp -r harness/* estimators controllers fmus $(TYPED)

check: $(DEV) typed
	$(RUN) -m ruff check .
	$(RUN) -m ruff format --check .
	$(RUN) -m pyrefly check --python-interpreter-path $(RUN)
	PYTHONPATH=build/typed $(BIN)/lint-imports --no-logo --no-cache

strict-types: $(DEV) typed
	$(RUN) -m pyright --pythonpath $(RUN) $(TYPES)

ESTIMATIONS := harness/estimation/library

estimate: $(READY)  ## adhesion and pad friction from recordings: the papers' figures and tables, docs/studies, build/estimate
	$(RUN) tools pages roller_rig field_test $(OPTIONS)
	$(PROGRAM) observability $(ESTIMATIONS)/rig_own.toml
	$(PROGRAM) observability $(ESTIMATIONS)/wagon.toml
	$(PROGRAM) estimate $(ESTIMATIONS)/wagon.toml
	$(PROGRAM) estimate $(ESTIMATIONS)/wagon.toml --set name=wagon-relaxing --set model.parameters.mu_b_relaxes=1
	$(PROGRAM) estimate $(ESTIMATIONS)/wagon.toml --set name=wagon-as-printed \
	  --set model.parameters.adhesion_share=0.5 --set model.parameters.resistance_transfer=1 \
	  --set model.parameters.adhesion_transfer=0
	$(PROGRAM) observability $(ESTIMATIONS)/field.toml
	$(PROGRAM) estimate $(ESTIMATIONS)/field.toml

tune: $(READY)  ## find the noises of the field test's filter anew, minutes; harness/estimation/field_test/library
	$(RUN) tools tune paper --out harness/estimation/field_test/library/paper.toml $(OPTIONS)
	$(RUN) tools tune consistent --out harness/estimation/field_test/library/consistent.toml $(OPTIONS)

lateral: $(READY)  ## estimate friction of a wandering wheelset with three filters, docs/studies/lateral.md
	$(RUN) tools pages lateral $(OPTIONS)

learn: $(READY)  ## friction from axle-box accelerations, docs/studies/axle_box.md; trained estimators, build/axle_box
	$(RUN) tools pages axle_box $(OPTIONS)
	$(RUN) docs/studies/axle_box_runs.py $(OPTIONS)

k-factors: fmus  ## K_dry_rst of ETCS for EBCL 0 to 9, and stops with the controller beside it, build/k_factors (minutes)
	$(PROGRAM) study k_factors vt642 --loop $(OPTIONS)

# Both notices concern later releases of the tools, whose bounds are in pyproject.toml.
docs: $(DEV)  ## the documentation as a site, build/site/index.html
	$(RUN) tools pages
	NO_MKDOCS_2_WARNING=1 DISABLE_MKDOCS_2_WARNING=true $(RUN) -m mkdocs build --strict $(OPTIONS)

clean:  ## remove what was built, except environments
	rm -rf build
