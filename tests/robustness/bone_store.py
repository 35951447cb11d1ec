# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""bone_store.py REAMSIM ROOT KILLS: a store of bones that is killed while it writes, or that two processes share, never gives a wrong bone.

Imports a phantom, whose grids name what was read, in a cache of its own: KILLS times killed after a random time, then twice at once, then
whole, on a full disk and in a home that cannot be written. Every import that ends must have the bytes of one without a store. Bytes of a scan that change are another bone."""

import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

SEED = 47


def command(program, root, folder, out):
    return [program, "import", str(root / "trajectories/study_eccentric_10deg.yaml"), "-o", str(folder / out), "--overwrite", "--quiet",
            "--set", "bone.voxel_mm=0.5"]


def main():
    program, root, kills = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3])
    draw = random.Random(SEED)
    print("seed", SEED)
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place)
        stored = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache"), "REAMSIM_CACHE": "", "POCL_CACHE_DIR": str(folder / "kernels")}
        begin = time.monotonic()
        subprocess.run(command(program, root, folder, "reference.vdb"), env={**stored, "REAMSIM_CACHE": "off"}, check=True)
        usual_s = time.monotonic() - begin
        reference = (folder / "reference.vdb").read_bytes()
        bones = folder / "cache/reamsim/bones"
        finished = 0
        for _ in range(kills):
            run = subprocess.Popen(command(program, root, folder, "a.vdb"), env=stored)
            try:
                finished += run.wait(timeout=draw.uniform(0.02, 1.2 * usual_s)) == 0
            except subprocess.TimeoutExpired:
                run.send_signal(signal.SIGKILL)
                run.wait()
            if draw.random() < 0.5:
                for file in bones.glob("*.bone"):
                    file.unlink()  # so that it is written again
        together = [subprocess.Popen(command(program, root, folder, name), env=stored) for name in ("a.vdb", "b.vdb")]
        assert [run.wait() for run in together] == [0, 0]
        for name in ("a.vdb", "b.vdb"):
            assert (folder / name).read_bytes() == reference, f"{name} differs from an import without a store"
        said = subprocess.run([program, "cache"], env=stored, capture_output=True, text=True, check=True).stdout
        kept = list(bones.glob("*.bone"))
        assert len(kept) == 1, f"{kept}\n{said}"
        subprocess.run(command(program, root, folder, "a.vdb"), env=stored, check=True)
        assert (folder / "a.vdb").read_bytes() == reference, "a bone of the store differs"
        full = folder / "full"
        full.mkdir()
        enter = ["unshare", "--user", "--map-root-user", "--mount"]
        mounts = subprocess.run([*enter, "true"], check=False, stderr=subprocess.DEVNULL).returncode == 0
        if not mounts:
            print("not tested: full disk, read-only home (this system, such as a container, lets a user mount nothing)")
        for options in ("size=64k", "ro") if mounts else ():  # a full disk, a home that cannot be written
            script = f'mount -t tmpfs -o {options} none "$0" && XDG_CACHE_HOME="$0" exec "$@"'
            subprocess.run([*enter, "sh", "-c", script, str(full),
                            *command(program, root, folder, "a.vdb")], env=stored, check=True)
            assert (folder / "a.vdb").read_bytes() == reference, f"another bone with {options}"
        print(f"{kills} kills, of which {finished} came too late; {said.strip()}")


main()
