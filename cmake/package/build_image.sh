#!/usr/bin/env bash
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Makes the container image of reamsim from its Debian packages, with no other network than the mirror of Debian's packages that
# apt of this machine uses: build_image.sh FOLDER reamsim_*.deb [python3-reamsim_*.deb]
#
# FOLDER gets rootfs.tar and Containerfile; where podman is installed, it becomes the image `reamsim` (docs/install.md). Needs
# mmdebstrap, and root or user namespaces.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source "$here/apt_mirror.sh"

if [ $# -lt 2 ]; then
  echo "usage: build_image.sh FOLDER PACKAGE.deb..." >&2
  exit 2
fi
folder=$1
shift
mkdir -p "$folder"
sources=$(apt_mirror_sources)
if [ -z "$sources" ]; then
  echo "apt of this machine knows no mirror of Debian; run apt-get update" >&2
  exit 1
fi
settings=()
while read -r line; do [ -z "$line" ] || settings+=("--aptopt=$line"); done < <(apt_mirror_settings)

packages=$(mktemp -d)
trap 'rm -rf "$packages"' EXIT
cp "$@" "$packages"
chmod 755 "$packages"

# The packages are installed by the apt of the new root, which cannot touch this machine. Pages, translations and lists of packages are for
# people who work in a system, not for an image.
mmdebstrap --variant=apt --format=tar "${settings[@]}" \
  --aptopt='APT::Install-Recommends "false"' \
  --dpkgopt='path-exclude=/usr/share/man/*' \
  --dpkgopt='path-exclude=/usr/share/locale/*' \
  --dpkgopt='path-exclude=/usr/share/doc/*' \
  --dpkgopt='path-include=/usr/share/doc/*/copyright' \
  --customize-hook="mkdir -p \"\$1/packages\" && cp '$packages'/*.deb \"\$1/packages\"" \
  --customize-hook='chroot "$1" sh -c "apt-get install --yes /packages/*.deb"' \
  --customize-hook='rm -rf "$1/packages"; mkdir -m 1777 "$1/results"' \
  bookworm "$folder/rootfs.tar" - <<<"$sources"
cp "$here/../../Containerfile" "$folder"

if command -v podman >/dev/null; then
  podman build --layers=false --tag reamsim "$folder"
else
  echo "podman is not installed; with it: podman build --tag reamsim $folder"
fi
