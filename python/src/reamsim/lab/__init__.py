# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Statistics of runs and studies: `reamsim fit`, `uq`, `validate` and the main effects of `reamsim sweep` are computed here.

======================  =========================================================================================
`lab.force_model`       forces of a finished run for other constants of the force law, from its force basis
`lab.fit`               the constants that best explain measured forces, with covariance and what the data cannot tell
`lab.sensitivity`       Sobol indices with their errors
`lab.uncertainty`       bands and indices of a sample of inputs
`lab.effects`           main effects of the parameters of a study
`lab.validation`        published numbers against the runs of a study
`lab.*_figure`          their figures
======================  =========================================================================================

The modules need numpy and scipy, the figures matplotlib (Debian: python3-scipy, python3-matplotlib). Lengths are in mm,
times in s, forces in N, torques in N·mm, energies in mJ, densities in g/cm³, specific energies in J/mm³.
"""
