# `make plan`: plan case 3 of the paper, write it to out/ and play it back. `make test`: everything CI runs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.DELETE_ON_ERROR:
.PHONY: plan test lint generate figures picture benchmark sanitize clean

plan: $(VENV)/plan-installed
	$(BIN)/python scripts/plan.py --case 3 --out out/case3

test: $(VENV)/test-installed lint
	$(BIN)/python -m pytest

lint: $(VENV)/test-installed
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

generate: $(VENV)/plan-installed
	$(BIN)/python scripts/generate.py

figures: $(VENV)/test-installed
	$(BIN)/python scripts/reproduce.py --out out/paper --readme README.md
	cp out/paper/sweep_activation_distance.png docs/activation_distance.png

picture: $(VENV)/test-installed
	$(BIN)/python scripts/screenshot.py docs/case3.png

$(VENV)/pyvenv.cfg:
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; sys.exit(None if (3, 11) <= v <= (3, 13) else \
		f"error: {sys.executable} is Python {v[0]}.{v[1]}; humanoid_rail needs 3.11 to 3.13: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

# Builds the native engine, which takes a minute or two.
$(VENV)/plan-installed: $(VENV)/pyvenv.cfg pyproject.toml CMakeLists.txt $(wildcard engine/*)
	$(BIN)/python -m pip install --quiet --editable . $(BUILD)
	touch $@

# What is installed already stays as it is: this adds what the extra needs.
$(VENV)/test-installed: $(VENV)/plan-installed
	$(BIN)/python -m pip install --quiet 'humanoid_rail[dev]'
	touch $@

clean:
	rm -rf $(VENV) out
