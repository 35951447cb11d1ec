# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# api_documentation.sh DOXYGEN FOLDER: the comments of all headers without a warning, and everything in the library's
# header described. From the root of the checkout.
set -eu
mkdir -p "$2"
{ cat docs/Doxyfile; echo "OUTPUT_DIRECTORY = $2/all"; } | "$1" -
{ cat docs/Doxyfile; echo "OUTPUT_DIRECTORY = $2/library"; echo "INPUT = sim/api/reamsim"; echo "EXTRACT_ALL = NO"; } | "$1" -
test -s "$2/library/html/classreamsim_1_1Simulation.html"
