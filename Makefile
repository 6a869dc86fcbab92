# Needs only make and Python 3.11 or later; everything else goes into .venv.

PYTHON ?= python3
VENV := .venv
RUN := $(VENV)/bin
INSTALLED := $(VENV)/installed

.PHONY: help demo test oldest study schema clean

help:
	@echo "make demo     synthesise a film-like scene, find its shots, render their vibration drive"
	@echo "make test     style, types and tests"
	@echo "make oldest   the tests with the oldest libraries that pyproject.toml allows, in a folder of their own"
	@echo "make study    measure speed against accuracy; writes README.md's table and docs/pareto.svg anew"
	@echo "make schema   write docs/timeline.schema.json anew after a change of the timeline's types"
	@echo "make clean    remove .venv and build"
	@echo "PYTHON=...    another interpreter than python3, 3.11 or later"

demo: $(INSTALLED)
	$(RUN)/blastline synth fixtures/demo.toml -o build/demo --overwrite
	$(RUN)/blastline render build/demo/demo.wav -o build/demo/out --overwrite
	@echo
	@echo "Open build/demo/out/report.html; the drive is build/demo/out/drive.wav, the truth build/demo/demo.truth.json."

test: $(INSTALLED)
	$(RUN)/ruff check
	$(RUN)/ruff format --check
	$(RUN)/mypy
	$(RUN)/pytest -n auto --maxprocesses 4 --dist loadfile

oldest:
	$(PYTHON) -m venv --clear build/oldest
	sed -n '/^dependencies/,/^]/s/^ *"\(.*\)>=\(.*\)",$$/\1==\2/p' pyproject.toml > build/oldest.txt
	build/oldest/bin/python -m pip install -q --no-compile --disable-pip-version-check -e ".[dev]" -c build/oldest.txt
	build/oldest/bin/pytest -n auto --maxprocesses 4 --dist loadfile

# 1 says that a tier is not where it should be: a finding, and written down
study: $(INSTALLED)
	$(RUN)/python -m pip install -q --disable-pip-version-check -e ".[peers]" -c constraints.txt
	$(RUN)/blastline study pareto --fixtures fixtures --random 16 --peers -o build/study --overwrite || test $$? = 1
	$(RUN)/python benchmarks/readme.py build/study

schema: $(INSTALLED)
	$(RUN)/python -c "import json; from blastline.model import schema; print(json.dumps(schema(), indent=1))" > docs/timeline.schema.json

clean:
	rm -rf $(VENV) build

$(INSTALLED): pyproject.toml constraints.txt
	@$(PYTHON) -c "import sys; v = sys.version_info; v >= (3, 11) or sys.exit('blastline needs Python 3.11 or later, but $(PYTHON) is %d.%d; try: make PYTHON=python3.11 ...' % v[:2])"
	$(PYTHON) -m venv --clear $(VENV)
	@# not compiled: half of the time went into modules that nothing imports
	$(RUN)/python -m pip install -q --no-compile --disable-pip-version-check -e ".[dev]" -c constraints.txt
	@touch $@
