#!/usr/bin/env bash
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Installs what is missing, builds, and runs the tests: ./test.sh [--all] [ctest arguments]. --all adds those that need a
# browser (label browser), and installs one. Campaigns of minutes to hours (label long), and those that need a cluster (label
# cluster) or make roots of Debian and a container (label container), are left out: ctest --test-dir build/release -L 'long|cluster|container'
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
source cmake/setup.sh
browser=OFF
# Tests of the public CT and meshes are skipped where this folder does not hold them.
export REAMSIM_DATA="${REAMSIM_DATA:-$PWD/../shared/data}"
if [ "${1-}" = --all ]; then
  browser=ON
  shift
  install_missing "${browser_packages[@]}"
fi
install_missing "${build_packages[@]}" "${test_packages[@]}"
build_release ON all "-DREAMSIM_BROWSER_TESTS=$browser"
say "testing"
# One more than processors: many tests wait for a browser, a limit of time, or a signal.
ctest --test-dir "$build" --output-on-failure --parallel "$(($(nproc) + 1))" --label-exclude '^(long|cluster|container)$' "$@"
