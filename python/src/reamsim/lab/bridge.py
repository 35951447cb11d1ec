# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The commands that the program calls, each with a job (a dict from JSON) and an answer (``say``, ``warn``). The program
has validated options, inputs and folders before; it resolves scenarios, and a job has what followed from them."""

from __future__ import annotations

import math
import pathlib
from typing import Any

import numpy

from .force_model import ForceBasis
from .tables import aligned, draw_with_script, json_text, replace_file, write_csv

Job = dict[str, Any]


def fit(job: Job, folder: str, file: str, output: str, residuals: str) -> Job:
    """`reamsim fit`."""
    from .fit import fit_forces

    basis = ForceBasis.read(folder)
    time_s = numpy.array(job["time_s"])
    measured = {column: numpy.array(values, dtype=float) for column, values in job["measured"].items()}
    found = fit_forces(basis, job["law"], time_s, measured, model=job["model"], class_edges_g_cm3=job["class_edges_g_cm3"],
                       fit_normal_ratio=job["fit_normal_ratio"], file=file, limits=job["limits"])
    if output:
        replace_file(output, json_text({"program": job["program"], "model": job["model"], **_fit_json(found)}))
    if residuals:
        _write_residuals(residuals, basis, found, time_s, measured)
    return {"say": _tables(found, job["model"]) + found.statements, "warn": found.warnings}


def _fit_json(found: Any) -> Job:
    keys = ("name", "value", "standard_error", "unit", "fitted", "at_bound")
    out: Job = {"constants": [{key: getattr(one, key) for key in keys} for one in found.constants],
                "covariance_of": [found.constants[place].name for place in found.free]}
    if found.free:
        out["covariance"] = found.covariance.tolist()
    out["classes"] = [{key: value for key, value in vars(one).items() if key != "grades"} for one in found.classes]
    out["residuals"] = [vars(one) for one in found.residuals]
    return {**out, "statements": found.statements, "warnings": found.warnings}


def _write_residuals(path: str, basis: ForceBasis, found: Any, time_s: numpy.ndarray, measured: dict[str, Any]) -> None:
    """Measured, fitted and residual of every column, at the measured times within those of the run."""
    from .least_squares import frame_weights

    weights = frame_weights(basis.time_s, time_s)
    known = numpy.asarray(weights.sum(axis=1)).ravel() > 0
    header, columns = ["time_s"], [time_s]
    for column, values in measured.items():
        fitted = (weights @ basis.values(column, found.coefficients))[:, 0]
        header += [column, f"fitted_{column}", f"residual_{column}"]
        columns += [values, fitted, values - fitted]
    write_csv(path, header, numpy.stack(columns, axis=1)[known].tolist())


def _tables(found: Any, model: str) -> list[str]:
    constants = [["constant", "value", "standard error", "unit", ""]]
    for i, one in enumerate(found.constants):
        note = "not fitted: that of the run" if not one.fitted else "at its bound" if one.at_bound else ""
        if model == "classes" and i < len(found.classes):
            note += f"{found.classes[i].least_g_cm3:.3f} to {found.classes[i].most_g_cm3:.3f} g/cm3"
        error = "-" if math.isnan(one.standard_error) else f"{one.standard_error:.2g}"
        constants.append([one.name, f"{one.value:.6g}", error, one.unit, note])
    residuals = [["column", "samples", "RMS measured", "RMS residual", "R2"]]
    residuals += [[one.column, str(one.samples), f"{one.rms_measured:.4g}", f"{one.rms:.3g}", f"{one.r_squared:.5f}"]
                  for one in found.residuals]
    return aligned(constants) + aligned(residuals)


def uq(job: Job, folder: str) -> Job:
    """`reamsim uq`, after its runs are simulated."""
    from . import uq_figure
    from .sensitivity import dominant_inputs
    from .uncertainty import Design, evaluate

    dir = pathlib.Path(folder)
    points = numpy.array(job["points"], dtype=float)
    inputs, constants = job["inputs"], job["constants"]
    unit = points[:2 * job["n"], 1:1 + len(inputs)]
    found = evaluate(Design(inputs, unit, [dir / "runs" / name for name in job["runs"]], points[:, 0].astype(int), constants,
                            points[:, 1 + len(inputs):], job["laws"], job["numbers"]))
    quantiles = numpy.quantile(found.samples, (0.05, 0.5, 0.95), axis=0)
    dominant = [dominant_inputs(found.indices, i, inputs) for i in range(len(found.outputs))]
    bands = {name: dict(zip(("p05", "p50", "p95"), numpy.quantile(values, (0.05, 0.5, 0.95), axis=1)))
             for name, values in (("axial_force", found.axial_force_n), ("spin_torque", found.spin_torque_nmm))}
    header = [f"{name}_{part}" for name in ("axial_force_n", "spin_torque_nmm") for part in ("p05", "p50", "p95")]
    columns = [found.time_s, *(values for band in bands.values() for values in band.values())]
    write_csv(dir / "uq.csv", ["time_s", *header], numpy.stack(columns, axis=1).tolist())
    outputs = {name: {"p05": p05, "p50": p50, "p95": p95, "dominant": sentence, "inputs": _indices_json(found, inputs, i)}
               for i, (name, (p05, p50, p95), sentence) in enumerate(zip(found.outputs, quantiles.T.tolist(), dominant))}
    replace_file(dir / "uq.json", json_text({"program": job["program"], "runs": len(job["runs"]), "samples": len(unit),
                                             "outputs": outputs}))
    data = {"time_s": found.time_s.tolist()}
    for i, (name, band) in enumerate(bands.items()):
        effects = [list(row) for row in zip(inputs, found.low[:, i].tolist(), found.high[:, i].tolist())]
        data[name] = {**{part: values.tolist() for part, values in band.items()}, "mean": float(found.samples[:, i].mean()),
                      "inputs": effects}
    draw_with_script(uq_figure, data, folder, "uq")
    say = [f"{name}: {p50:.4g} {unit} (5 to 95 %: {p05:.4g} to {p95:.4g}); {sentence}" for name, unit, (p05, p50, p95), sentence
           in zip(found.outputs, ("N", "N mm", "mJ"), quantiles.T, dominant)]
    say.append("±: 95 % sampling error of an index as of independent samples (those of sobol scatter less), by which it may "
               "exceed 100 %; a larger sample.n lowers it")
    return {"say": say}


def _indices_json(found: Any, inputs: list[str], output: int) -> Job:
    values = {"first_order": found.indices.first, "first_order_error": found.indices.first_error,
              "total": found.indices.total, "total_error": found.indices.total_error,
              "mean_in_lowest_fifth": found.low, "mean_in_highest_fifth": found.high}
    return {name: {key: float(of_key[i, output]) for key, of_key in values.items()} for i, name in enumerate(inputs)}


def effects(job: Job, folder: str) -> Job:
    """Figure and table of `reamsim sweep run` and `collect`. Answers ``table``, lines for the terminal, and ``effects``: null
    where there are none, otherwise what to say of parameters that the figure leaves out."""
    from .effects import MOST_PARAMETERS, Column, figure_data, main_effects, study_table, write_table

    parameters = [Column(one["key"], one["title"], one["cells"], one["shown"],
                         None if one["numbers"] is None else numpy.array(one["numbers"])) for one in job["parameters"]]
    results = [Column(one["key"], one["title"], numbers=numpy.array(one["numbers"], dtype=float), unit=one["unit"])
               for one in job["results"]]
    done = [i for i, state in enumerate(job["states"]) if state == "done"]
    found = main_effects([one.of(done) for one in parameters], [one.of(done) for one in results])
    names = [f"{number:2} {state}" for number, state in zip(job["numbers"], job["states"])]
    table = study_table(names, job["all"], parameters, results, found, len(done), job["width"])
    if not found:
        return {"table": table, "effects": None}
    from . import effects_figure

    write_table(folder, found)
    draw_with_script(effects_figure, figure_data(found), folder, "effects")
    count, most = len(found.parameters), MOST_PARAMETERS
    more = f" ({most} of {count} parameters, those that explain most)" if count > most else ""
    return {"table": table, "effects": more}


def validate(job: Job, file: str, folder: str = "") -> Job:
    """`reamsim validate`, after its runs are collected; without a folder, before them, the mistakes of the published numbers."""
    from . import validation_figure
    from .validation import compare, figure_data, read_published

    if not folder:
        read_published(file, job["parameters"])
        return {}
    found, name = compare(file, folder, job["parameters"]), "comparison"
    header = [*found.rows[0].place, "result", "unit", "value", "low", "high", "model", "simulated", "verdict", "verdict_of_model"]
    table, say = [], []
    lines = [["published", "", *(f"({m + 1})" for m in range(len(found.models)))]]
    lines += [[" ".join([*row.place.values(), row.result]), f"{row.low:.4g} to {row.high:.4g} {row.unit}"] for row in found.rows]
    for m, model in enumerate(found.models):
        verdicts, whole = found.verdicts(m)
        for r, (row, value) in enumerate(zip(found.rows, found.simulated[:, m])):
            ends = ["" if math.isinf(end) else end for end in (row.low, row.high)]
            table.append([*row.place.values(), row.result, row.unit, row.value, *ends, model, value, verdicts[r], whole])
            lines[r + 1].append(f"{value:.4g} {dict(agrees=' ', contradicts='!').get(verdicts[r], '?')}")
        say.append(f"({m + 1}) {model}: {whole} ({verdicts.count('agrees')} of {len(verdicts)} values in their interval)")
    write_csv(f"{folder}/{name}.csv", header, table)
    draw_with_script(validation_figure, figure_data(found, name), folder, name)
    return {"say": [found.title, *aligned(lines), "! outside the interval by more than half of its width; ? by less, or null", *say]}


COMMANDS = {"fit": fit, "uq": uq, "effects": effects, "validate": validate}
