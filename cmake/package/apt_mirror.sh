# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

# Sourced: what another root needs to install from the mirror that apt of this machine uses.

# The lines of a sources.list: Debian's main, as this machine has it.
apt_mirror_sources() {
  apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' \
    'Created-By: Packages' 'Origin: Debian' 'Component: main' | sort -u
}

# Settings for that mirror, as lines of apt.conf: a proxy, an archive whose dates have passed.
apt_mirror_settings() {
  apt-config dump | grep -E '^Acquire::(Check-Valid-Until|Check-Date|https?::Proxy) ' || true
}
