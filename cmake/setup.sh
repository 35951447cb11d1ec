# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Sourced by run.sh and test.sh: installs what is missing and builds a release in build/release. Needs apt, and sudo only when
# not root. Packages are looked up by what apt offers, never by the name of a release, so that Debian 12, 13, testing and
# systems derived from them share one list:
#   NAME    is required
#   A|B     the first of them that apt offers is required
#   NAME?   is installed where apt offers it; what needs it is left out elsewhere, and says so

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/release"
# Minutes of processor that a build takes from nothing, without and with tests.
build_minutes=10
test_build_minutes=20

# OSMesa was removed from Mesa in 25.1; EGL renders where it does not exist.
build_packages=(
  build-essential cmake ninja-build 'pkgconf|pkg-config' file
  ocl-icd-opencl-dev opencl-headers pocl-opencl-icd libeigen3-dev 'libosmesa6?' libegl-dev libegl1 libgl1-mesa-dri libgl-dev
  libopenvdb-dev libtbb-dev libboost-dev libboost-iostreams-dev libassimp-dev libfmt-dev libyaml-cpp-dev libinsighttoolkit5-dev
  libcli11-dev nlohmann-json3-dev libpango1.0-dev libssl-dev zlib1g-dev libjpeg-dev libpng-dev libmeshoptimizer-dev
  libseccomp-dev python3-dev pybind11-dev
  gnuplot-nox fonts-dejavu-core python3-numpy python3-scipy python3-matplotlib python3-yaml)
test_packages=(lintian doxygen ffmpeg libgtest-dev libgmock-dev libbenchmark-dev libcgal-dev python3-openvdb python3-jsonschema
  libopenvdb-tools 'oclgrind?' python3-pandas python3-pil python3-pytest jupyter-nbconvert python3-ipykernel
  python3-venv python3-pip python3-setuptools python3-wheel reuse man-db zsh mkdocs mkdocs-material)
browser_packages=(chromium chromium-driver python3-selenium 'blender?')
developer_packages=('clang-format-14?')

say() { printf '\n== %s\n' "$*"; }

# fail MESSAGE [LOG]: ends with the message, and the end of a log.
fail() {
  [ $# -lt 2 ] || tail -n 40 "$2" >&2
  printf '%s: %s\n' "$(basename "$0")" "$1${2:+; the whole log is ${2#"$root"/}}" >&2
  exit 1
}

# No pipe to `grep -q`, which exits early: the writer then fails with SIGPIPE, and with pipefail the whole pipeline.
installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }
offered() { [[ $(LC_ALL=C apt-cache policy "$1" 2>/dev/null) =~ Candidate:\ [^\(] ]]; }

# choose ENTRY...: sets `missing` to the packages that have to be installed, by what apt offers now.
choose() {
  missing=()
  local entry name names
  for entry in "$@"; do
    IFS='|' read -ra names <<<"${entry%\?}"
    for name in "${names[@]}"; do ! installed "$name" || continue 2; done
    for name in "${names[@]}"; do ! offered "$name" || { missing+=("$name"); continue 2; }; done
    # apt offers none: an error of apt-get names it later, unless it is optional.
    [[ $entry == *\? ]] || missing+=("${names[0]}")
  done
}

# install_missing ENTRY...: apt-get install of the packages that are not there.
install_missing() {
  local missing as_root=() log="$build/install.log"
  choose "$@"
  [ ${#missing[@]} -gt 0 ] || return 0
  command -v apt-get >/dev/null || fail "these packages are missing, and there is no apt-get to install them: ${missing[*]}"
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "these packages are missing; as root, run: apt-get install ${missing[*]}"
    as_root=(sudo)
  fi
  mkdir -p "$build"
  say "installing ${#missing[@]} packages and what they depend on; log: ${log#"$root"/}"
  "${as_root[@]}" apt-get update -qq >"$log" 2>&1 || fail "apt-get update failed" "$log"
  choose "$@"
  echo "${missing[*]}"
  LC_ALL=C "${as_root[@]}" apt-get install --assume-no --no-install-recommends "${missing[@]}" 2>/dev/null |
    grep -E '^(Need to get|After this operation)|Download size|Space needed' || true
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}" >>"$log" 2>&1 ||
    fail "apt-get cannot install them" "$log"
}

# Of the lines of ninja on standard input, how far it is: on a terminal in place, elsewhere a line at each tenth.
show_progress() {
  local line text tenth shown=0 begin=$SECONDS
  while IFS= read -r line; do
    [[ $line =~ ^\[([0-9]+)/([0-9]+)\] ]] || continue
    printf -v text '%3d %% (step %d of %d), %d min' $((100 * BASH_REMATCH[1] / BASH_REMATCH[2])) "${BASH_REMATCH[@]:1:2}" \
      $(((SECONDS - begin) / 60))
    tenth=$((10 * BASH_REMATCH[1] / BASH_REMATCH[2]))
    if [ -t 1 ]; then
      printf '\r%s ' "$text"
    elif [ "$tenth" -gt "$shown" ]; then
      printf '%s\n' "$text"
      shown=$tenth
    fi
  done
  [ ! -t 1 ] || echo
}

# build_release TESTS TARGET MINUTES [OPTION...]: configures (TESTS=ON or OFF) with more options of cmake and builds TARGET,
# which takes some MINUTES of processor from nothing.
build_release() {
  local log="$build/build.log" configure="$build/configure.log"
  mkdir -p "$build"
  say "configuring in ${build#"$root"/}; log: ${configure#"$root"/}"
  (cd "$root" && cmake --preset release -DREAMSIM_TESTS="$1" "${@:4}" >"$configure" 2>&1) || fail "configuring failed" "$configure"
  grep -E '^-- reamsim: ' "$configure" || true
  # A compiler needs up to 1.5 GB.
  local jobs=$(nproc) memory=$(($(sed -n 's/^MemAvailable: *\([0-9]*\) kB/\1/p' /proc/meminfo) / 1500000))
  [ "$memory" -ge "$jobs" ] || jobs=$((memory > 1 ? memory : 1))
  say "building with $jobs compilers at a time, from nothing about $((($3 + jobs - 1) / jobs)) min; log: ${log#"$root"/}"
  cmake --build "$build" --parallel "$jobs" --target "$2" 2>&1 | tee "$log" | show_progress || fail "the build failed" "$log"
}
