#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test: ./test.sh [ctest arguments].
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
source cmake/setup.sh
install_missing "${build_packages[@]}" "${test_packages[@]}"
build_release ON all
say "testing"
ctest --test-dir "$build" --output-on-failure --parallel "$(nproc)" "$@"
