# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Sourced by run.sh and test.sh: installs what is missing and builds a release in build/release.
# Needs Debian 12 (or a system whose apt has the same packages); sudo only when not root.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$root/build/release"

build_packages=(
  build-essential cmake ninja-build pkg-config file
  ocl-icd-opencl-dev opencl-headers pocl-opencl-icd libeigen3-dev libosmesa6-dev libegl-dev libgl-dev
  libopenvdb-dev libtbb-dev libboost-dev libboost-iostreams-dev libassimp-dev libfmt-dev libyaml-cpp-dev libinsighttoolkit5-dev
  libcli11-dev nlohmann-json3-dev libpango1.0-dev libssl-dev zlib1g-dev libjpeg-dev libpng-dev libmeshoptimizer-dev
  libseccomp-dev python3-dev pybind11-dev
  gnuplot-nox fonts-dejavu-core)
test_packages=(clang-format-14 lintian doxygen ffmpeg libgtest-dev libgmock-dev libbenchmark-dev python3-openvdb python3-jsonschema libopenvdb-tools oclgrind
  python3-numpy python3-yaml python3-pandas python3-matplotlib python3-pil python3-pytest jupyter-nbconvert python3-ipykernel
  python3-venv python3-pip python3-setuptools python3-wheel reuse man-db zsh mkdocs mkdocs-material)
browser_packages=(chromium chromium-driver python3-selenium blender)

say() { printf '\n== %s\n' "$*"; }

# install_missing PACKAGE...: apt-get install of those that are not there.
install_missing() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f '${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  if ! command -v apt-get >/dev/null; then
    echo "These packages are missing and there is no apt-get to install them: ${missing[*]}" >&2
    exit 1
  fi
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "Install as root: apt-get install ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
  fi
  say "installing ${missing[*]}"
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# build_release TESTS TARGET [OPTION...]: configures (TESTS=ON or OFF) with more options of cmake and builds TARGET.
build_release() {
  mkdir -p "$build"
  say "building in ${build#"$root"/}"
  # Debian's GDCM and Imath describe programs that are not installed, at length; shown only when configuring fails.
  if ! (cd "$root" && cmake --preset release -DREAMSIM_TESTS="$1" "${@:3}" >"$build/configure.log" 2>&1); then
    cat "$build/configure.log" >&2
    exit 1
  fi
  cmake --build "$build" --target "$2"
}
