# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Sobol indices, quantiles and bands against closed forms."""

import json
import pathlib

import numpy
import pytest
from reamsim.lab.sensitivity import SobolIndices, dominant_inputs, sobol_indices
from reamsim.lab.uncertainty import Design, evaluate
from scipy.stats import qmc


def points(model, a, b):
    """Outputs of A, B and the mixed samples, shape (samples, outputs)."""
    mixed = numpy.stack([model(numpy.where(numpy.arange(a.shape[1]) == i, b, a)) for i in range(a.shape[1])])
    return model(a), model(b), mixed


def halves(dimensions, exponent):
    both = qmc.Sobol(2 * dimensions, scramble=True, seed=7).random_base2(exponent)
    return both[:, :dimensions], both[:, dimensions:]


def test_indices_of_the_ishigami_function():
    """sin x + 7 sin² y + 0.1 z⁴ sin x of x, y, z uniform in ±π (Ishigami and Homma 1990): closed forms of all indices."""
    def model(unit):
        x, y, z = (numpy.pi * (2 * unit - 1)).T
        return (numpy.sin(x) + 7 * numpy.sin(y) ** 2 + 0.1 * z ** 4 * numpy.sin(x))[:, None]

    found = sobol_indices(*points(model, *halves(3, 14)))
    pi4 = numpy.pi ** 4
    x, y, xz = 0.5 * (1 + 0.1 * pi4 / 5) ** 2, 49 / 8, 0.01 * pi4 ** 2 * (1 / 18 - 1 / 50)
    total = x + y + xz
    assert found.variance[0] == pytest.approx(total, rel=0.01)
    assert found.first[:, 0] == pytest.approx([x / total, y / total, 0], abs=0.01)
    assert found.total[:, 0] == pytest.approx([(x + xz) / total, y / total, xz / total], abs=0.01)


def test_indices_of_a_product_and_of_one_input():
    """x·y·z of inputs with coefficients of variation c: V + 1 = Π(1 + c²), first order c²/V, total c²·Π'(1 + c²)/V."""
    mean, half = numpy.array([0.15, 0.5, 2.0]), numpy.array([0.1, 0.2, 0.4])
    squares = half ** 2 / (3 * mean ** 2)
    variance = numpy.prod(1 + squares) - 1

    def model(unit):
        x = mean + half * (2 * unit - 1)
        return numpy.stack([1000 * x.prod(axis=1), x[:, 0]], axis=1)

    found = sobol_indices(*points(model, *halves(3, 13)))
    assert found.first[:, 0] == pytest.approx(squares / variance, abs=0.01)
    assert found.total[:, 0] == pytest.approx(squares * (1 + variance) / (1 + squares) / variance, abs=0.01)
    assert found.first[:, 1] == pytest.approx([1, 0, 0], abs=0.01)
    assert dominant_inputs(found, 0, ["u0", "k_n", "depth"]).startswith("u0 (")


def test_intervals_have_the_true_indices():
    """u·(1 + x/2) of inputs in ±1: in independent samples the intervals have the true indices in 95 % of all cases."""
    random, trials = numpy.random.RandomState(5), 400
    within = numpy.zeros((2, 2))
    for _ in range(trials):
        a, b = 2 * random.random_sample((2, 64, 2)) - 1
        found = sobol_indices(*points(lambda x: (x[:, 0] * (1 + 0.5 * x[:, 1]))[:, None], a, b))
        within[0] += abs(found.first[:, 0] - [12 / 13, 0]) <= found.first_error[:, 0]
        within[1] += abs(found.total[:, 0] - [1, 1 / 13]) <= found.total_error[:, 0]
    assert within / trials == pytest.approx(numpy.full((2, 2), 0.95), abs=0.05)


def test_sentences():
    one = SobolIndices(*(numpy.array([[value]]) for value in (1.02, 1.01, 0.06, 0.03)), numpy.array([1.0]))
    assert dominant_inputs(one, 0, ["depth"]) == "depth (102 ± 6 % of the variance alone, 101 ± 3 % in total) dominates"
    constant = sobol_indices(*points(lambda x: numpy.full((len(x), 1), 3.0), *halves(2, 6)))
    assert constant.first.tolist() == [[0], [0]]
    assert dominant_inputs(constant, 0, ["a", "b"]) == "the output does not vary"
    with pytest.raises(ValueError):
        sobol_indices(numpy.zeros((1, 1)), numpy.zeros((1, 1)), numpy.zeros((1, 1, 1)))


COLUMNS = ("frame,time_s,tool_qw,tool_qx,tool_qy,tool_qz,axial_force_n,spin_torque_nmm,energy_mj")


def log_of_run(folder: pathlib.Path, times, force):
    folder.mkdir(parents=True)
    rows = [f"{i},{time},1,0,0,0,{force * time},{-2 * force * time},{force}" for i, time in enumerate(times)]
    (folder / "forces.csv").write_text("\n".join([COLUMNS, *rows]) + "\n")
    return folder


def test_bands_and_tails_of_runs(tmp_path):
    """Peaks, energies and bands of runs whose force is x·t, from their logs."""
    a, b = numpy.array([[0.1], [0.9], [0.5], [0.3]]), numpy.array([[0.2], [0.6], [0.95], [0.05]])
    unit = numpy.concatenate([a, b])
    times = numpy.linspace(0, 1, 11)
    runs = [log_of_run(tmp_path / f"{i}", times, 10 * x) for i, (x,) in enumerate(unit)]
    run_of = numpy.array([0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7])  # the mixed sample of one input is B
    numbers = [{"removed_mm3": float(x), "same": 1.0, **({"rare": 1.0} if i else {})} for i, (x,) in enumerate(unit)]
    found = evaluate(Design(["x"], unit, runs, run_of, [], numpy.empty((12, 0)), [], numbers))
    assert found.outputs == ["peak_axial_force_n", "peak_spin_torque_nmm", "energy_mj", "removed_mm3"]
    assert found.samples[:, 0] == pytest.approx(10 * unit[:, 0])
    assert found.samples[:, 1] == pytest.approx(20 * unit[:, 0])
    assert found.samples[:, 2] == pytest.approx(110 * unit[:, 0])
    assert found.time_s == pytest.approx(times[1:])
    assert found.axial_force_n == pytest.approx(10 * numpy.outer([0.05, *times[2:]], unit[:, 0]))
    assert found.low[0, 3] == pytest.approx((0.1 + 0.05) / 2), "0.2 itself is not below"
    assert found.high[0, 3] == pytest.approx((0.9 + 0.95) / 2)
    assert json.dumps(found.indices.first.tolist())


def test_a_shorter_run_has_no_force_after_its_end(tmp_path):
    """An interval without a frame has the mean of the one before, up to the end of its run."""
    runs = [log_of_run(tmp_path / "a", [0, 1, 2, 3, 4], 1.0), log_of_run(tmp_path / "b", [0, 2], 1.0)]
    unit = numpy.array([[0.1], [0.9], [0.1], [0.9]])
    found = evaluate(Design(["x"], unit, runs, numpy.array([0, 1, 0, 1, 0, 1]), [], numpy.empty((6, 0)), [], [{}, {}]))
    assert found.axial_force_n[:, 0].tolist() == [0.5, 2, 3, 4]
    assert found.axial_force_n[:, 1].tolist() == [0, 2, 0, 0]
