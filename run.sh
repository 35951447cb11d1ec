#!/usr/bin/env bash
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Installs what is missing, builds, and runs scenarios: ./run.sh [SCENARIO.yaml ...]; the default one without arguments.
set -euo pipefail
start=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")"
source cmake/setup.sh
install_missing "${build_packages[@]}"
build_release OFF all "$build_minutes"
cd "$start"

[ $# -gt 0 ] || set -- "$root/trajectories/default.yaml"
for scenario in "$@"; do
  name=$(basename "${scenario%.*}")
  out="$root/out/$name"
  say "running $scenario"
  "$build/cli/reamsim" run "$scenario" -o "$out" --overwrite
  say "written"
  find "$out" -maxdepth 1 -mindepth 1 | sort
done
