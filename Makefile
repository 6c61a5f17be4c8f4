# Two commands on a fresh machine with Python (>= 3.11) and make; each sets up its own .venv.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test check format benchmarks clean

demo: .venv/.installed  ## recognize synthetic people, write report/report.html
	$(BIN)/harmonicface bench --faces 100 --size 64 --seed 0 --out report

# One worker a core, each with one thread of linear algebra: threads that wait for each other cost more than they give.
test: check  ## lint, types, floors, doctests, tests
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n auto

check: .venv/.installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: .venv/.installed-dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# Within 20 minutes on two cores; benchmarks/results/index.html holds all plots and tables.
benchmarks: .venv/.installed-dev  ## speed against error, beside public peers
	$(BIN)/python scripts/run_benchmarks.py

.venv/bin/python:
	$(PYTHON) -m venv .venv

.venv/.installed: .venv/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	touch $@

.venv/.installed-dev: .venv/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]"
	touch $@ .venv/.installed

clean:
	rm -rf .venv report benchmarks/results
