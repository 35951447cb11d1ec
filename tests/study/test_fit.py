# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Constants of the force law from simulated measurements of a block of two layers."""

import math
import pathlib

import numpy
import pytest
import reamsim
from reamsim.lab.fit import Constant, ForceFit, _unusual_energies, density_classes, fit_forces
from reamsim.lab.force_model import Coefficients, ForceBasis, grade_densities, law_of, specific_energies
from reamsim.lab.least_squares import frame_weights, minimum, nonnegative

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROW = numpy.dtype([("frame", "<i4"), ("grade", "<i4"), ("density_g_cm3", "<f4"), ("p_mm2", "<f4", (3,)),
                   ("p_torque_mm3", "<f4", (3,)), ("n_mm2", "<f4", (3,)), ("n_torque_mm3", "<f4", (3,)),
                   ("p_work_mm3", "<f4"), ("n_work_mm3", "<f4"), ("energy_mm3", "<f4"), ("floor_energy_mm3", "<f4")])
LAW = {"cutting.specific_energy_j_mm3": 0.15, "cutting.reference_density_g_cm3": 1.8, "cutting.density_exponent": 2.0,
       "cutting.normal_ratio": 0.5, "bone.density.ash_slope_g_cm3_per_hu": 0.0007,
       "bone.density.ash_offset_g_cm3": -0.009, "bone.density.ash_fraction": 0.6}
# The specific energies of the layers, J/mm³ (u1: of the lower density), and k_n: none of them those of the run.
U1, U2, NORMAL = 0.031, 0.087, 0.34
BOTH = ("axial_force_n", "spin_torque_nmm")


def limits():
    def key(name, most):
        return {"key": name, "min": 1e-6, "max": most, "text": f"0.000001 to {most}"}

    keys = {"u0": key("cutting.specific_energy_j_mm3", 10), "u": key("cutting.specific_energy_table.0.energy_j_mm3", 10),
            "p": key("cutting.density_exponent", 5), "k_n": key("cutting.normal_ratio", 10)}
    return {"keys": keys, "least_energy": {"specific_energy_j_mm3": 0.05, "reference_density_g_cm3": 1.8,
                                           "density_exponent": 2.5}}


def block(upper_g_cm3=1.2, lower_g_cm3=0.6, edge=False):
    """The basis of a plunge into two layers at 100 Hz: contact from frame 10, both layers from frame 150. The normal part
    has next to no torque."""
    frames, axis = numpy.arange(400), numpy.array([0.6, 0.0, 0.8])
    rows = []
    for frame in frames[10:]:
        areas = {round(upper_g_cm3 / 0.008): 0.05 * (frame - 10)}
        lower = round(lower_g_cm3 / 0.008)
        areas[lower] = areas.get(lower, 0) + 0.04 * max(frame - 150, 0)
        for grade, area in sorted([*areas.items(), *([(0, 2.0)] if edge else [])]):
            if area > 0:
                normal = (0.6 + 0.2 * math.sin(frame / 30)) * area * axis  # another part of the surface than that of P
                rows.append((frame, grade, grade * 0.008, 0.02 * area * axis, 7 * area * axis, normal, -1e-6 * normal,
                             area, 0, 0.03 * area, 0))
    return ForceBasis(numpy.array(rows, ROW), frames, 0.01 * frames, numpy.tile(axis, (400, 1)))


def two_energies(u1=U1, u2=U2, normal=NORMAL):
    p = 1000 * numpy.where(grade_densities() < 0.9, u1, u2)[:, None]
    p[0] = 0
    return Coefficients(p, normal * p)


def measured(basis, truth, columns=BOTH, noise=0.0, seed=1):
    """Columns with normal noise, relative to their largest value."""
    random = numpy.random.RandomState(seed)
    values = {column: basis.values(column, truth)[:, 0] for column in columns}
    return {column: one + noise * abs(one).max() * random.standard_normal(len(one)) for column, one in values.items()}


def fit(basis, columns, **options):
    return fit_forces(basis, LAW, basis.time_s, columns, **options)


def test_finds_the_layers_without_noise():
    basis = block()
    found = fit(basis, measured(basis, two_energies()), model="classes")
    assert [one.mean_g_cm3 for one in found.classes] == pytest.approx([0.6, 1.2])
    assert [one.value for one in found.constants] == pytest.approx([U1, U2, NORMAL], rel=1e-12)
    assert found.statements == ["all constants are determined by these data"] and not found.warnings
    assert all(one.rms < 1e-12 * one.rms_measured for one in found.residuals)


def test_finds_the_forces_of_a_rerun(tmp_path):
    """Not of the basis, but of a run of its own with other constants."""
    scenario = {
        "bone": {"source": "phantom", "voxel_mm": 0.5, "phantom": {
            "shape": "layered", "size_mm": [14, 14, 6], "cortical_mm": 1, "cortical_density_g_cm3": 1.2,
            "trabecular_density_g_cm3": 0.6}},
        "tool": {"mesh": str(ROOT / "assets/reamer_convex.stl")},
        "motion": {"frame_rate_hz": 100, "plunge": {"approach_mm": 0.5, "feed_mm_s": 1, "depth_mm": 3}},
        "render": {"enabled": False}, "output": {"meshes": False, "vti": False, "plots": False, "force_basis": True}}
    run = reamsim.run(scenario, tmp_path / "basis")
    table = [{"density_g_cm3": 0.6, "energy_j_mm3": U1}, {"density_g_cm3": 1.2, "energy_j_mm3": U2}]
    again = reamsim.run(scenario, tmp_path / "again", {"cutting.specific_energy_table": table,
                                                       "cutting.normal_ratio": NORMAL})
    columns = {column: again.force_array[column] for column in BOTH}
    found = fit_forces(ForceBasis.read(run.dir), law_of(run), again.force_array["time_s"], columns, model="classes")
    errors = [one.value / true - 1 for one, true in zip(found.constants, (U1, U2, NORMAL), strict=True)]
    print("relative errors of u1, u2, k_n:", *(f"{error:.1e}" for error in errors))
    assert max(map(abs, errors)) < 1e-5


def test_intervals_cover_the_truth():
    basis, repetitions = block(), 200
    covered = numpy.zeros((repetitions, 3))
    for i in range(repetitions):
        found = fit(basis, measured(basis, two_energies(), noise=0.02, seed=i), model="classes")
        covered[i] = [abs(one.value - true) / one.standard_error for one, true in zip(found.constants, (U1, U2, NORMAL))]
    print("of 200 intervals of 95 % cover the truth:", *(covered <= 1.96).sum(axis=0))
    # Binomial, n = 200, p = 0.95: 180 to 199 with a probability above 0.99.
    assert all(180 <= count <= 199 for count in (covered <= 1.96).sum(axis=0)), (covered <= 1.96).sum(axis=0)
    assert all((covered <= 3).sum(axis=0) >= 196)


@pytest.mark.parametrize("edge", [False, True])
def test_finds_the_law_of_two_densities(edge):
    basis = block(edge=edge)
    law = {**LAW, "cutting.specific_energy_j_mm3": 0.21, "cutting.density_exponent": 1.4, "cutting.normal_ratio": 0.7,
           "cutting.edge_force.tangential_n_mm": 3.0, "cutting.edge_force.normal_n_mm": 5.0}
    found = fit(basis, measured(basis, Coefficients.of_laws([law])))
    assert [one.name for one in found.constants] == ["u0", "p", "k_n", "K_t", "K_n"][:5 if edge else 3]
    assert [one.value for one in found.constants] == pytest.approx([0.21, 1.4, 0.7, 3.0, 5.0][:5 if edge else 3], rel=1e-9)


def test_one_density_cannot_tell_the_exponent():
    basis = block(1.2, 1.2)
    law = {**LAW, "cutting.specific_energy_j_mm3": 0.21, "cutting.density_exponent": 1.4}
    found = fit(basis, measured(basis, Coefficients.of_laws([law]), noise=0.02))
    assert not found["p"].fitted and found["p"].value == LAW["cutting.density_exponent"] and math.isnan(found["p"].standard_error)
    assert "cannot tell the exponent from u0" in found.statements[0]
    # The specific energy of that density is determined.
    assert found["u0"].value * (1.2 / 1.8) ** 2 == pytest.approx(0.21 * (1.2 / 1.8) ** 1.4, rel=0.02)


def test_torque_alone_cannot_tell_the_normal_ratio():
    basis = block()
    found = fit(basis, measured(basis, two_energies(), ["spin_torque_nmm"], 0.01), model="classes")
    assert not found["k_n"].fitted and "do not tell k_n" in found.statements[0]
    for constant, true in ((found["u1"], U1), (found["u2"], U2)):
        assert abs(constant.value - true) < 3 * constant.standard_error < 0.1 * true


def test_axial_force_alone_determines_a_product():
    basis = block()
    found = fit(basis, measured(basis, two_energies(), ["axial_force_n"], 0.01), model="classes", fit_normal_ratio=True)
    assert any("hard to tell apart" in statement for statement in found.statements) or not found["k_n"].fitted
    assert found["u2"].value * found["k_n"].value == pytest.approx(U2 * NORMAL, rel=0.02)


@pytest.mark.parametrize("basis", [block(), block(1.2, 1.2)], ids=["two densities", "one"])
@pytest.mark.parametrize("columns", [BOTH, ("axial_force_n",)], ids=["both", "axial"])
def test_refuses_forces_that_no_positive_energy_explains(basis, columns):
    reversed_ = {column: -values for column, values in measured(basis, two_energies(), columns, 0.02).items()}
    for options in ({}, {"fit_normal_ratio": False}, {"model": "classes"}):
        with pytest.raises(reamsim.InputError, match="measured.csv: u[01] is 0: a negative value") as error:
            fit(basis, reversed_, file="measured.csv", **options)
        assert error.value.status == 2
    with pytest.raises(reamsim.InputError, match="every measured value in the time of contact is 0"):
        fit(basis, {column: 0 * values for column, values in reversed_.items()})


def test_warns_of_other_signs_and_units():
    basis = block()
    right = measured(basis, Coefficients.of_laws([{**LAW, "cutting.specific_energy_j_mm3": 0.21}]), noise=0.01)

    def warnings(axial, torque, **options):
        wrong = {"axial_force_n": axial * right["axial_force_n"], "spin_torque_nmm": torque * right["spin_torque_nmm"]}
        return " | ".join(fit(basis, wrong, limits=limits(), **options).warnings)

    assert warnings(1, 1) == "" == warnings(1, 1, model="classes")
    assert "axial_force_n: R2 is -" in warnings(1, 0.001), "N m"
    assert "check sign and unit of every measured column (axial_force_n in N, spin_torque_nmm in N mm)" in warnings(-1, 1)
    assert "spin_torque_nmm: R2 is -" in warnings(1, -1)
    for options in ({}, {"model": "classes"}):
        of_kilo = warnings(0.001, 0.001, **options)
        assert "far below what is usual for bone" in of_kilo and "(axial_force_n in N, spin_torque_nmm in N mm)" in of_kilo
    assert "cutting.specific_energy_j_mm3 accepts 0.000001 to 10" in warnings(1e6, 1e6)
    assert "u1 is " in warnings(1e6, 1e6, model="classes")


def test_does_not_warn_of_soft_bone():
    """u0 at 1.8 g/cm³ says nothing of bone of 0.3 g/cm³: the least of the literature is 0.0006 J/mm³ there."""
    basis = block(0.3, 0.2)
    low = {**LAW, "cutting.specific_energy_j_mm3": 0.05, "cutting.density_exponent": 2.5}
    columns = measured(basis, Coefficients.of_laws([low]), noise=0.01)
    for model in ("law", "classes"):
        assert not fit(basis, columns, model=model, limits=limits()).warnings


def test_says_nothing_of_the_energy_of_bone_without_density():
    constants = [Constant("u0", 99.0), Constant("p", 0.0)]
    fit = ForceFit(constants, numpy.eye(2), [], [], None)
    assert fit.mean_g_cm3 == 0
    assert _unusual_energies(fit, 1.8, limits()["least_energy"], "axial_force_n") == []


def test_takes_times_between_frames_and_empty_cells():
    basis = block()
    every = measured(basis, two_energies())
    time_s = 0.5 * (basis.time_s[1:] + basis.time_s[:-1])[::3]
    half = {column: (0.5 * (values[1:] + values[:-1]))[::3] for column, values in every.items()}
    half["axial_force_n"][::4] = numpy.nan
    found = fit_forces(basis, LAW, time_s, half, model="classes")
    assert [one.value for one in found.constants] == pytest.approx([U1, U2, NORMAL], rel=1e-9)
    assert found.residuals[0].samples < found.residuals[1].samples
    with pytest.raises(reamsim.InputError, match="no measured time lies in the time of contact"):
        fit_forces(basis, LAW, time_s + 1000, half)


def test_frame_weights_interpolate_within_the_run():
    weights = frame_weights(numpy.array([1.0, 2.0, 4.0]), numpy.array([0.5, 1.0, 1.5, 3.5, 4.0 + 5e-10, 5.0])).toarray()
    assert weights == pytest.approx(numpy.array([[0, 0, 0], [1, 0, 0], [0.5, 0.5, 0], [0, 0.25, 0.75], [0, 0, 1], [0, 0, 0]]))


def test_classes_end_at_gaps_or_edges():
    volume = numpy.zeros(256)
    volume[[10, 15, 100, 102]] = [1, 3, 2, 2]
    assert [(one.grades, one.mean_g_cm3) for one in density_classes(volume)] == [
        ([10, 15], pytest.approx(0.11)), ([100, 102], pytest.approx(0.808))]
    assert [one.grades for one in density_classes(volume, [0.1, 0.81])] == [[10], [15, 100], [102]]


def test_specific_energies_of_laws():
    energies = specific_energies(LAW)
    assert energies[225] == pytest.approx(150) and energies[0] == 0 and energies[251] == 0
    assert energies[75] == pytest.approx(150 / 9)
    table = {**LAW, "cutting.specific_energy_table": [{"density_g_cm3": 0.4, "energy_j_mm3": 0.1},
                                                      {"density_g_cm3": 0.8, "energy_j_mm3": 0.3}]}
    assert specific_energies(table)[[25, 75, 200]] == pytest.approx([100, 200, 300])
    twice = {**LAW, "bone.density.ash_slope_g_cm3_per_hu": 0.0014, "bone.density.ash_offset_g_cm3": -0.018}
    assert grade_densities(twice, LAW)[[100, 200]] == pytest.approx([1.6, 2]), "at most 2"


def test_nonnegative_least_squares_meets_the_conditions_of_the_minimum():
    """Those of Karush, Kuhn and Tucker, which only the minimum meets."""
    random, bound, unknowns = numpy.random.RandomState(25), 0, 0
    for n in range(300):
        columns = 2 + n % 7
        a = random.standard_normal((columns + 3, columns))
        for c in range(1, columns):  # columns that resemble each other: unknowns that were freed early go back to 0
            a[:, c] = 0.8 * a[:, c - 1] + 0.6 * a[:, c]
        if n % 3 == 0:
            a[:, -1] *= 1e6
        y = a.sum(axis=1) + 4 * random.standard_normal(columns + 3)
        x = nonnegative(a, y)
        gradient = (a.T @ (a @ x - y)) / numpy.sqrt((a ** 2).sum(axis=0))
        small = 1e-9 * numpy.sqrt((y ** 2).sum())
        assert (x >= 0).all() and (abs(gradient[x > 0]) < small).all() and (gradient[x == 0] >= -small).all()
        bound, unknowns = bound + int((x == 0).sum()), unknowns + columns
    assert unknowns / 4 < bound < 3 * unknowns / 4
    a = numpy.array([[1, 0, 2], [1, 0, 1], [0, 0, 1]])
    assert nonnegative(a, numpy.array([5, 3, 2])) == pytest.approx([1, 0, 2]), "a column of zeros"


@pytest.mark.parametrize("place", [0.0, 0.7, 3.3333, 10.0])
def test_minimum_is_found_to_the_last_digits(place):
    found = minimum(lambda x: ((x - place) ** 4 + (x - place) ** 2, 4 * (x - place) ** 3 + 2 * (x - place)), 0, 10, 40)
    assert found == pytest.approx(place, abs=1e-8 if place in (0, 10) else 1e-13)
    assert 0 < found < 10
