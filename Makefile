# `make plan`: plan a kitting round and case 3 of the paper, and play the round back. `make test`: everything CI runs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ENGINE := $(wildcard engine/*.[hc]pp engine/*/*.[hc]pp)

.DELETE_ON_ERROR:
.PHONY: plan test lint docs docs-serve generate figures picture benchmark evaluation motions regression retiming \
	least-time passing certificates holding distances filter carries stages views urdfs meshes robots gallery sanitize clean

plan: $(VENV)/plan-installed
	@echo "A kitting round, several targets one after the other, retimed for a drive:"
	$(BIN)/python scripts/plan.py scenes/picks.yaml --retime --out out/picks --no-view
	@echo "Case 3 of the paper by the paper's own law, which neither prevents collisions nor knows limits:"
	$(BIN)/python scripts/plan.py --case 3 --out out/case3 --no-view
	@if [ -t 1 ] && { [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ] || [ "$$(uname)" = Darwin ]; }; then \
		$(BIN)/humanoid-rail play out/picks; \
	else \
		echo "To see them, open out/picks/playback.html and out/case3/playback.html in a browser."; \
	fi

test: $(VENV)/test-installed lint
	$(BIN)/python -m pytest

lint: $(VENV)/test-installed
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/clang-format --dry-run --Werror $(ENGINE)

# The documentation as a site, site/index.html.
docs: $(VENV)/test-installed
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

docs-serve: $(VENV)/test-installed
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs serve

generate: $(VENV)/plan-installed
	$(BIN)/python scripts/generate.py

figures: $(VENV)/test-installed
	$(BIN)/python scripts/reproduce.py --out out/paper --readme docs/paper.md
	cp out/paper/sweep_activation_distance.png docs/activation_distance.png

picture: $(VENV)/test-installed
	$(BIN)/python scripts/pictures.py --out docs/pictures

# How much of the robot obstacles hide from the camera of the playback page: half a minute.
views: $(VENV)/test-installed
	$(BIN)/python -m validation.check_views scenes/dev --readme docs/page.md

benchmark: $(VENV)/test-installed
	$(BIN)/python -m benchmarks.engine_report --json out/benchmark.json --ratios docs/benchmarks.md --times docs/engine.md \
		--following docs/follow.md

# All methods on the planning scenes, including those of others: about a quarter of an hour, nearly all of it Pink's.
evaluation: $(VENV)/test-installed
	$(BIN)/python -m benchmarks.evaluate scenes/dev --method auto --method qp --method gradient-projection --method pink \
		--method 'ik + rrt-connect' --json out/evaluation.json --figure out/evaluation.png \
		--table docs/benchmarks.md --results README.md
	cp out/evaluation.png docs/evaluation.png

# Motions by this checkout, by another in which `make plan` was run (BASE=its folder), by roboplan and by Drake: minutes.
motions: $(VENV)/test-installed
	$(BIN)/python -m benchmarks.compare_motions scenes/dev --base $(BASE) --json out/motions.json --table docs/benchmarks.md

# Planning times and results compared with those of another checkout in which `make plan` was run: BASE=its folder.
regression: $(VENV)/test-installed
	$(BIN)/python -m benchmarks.against $(BASE)

least-time: $(VENV)/test-installed
	$(BIN)/python -m benchmarks.least_time scenes/dev --readme docs/least_time.md

# Motions that pass targets without stopping, beside those that stop: about two minutes.
passing: $(VENV)/test-installed
	$(BIN)/python -m benchmarks.passing scenes/dev --readme docs/least_time.md

retiming: $(VENV)/test-installed
	$(BIN)/python -m benchmarks.retiming scenes/dev --figure docs/timing.png --readme docs/retime.md
	$(BIN)/python -m benchmarks.tracking scenes/dev --readme docs/export.md

# Certificates of 10,000 random motions against an independent check: about a quarter of an hour on two cores.
certificates: $(VENV)/test-installed
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m validation.check_certificates --json out/certificates.json --readme docs/safety.md

# Certificates of 2,000 random motions that carry objects against an independent check: minutes on two cores.
holding: $(VENV)/test-installed
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m validation.check_holding --json out/holding.json --readme docs/safety.md

# What the margin of proofs is made of: random pairs of bodies, half a minute.
distances: $(VENV)/test-installed
	$(BIN)/python -m validation.check_distances --readme docs/safety.md

# Where the time of plans goes, half a minute.
stages: $(VENV)/test-installed
	$(BIN)/python -m benchmarks.stages scenes/dev --readme docs/auto.md

# The sampled filter of edges against the proof: two minutes.
filter: $(VENV)/test-installed
	$(BIN)/python -m validation.check_filter --readme docs/auto.md

# Level trays through an aisle, measured between samples: half a minute.
carries: $(VENV)/test-installed
	$(BIN)/python -m validation.check_carries --readme docs/constraints.md

# 10,000 random URDFs, most of them spoiled: each loads whole or is refused by name. A minute or two.
urdfs: $(VENV)/test-installed
	$(BIN)/python -m validation.check_urdfs

# The convex pieces of 100 random meshes in files of all formats against formulas of their parts: minutes on two cores.
meshes: $(VENV)/test-installed
	$(BIN)/python -m validation.check_meshes

# The robots of the gallery against their own URDFs and meshes: minutes on two cores.
robots: $(VENV)/test-installed
	$(BIN)/python -m validation.check_robots --readme docs/robots.md

# The table and the pictures of the gallery: two minutes.
gallery: $(VENV)/test-installed
	$(BIN)/python scripts/gallery.py --readme docs/robots.md
	for scene in scenes/robots/*-shelf.json; do \
		$(BIN)/python scripts/screenshot.py docs/robots/$$(basename $$scene -shelf.json).png --scene $$scene --size 840 560 --stage \
		|| exit 1; done

# The tests of the native engine under AddressSanitizer and UndefinedBehaviorSanitizer, with GCC, in an environment of
# its own. The interpreter itself is not looked at, and never gives back all of its memory.
SANITIZED := build/sanitize
sanitize:
	$(PYTHON) -m venv $(SANITIZED)
	$(SANITIZED)/bin/python -m pip install --quiet --editable '.[dev]' --config-settings=cmake.define.HUMANOID_RAIL_SANITIZE=ON
	LD_PRELOAD="$$(gcc -print-file-name=libasan.so) $$(gcc -print-file-name=libubsan.so) $$(gcc -print-file-name=libstdc++.so)" \
	ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 \
	$(SANITIZED)/bin/python -m pytest -k 'not python and not allocated and not memory' \
		tests/kinematics tests/collision tests/resolution tests/following/test_follower.py \
		tests/following/test_moved_obstacles.py tests/planning/test_planner.py tests/paper

$(VENV)/pyvenv.cfg:
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; sys.exit(None if (3, 11) <= v <= (3, 13) else \
		f"error: {sys.executable} is Python {v[0]}.{v[1]}; humanoid_rail needs 3.11 to 3.13: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

# Builds the native engine.
$(VENV)/plan-installed: $(VENV)/pyvenv.cfg pyproject.toml CMakeLists.txt $(ENGINE)
	@echo "Installing what is needed and compiling the native engine: this takes some minutes."
	$(BIN)/python -m pip install --quiet --editable . $(BUILD)
	touch $@

# What is installed already stays as it is: this adds what the extra needs.
$(VENV)/test-installed: $(VENV)/plan-installed
	$(BIN)/python -m pip install --quiet 'humanoid_rail[dev]'
	touch $@

clean:
	rm -rf $(VENV) out site
