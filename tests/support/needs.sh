#!/bin/sh
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# needs.sh PROGRAM COMMAND...: runs COMMAND; where PROGRAM is not installed, says so and ends with 77, which CTest counts as
# skipped.
if ! command -v "$1" >/dev/null; then
  echo "skipped: $1 is not installed, or this release has no package of it"
  exit 77
fi
shift
exec "$@"
