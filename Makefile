# make setup   a virtual environment with ROS 2 Jazzy, and the workspace built (ROS from /opt/ros/jazzy where it is)
# make demo    set up, then explore the paper's floor; what it learnt is in runs/demo
# make test    set up, then check style, types and run all tests
# make oldest  set up, then test with the libraries' versions of Ubuntu 24.04, which a ROS from apt goes with
# make shell   set up, then a shell in the environment of the workspace
# make lock    write the lock files anew from requirements/*.in, by a locked uv
# make clean   remove what set-up made
# Variables: PYTHON (which Python to set up with), OUT and SEED of the demo, PYTEST_ARGS, LOCK_ARGS (e.g. --upgrade).
.PHONY: setup demo test oldest style types tests shell lock clean help
.DEFAULT_GOAL := help
PYTHON ?=
SEED ?= 1
OUT ?= runs/demo
PYTEST_ARGS ?=
LOCK_ARGS ?=
# Tests that compute share the cores; those that watch a clock or start processes of their own have the machine alone.
SPREAD = -n auto --maxprocesses 4 --dist loadfile
COMPUTING = hslam_atlas hslam_bringup hslam_ekf hslam_gvg hslam_landmarks hslam_report hslam_sim hslam_types \
	hslam_voronoi
CLOCKED = bags hslam_ros scout_driver setup test
# What computes, stores or draws with the libraries that Ubuntu 24.04 has older, and one whole run.
OLDEST_COMPUTING = hslam_atlas hslam_bringup hslam_ekf hslam_gvg hslam_report hslam_sim
OLDEST_CLOCKED = bags \
	"test/test_run_same_atlas.py::test_separate_processes_and_one_process_agree_bit_for_bit[sonar]"

help:
	@sed -n 's/^# \(make\|Variables\)/\1/p' Makefile

setup:
	@python=$$(setup/find_python.sh "$(PYTHON)") && "$$python" -B setup/set_up.py

demo: setup
	.venv/bin/hslam explore wean_hall_6 --seed $(SEED) --out $(OUT) --force

test: setup style types tests

style: setup
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .

types: setup
	.venv/bin/mypy

tests: setup
	.venv/bin/hslam-env python -m pytest $(SPREAD) $(PYTEST_ARGS) $(COMPUTING)
	.venv/bin/hslam-env python -m pytest $(PYTEST_ARGS) $(CLOCKED)

oldest: setup
	@.venv/bin/python -B setup/oldest.py
	.venv/bin/hslam-env sh -c 'export PYTHONPATH="$$PWD/.oldest:$$PYTHONPATH"; \
		python -m pytest $(SPREAD) $(PYTEST_ARGS) $(OLDEST_COMPUTING) && \
		python -m pytest $(PYTEST_ARGS) $(OLDEST_CLOCKED)'

shell: setup
	@.venv/bin/hslam-env $${SHELL:-/bin/sh}

lock:
	@python=$$(setup/find_python.sh "$(PYTHON)") && "$$python" -B setup/write_locks.py $(LOCK_ARGS)

clean:
	rm -rf .venv .oldest .lock-tool build install log
