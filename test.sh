#!/usr/bin/env bash
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Installs what is missing, builds, and runs the tests: ./test.sh [--quick] [--all] [--developer] [ctest arguments].
#   --quick      only the tests of tests/quick.txt, a minute on two cores
#   --all        adds the tests that need a browser (label browser), and installs one
#   --developer  adds the checks of a change (label developer): warnings are errors, and the format
# Campaigns of minutes to hours (label long), and tests that need a cluster (label cluster) or make roots of Debian and a
# container (label container), are left out: ctest --test-dir build/release -L 'long|cluster|container'
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
source cmake/setup.sh
# Tests of the public CT and meshes are skipped where this folder does not hold them.
export REAMSIM_DATA="${REAMSIM_DATA:-$PWD/../shared/data}"
browser=OFF
developer=OFF
quick=OFF
while true; do
  case "${1-}" in
    --quick) quick=ON ;;
    --all) browser=ON ;;
    --developer) developer=ON ;;
    *) break ;;
  esac
  shift
done
packages=("${build_packages[@]}" "${test_packages[@]}")
left_out='long|cluster|container'
[ $browser = OFF ] || packages+=("${browser_packages[@]}")
[ $developer = ON ] && packages+=("${developer_packages[@]}") || left_out+='|developer'
install_missing "${packages[@]}"
build_release ON all "$test_build_minutes" "-DREAMSIM_BROWSER_TESTS=$browser" "-DCMAKE_COMPILE_WARNING_AS_ERROR=$developer"
[ $quick = OFF ] || set -- --tests-regex "$(python3 tests/repository/quick_tests.py .)" "$@"
say "testing"
# One more than processors: many tests wait for a browser, a limit of time, or a signal.
ctest --test-dir "$build" --output-on-failure --parallel "$(($(nproc) + 1))" --label-exclude "^($left_out)$" "$@"
