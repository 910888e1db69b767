# make run [SCENARIO=my.yaml] | make test | make lint | make docs | make bench | make test-faults | make colcon | make bags | make clean.
# The environment in .venv is made once. ARGS=... goes on to the tests and to the benchmark.
SHELL := /bin/bash
VENV := .venv
PY := $(VENV)/bin/python
STAMP := $(VENV)/.installed
PIP := $(PY) -m pip install -qq --disable-pip-version-check
# Of the tests; those that start nodes run one after another in any case.
WORKERS ?= 2
# The first of these that is there, works, and is of a version that the package supports.
PYTHONS := $(PYTHON) python3.11 python3.10 python3.12 python3 /usr/bin/python3

export ROS_AUTOMATIC_DISCOVERY_RANGE ?= LOCALHOST

.PHONY: run test lint docs test-faults bench install bags colcon clean
run: $(STAMP)
	@out=runs/$$(date +%Y-%m-%d_%H-%M-%S); \
	$(PY) -m wholearm_ros run $(SCENARIO) --pacing lockstep --record $$out/bag --figures $$out/figures

test: lint
	@$(PY) -m pytest -m "not faults" -n $(WORKERS) $(ARGS)

# Style, types and rooms; test/test_layout.py holds the rooms, too.
lint: $(STAMP)
	@$(PY) -m ruff check -q .
	@$(PY) -m ruff format -q --check .
	@$(PY) -m mypy --no-error-summary
	@$(VENV)/bin/lint-imports --no-logo

# The site of the documentation; a link that leads nowhere is an error.
docs: $(STAMP)
	@NO_MKDOCS_2_WARNING=1 $(PY) -m mkdocs build -q --strict && echo "build/docs/index.html"

test-faults: $(STAMP)
	@$(PY) -m pytest -m faults $(ARGS)

bench: $(STAMP)
	@$(PY) benchmarks/bench.py $(ARGS)

# The same tree by colcon, as beside a sourced ROS 2; then imported from its install space.
COLCON := colcon-core colcon-ros colcon-python-setup-py colcon-recursive-crawl colcon-output colcon-package-information
colcon: $(STAMP)
	@$(PIP) 'setuptools>=65,<80' $(COLCON)
	@$(PY) -m colcon --log-base build/colcon/log build --base-paths . --build-base build/colcon/build \
	  --install-base build/colcon/install
	@prefix=build/colcon/install/wholearm_ros; test -x $$prefix/lib/wholearm_ros/mode_switcher && \
	test -f $$prefix/share/ament_index/resource_index/packages/wholearm_ros && \
	cd $$prefix && PYTHONPATH=$$(echo $$PWD/lib/python3*/site-packages) $(CURDIR)/$(PY) -c \
	  'import os, wholearm_ros.nodes.mode_switcher as node; assert "colcon" in node.__file__; print("colcon: built and imported")'

bags: $(STAMP)
	@$(PY) bags/make_bags.py

install: $(STAMP)

$(STAMP): setup.py pyproject.toml
	@python=; for p in $(PYTHONS); do \
	  if "$$p" -c 'import sys, venv, ensurepip; sys.exit(not (3, 10) <= sys.version_info < (3, 14))' 2>/dev/null; \
	  then python=$$p; break; fi; done; \
	if [ -z "$$python" ]; then echo "error: no working Python with venv among: $(PYTHONS)" \
	  "(allowed: 3.10 to 3.13; set one with make PYTHON=/path/to/python)" >&2; exit 2; fi; \
	echo "setting up $(VENV) with $$("$$python" --version) (once, a few minutes)"; \
	[ -x $(PY) ] || "$$python" -m venv $${ROS_DISTRO:+--system-site-packages} $(VENV)
	@# Where a ROS 2 is sourced, its own packages are used and the wheels of ROS stay out.
	@$(PIP) -e ".[test,mujoco,console$$([ "$$ROS_DISTRO" ] || echo ,ros-wheels)]"
	@# PyBullet has wheels up to Python 3.11; it is not compiled, MuJoCo takes its place.
	@$(PIP) --only-binary pybullet -e '.[pybullet]' 2>/dev/null || \
	  echo "pybullet has no wheel for this Python: MuJoCo is the default (to compile it: pip install pybullet)"
	@# An editable install leaves the ament files out; links to files, so that an edited config counts
	@# at once: `ros2 launch` does not look into a linked directory.
	@share=$(VENV)/share/wholearm_ros index=$(VENV)/share/ament_index/resource_index/packages; \
	for d in config launch; do rm -rf $$share/$$d; mkdir -p $$share/$$d; done; mkdir -p $$index; \
	for f in package.xml config/*.* launch/*.py; do ln -sfn $(CURDIR)/$$f $$share/$$f; done; \
	ln -sfn $(CURDIR)/resource/wholearm_ros $$index/wholearm_ros; \
	mkdir -p $(VENV)/lib/wholearm_ros; cp resource/executables/* $(VENV)/lib/wholearm_ros/
	@echo "compiling the kernels (once) ..."; $(PY) -m wholearm_ros.planner.warm
	@touch $@

clean:
	rm -rf $(VENV) build dist install log runs .hypothesis .pytest_cache .benchmarks *.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
