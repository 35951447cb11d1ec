# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""licences.py ROOT: every file of the repository says its licence, and the lint that says so finds a file that does not. Every
package that cmake/setup.sh installs is named in docs/third-party.md."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# In parts, so that they are not taken for those of this file.
HEADER = "# SPDX-" "FileCopyrightText: the reamsim authors\n# SPDX-" "License-Identifier: {}\n"


def lint(root):
    done = subprocess.run(["reuse", "--root", str(root), "lint"], capture_output=True, text=True,
                          env={**os.environ, "LC_ALL": "C.UTF-8"})
    return done.returncode, done.stdout + done.stderr


def check_that_lint_finds(root, folder):
    """A folder with one good file is accepted, one with a file without a licence or of an unknown one is not."""
    (folder / "LICENSES").mkdir()
    shutil.copy(root / "LICENSES/Apache-2.0.txt", folder / "LICENSES")
    (folder / "good.py").write_text(HEADER.format("Apache-2.0"))
    assert lint(folder)[0] == 0, lint(folder)[1]
    (folder / "bare.py").write_text("print('no licence')\n")
    status, text = lint(folder)
    assert status != 0 and "bare.py" in text, text
    (folder / "bare.py").write_text(HEADER.format("Apache-2.00"))
    assert lint(folder)[0] != 0


def check_licences_of_pictures(root):
    """Pictures of public data have the licence of the data; the last paragraph that names a file counts."""
    text = subprocess.run(["reuse", "--root", str(root), "spdx"], capture_output=True, text=True, check=True).stdout
    licence = {}
    for block in text.split("\n\n"):
        lines = dict(line.split(": ", 1) for line in block.splitlines() if ": " in line)
        if "FileName" in lines:
            licence[lines["FileName"]] = [line.split(": ")[1] for line in block.splitlines() if "LicenseInfoInFile" in line]
    assert licence["./docs/images/gallery/ct_hero.jpg"] == ["CC-BY-3.0"], licence["./docs/images/gallery/ct_hero.jpg"]
    assert licence["./paper/figures/ct_glenoid.png"] == ["CC-BY-3.0"], licence["./paper/figures/ct_glenoid.png"]
    assert licence["./docs/images/gallery/mesh_overview.jpg"] == ["CC-BY-SA-3.0"]
    assert licence["./docs/images/gallery/default_steel.jpg"] == ["Apache-2.0"]
    assert licence["./tests/browser/axe.min.js"] == ["MPL-2.0"]
    assert licence["./tests/repository/cff-1.2.0.schema.json"] == ["CC-BY-4.0"]
    assert sorted(licence["./render/viewer/dist/preview.html"]) == ["Apache-2.0", "ISC", "MIT"]


def check_packages(root):
    arrays = re.findall(r"_packages=\(([^)]*)\)", (root / "cmake/setup.sh").read_text())
    packages = re.findall(r"[^\s'?|]+", " ".join(arrays))
    assert len(packages) > 50, packages
    page = (root / "docs/third-party.md").read_text()
    missing = [package for package in packages if f"`{package}`" not in page]
    assert not missing, f"not in docs/third-party.md: {missing}"


def outputs(folder, names):
    """Folders that a build or a run leaves in the checkout, as .gitignore names them."""
    return [name for name in names if (pathlib.Path(folder) / name).is_dir()
            and (name in (".git", ".cache", "out", "node_modules", "__pycache__") or name.startswith("build")
                 or name.endswith((".partial", ".egg-info")))]


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        root = folder / "sources"  # a copy, so that neither git nor a clone is needed
        shutil.copytree(sys.argv[1], root, ignore=outputs)
        status, text = lint(root)
        assert status == 0, text
        check_licences_of_pictures(root)
        check_packages(root)
        assert (root / "LICENSE").read_text().split() == (root / "LICENSES/Apache-2.0.txt").read_text().split()
        (folder / "small").mkdir()
        check_that_lint_finds(root, folder / "small")


main()
