# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""A Slurm cluster of one node on this machine: munged, slurmctld and slurmd, in namespaces of their own.

`enter()` starts the program again in new network, mount, process and host name namespaces, which needs root; when it
ends, all daemons end with it."""

import contextlib
import os
import pathlib
import shutil
import subprocess
import sys
import time

NODE, ADDRESS = "node1", "10.77.0.1"
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "ip", "unshare")
SKIPPED = 77

CONF = """
ClusterName=reamsim
SlurmctldHost={node}({address})
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
# Credentials expire early, since Slurm begins a requeued job only then (default 120 s).
AuthInfo=socket={dir}/munge.socket,cred_expire=5
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
StateSaveLocation={dir}/state
SlurmdSpoolDir={dir}/spool
SlurmctldPidFile={dir}/slurmctld.pid
SlurmdPidFile={dir}/slurmd.pid
SlurmctldLogFile={dir}/slurmctld.log
SlurmdLogFile={dir}/slurmd.log
ReturnToService=2
SlurmdParameters=config_overrides
NodeName={node} NodeAddr={address} CPUs={cpus} State=UNKNOWN
PartitionName=all Nodes={node} Default=YES State=UP MaxTime=INFINITE
"""


def skip(message):
    print(f"skipped: {message}")
    sys.exit(SKIPPED)


def require(*programs):
    missing = [name for name in programs if shutil.which(name) is None]
    if missing:
        skip(f"{', '.join(missing)} not found; install the Debian packages slurm-wlm, munge, snakemake and parallel")


def enter():
    """Returns inside the namespaces."""
    os.environ["PATH"] += ":/usr/sbin:/sbin"
    require(*PROGRAMS)
    if os.environ.get("REAMSIM_IN_NAMESPACE") == "1":
        return
    if os.geteuid() != 0:
        skip("needs root for a network namespace")
    namespaces = ["unshare", "--net", "--mount", "--uts", "--pid", "--fork", "--mount-proc", "--kill-child"]
    if subprocess.run([*namespaces, "true"], capture_output=True).returncode != 0:
        skip("no namespaces can be created here; a container needs --privileged")
    os.execvpe(namespaces[0], [*namespaces, sys.executable, *sys.argv], {**os.environ, "REAMSIM_IN_NAMESPACE": "1"})


def call(*command, **more):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, **more)
    assert result.returncode == 0, f"{command}: {result.returncode}\n{result.stdout}{result.stderr}"
    return result.stdout.strip()


def wait_until(condition, what, seconds):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f"{what}: not within {seconds} s"
        time.sleep(0.2)


def make_network(work):
    """Names do not resolve with `lo` alone."""
    (work / "hosts").write_text(f"127.0.0.1 localhost\n{ADDRESS} {NODE}\n")
    call("mount", "--bind", work / "hosts", "/etc/hosts")
    call("hostname", NODE)
    call("ip", "link", "set", "lo", "up")
    call("ip", "link", "add", "veth0", "type", "veth", "peer", "name", "veth1")
    call("ip", "address", "add", f"{ADDRESS}/24", "dev", "veth0")
    for end in ("veth0", "veth1"):
        call("ip", "link", "set", end, "up")


def squeue():
    """State of every job or array task that has not ended, by id."""
    return dict(line.split() for line in call("squeue", "-h", "-r", "-o", "%i %T").splitlines())


@contextlib.contextmanager
def cluster(work, cpus):
    """Runs the daemons; logs lie in `work`."""
    work = pathlib.Path(work)
    make_network(work)
    work.chmod(0o755)
    (work / "state").mkdir()
    (work / "spool").mkdir()
    key = work / "munge.key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o400)
    (work / "slurm.conf").write_text(CONF.format(node=NODE, address=ADDRESS, dir=work, cpus=cpus))
    (work / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
    os.environ["SLURM_CONF"] = str(work / "slurm.conf")
    with (work / "daemons.log").open("w") as log:
        def start(*command):
            return subprocess.Popen([str(word) for word in command], stdout=log, stderr=log)
        daemons = [start("munged", "--foreground", "--force", "--key-file", key, "--socket", work / "munge.socket",
                         "--pid-file", work / "munge.pid", "--log-file", work / "munge.log",
                         "--seed-file", work / "munge.seed")]
        try:
            wait_until((work / "munge.socket").exists, "munged", 20)
            daemons += [start("slurmctld", "-D"), start("slurmd", "-D", "-N", NODE)]
            wait_until(lambda: "idle" in subprocess.run(["sinfo", "-h", "-o", "%t"], capture_output=True, text=True).stdout,
                       f"slurmd ({work}/*.log)", 60)
            yield
        except BaseException:
            for name in ("daemons", "slurmctld", "slurmd"):
                text = (work / f"{name}.log").read_text(errors="replace") if (work / f"{name}.log").exists() else ""
                print(f"--- {name}.log\n" + "\n".join(text.splitlines()[-25:]))
            raise
        finally:
            for daemon in reversed(daemons):
                daemon.terminate()
            for daemon in reversed(daemons):
                daemon.wait()
