# make setup   a virtual environment with ROS 2 Jazzy, and the workspace built (ROS from /opt/ros/jazzy where it is)
# make demo    set up, then explore the paper's floor; what it learnt is in runs/demo
# make test    set up, then check style, types and run all tests
# Variables: PYTHON (which Python to set up with), OUT and SEED of the demo, PYTEST_ARGS.
.PHONY: setup demo test style types tests shell lock clean help
.DEFAULT_GOAL := help
PYTHON ?=
SEED ?= 1
OUT ?= runs/demo
PYTEST_ARGS ?=

help:
	@sed -n 's/^# //p' Makefile

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
	.venv/bin/hslam-env python -m pytest $(PYTEST_ARGS)

# A shell in the environment of the workspace.
shell: setup
	@.venv/bin/hslam-env $${SHELL:-/bin/sh}

# Write the lock files anew from requirements/*.in; needs the uv command.
lock:
	requirements/lock.sh

clean:
	rm -rf .venv build install log
