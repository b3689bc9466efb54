#!/bin/sh
# Writes the lock files anew: exact versions and hashes for every supported Python. Needs uv (pip install uv).
set -e
cd "$(dirname "$0")"
lock() {
    out=$1
    shift
    uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
        --no-annotate --no-header "$@" -o "$out"
}
lock setuptools.lock setuptools.in
lock ros-from-pip.lock ros.in build.in python.in dev.in
lock ros-from-apt.lock build.in python.in dev.in
lock ubuntu-24.04.lock ubuntu-24.04.in
