# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Runs reamsim, an offline glenoid-reaming simulator, and reads its results.

>>> import reamsim
>>> run = reamsim.run("trajectories/default.yaml", "out/coarse", bone__voxel_mm=0.5)
>>> run.forces["axial_force_n"].max()
>>> run.plot_forces().savefig("forces.png")

Lengths are in mm, times in s, forces in N, torques in N·mm, energies in mJ, densities in g/cm³.
"""

from .errors import (InputError, Interrupted, MissingPackage, ProgramError, ProgramNotFound, ReamsimError,
                     ReamsimWarning, ResultsError, RunError)
from .grid import DepthMap, Grid
from .plots import plot_bands, plot_depth_map, plot_forces
from .program import __version__, find_program, run, sweep
from .results import Run, Surface, Sweep, load, load_sweep
from .simulation import POSE, Simulation, State, Step

__all__ = [
    "POSE", "DepthMap", "Grid", "InputError", "Interrupted", "MissingPackage", "ProgramError", "ProgramNotFound",
    "ReamsimError", "ReamsimWarning", "ResultsError", "Run", "RunError", "Simulation", "State", "Step", "Surface", "Sweep",
    "__version__", "find_program", "load", "load_sweep", "plot_bands", "plot_depth_map", "plot_forces", "run", "sweep",
]
