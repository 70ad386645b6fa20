#!/usr/bin/env bash
# Installs what is needed, builds with warnings as errors, runs every test but the long studies
# (ctest --test-dir build/ci -L study), then the unit tests again under the address and
# undefined-behaviour sanitizers. Safe to run again.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh test
python3 tools/check_layers.py

configure() {
  mkdir -p build
  cmake --preset "$1" >"build/configure_$1.log" 2>&1 || { cat "build/configure_$1.log" >&2; exit 1; }
}

configure ci
cmake --build build/ci
ctest --test-dir build/ci --output-on-failure -j "$(nproc)" -LE study

configure asan
cmake --build build/asan --target unit_tests
ctest --test-dir build/asan --output-on-failure -j "$(nproc)" -L unit
