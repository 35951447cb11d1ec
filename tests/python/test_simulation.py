# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""reamsim.Simulation gives what `reamsim run` gives, and no input or interruption harms the process."""

import os
import pathlib
import signal
import subprocess
import sys
import threading

import numpy
import pytest
import reamsim
from conftest import BLOCK, ROOT

STANDING = ([0, 0, 0], [1, 0, 0, 0], 250)


@pytest.fixture(scope="module")
def block_run(tmp_path_factory):
    return reamsim.run(BLOCK, tmp_path_factory.mktemp("runs") / "block")


def values_of(rows):
    """Numbers of steps, or of a table."""
    if isinstance(rows, list):
        return numpy.array([tuple(row) for row in rows], dtype=float)
    return numpy.stack([numpy.asarray(rows[name], dtype=float) for name in columns_of(rows)], axis=1)


def columns_of(table):
    return list(table.dtype.names) if isinstance(table, numpy.ndarray) else list(table.columns)


def message_of(call, *arguments, error=reamsim.InputError, **keywords):
    with pytest.raises(error) as raised:
        call(*arguments, **keywords)
    return str(raised.value)


def test_steps_give_the_forces_of_a_run_without_windows(block, tmp_path, monkeypatch):
    monkeypatch.setenv("REAMSIM_ENGINE_TUNING", "windows=false")
    run = reamsim.run(block, tmp_path / "run")
    simulation = reamsim.Simulation(block)
    poses = simulation.planned_poses()
    steps = [simulation.start(*poses[0])] + [simulation.step(*pose) for pose in poses[1:]]
    assert [name.rstrip("_") for name in reamsim.Step._fields] == list(run.force_array.dtype.names)
    assert numpy.array_equal(values_of(steps), values_of(run.force_array))
    assert max(step.axial_force_n for step in steps) > 1
    assert type(steps[0].frame) is int and steps[9].force_n.tolist() == list(steps[9][12:15])


def test_a_run_of_poses_gives_the_forces_of_a_run(block, block_run):
    simulation = reamsim.Simulation(block)
    poses = simulation.planned_poses()
    table = simulation.run(poses)
    assert type(table) is type(block_run.forces) and columns_of(table) == columns_of(block_run.forces)
    assert numpy.array_equal(values_of(table), values_of(block_run.force_array))
    stepwise = reamsim.Simulation(block)
    stepwise.run(poses[:150])
    assert stepwise.step(*poses[150]) != tuple(values_of(table)[150]), "windows make a difference, so that this test counts"
    assert table["frame"].dtype == numpy.int64
    replayed = reamsim.Simulation(block).run(block_run.forces)
    assert numpy.array_equal(values_of(replayed), values_of(table))


def test_a_shipped_scenario_by_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    keys = {"device": "serial", "bone__voxel_mm": 1, "motion__frame_rate_hz": 50, "motion__plunge__feed_mm_s": 5}
    named = reamsim.Simulation("half_space", **keys)
    given = reamsim.Simulation(ROOT / "trajectories/half_space.yaml", **keys)
    assert numpy.array_equal(values_of(named.run(named.planned_poses())), values_of(given.run(given.planned_poses())))
    message = message_of(reamsim.Simulation, "nonsense")
    assert message.startswith("nonsense: no such file, and no shipped scenario of this name; expected a file (YAML) or one of")
    assert "default" in message
    pathlib.Path("half_space").write_text("version: 2\n")
    assert "bone: missing" in message_of(reamsim.Simulation, "half_space"), "what exists is a path"


def test_all_forms_of_poses_are_the_same(block):
    poses = reamsim.Simulation(block).planned_poses()[:80]
    rows = numpy.column_stack([poses.position_mm, poses.quaternion, poses.spin_rpm, poses.spin_angle_rad])
    named = {name: poses[name] for name in poses.dtype.names}
    given = [values_of(reamsim.Simulation(block).run(form)) for form in (poses, rows, rows.tolist(), named)]
    assert all(numpy.array_equal(values, given[0]) for values in given) and len(given[0]) == 80
    without_angle = values_of(reamsim.Simulation(block).run(rows[:, :8]))
    assert numpy.allclose(without_angle, given[0], rtol=1e-9, atol=1e-12), "the angle is integrated"


def test_fill_and_density_are_those_of_the_results(block, block_run):
    simulation = reamsim.Simulation(block)
    simulation.run(simulation.planned_poses())
    for grid, its in ((simulation.fill, block_run.fill), (simulation.density, block_run.density)):
        assert grid.values.shape == its.values.shape and min(grid.values.shape) > 12 and grid.values.dtype == numpy.float32
        assert numpy.allclose(grid.values, its.values, atol=1e-6) and grid.unit == its.unit
        assert numpy.allclose(grid.origin_mm, its.origin_mm) and grid.voxel_mm == its.voxel_mm
    lost_mm3 = (block_run.density.values > 0).sum() * 0.125 - simulation.fill.values.sum(dtype=float) * 0.125
    assert simulation.removed_mm3 == pytest.approx(lost_mm3, rel=1e-4)


def test_grids_are_read_only_and_do_not_change(block):
    simulation = reamsim.Simulation(block)
    poses = simulation.planned_poses()
    simulation.start(*poses[0])
    before = simulation.fill
    kept = before.values.copy()
    assert simulation.fill is before, "nothing has happened"
    for grid in (before, simulation.density):
        with pytest.raises(ValueError, match="read-only"):
            grid.values[0, 0, 0] = 0.5
        with pytest.raises(ValueError):
            grid.values.flags.writeable = True
    simulation.run(poses[1:])
    assert simulation.fill is not before and simulation.fill.values.sum() < before.values.sum()
    del simulation
    assert numpy.array_equal(before.values, kept), "it outlives the simulation"


def test_a_state_goes_back_in_time_also_from_a_file(block, tmp_path):
    simulation = reamsim.Simulation(block)
    poses = simulation.planned_poses()
    unstarted = simulation.state()
    simulation.run(poses[:200])
    state, removed_mm3 = simulation.state(), simulation.removed_mm3
    assert simulation.frame == 199 and simulation.pose == poses[199]
    first, fill = simulation.run(poses[200:370]), simulation.fill.values
    simulation.restore(state)
    assert simulation.frame == 199 and simulation.removed_mm3 == removed_mm3
    assert numpy.array_equal(values_of(simulation.run(poses[200:370])), values_of(first))
    assert numpy.array_equal(simulation.fill.values, fill)

    state.save(tmp_path / "step.state")
    other = reamsim.Simulation(block)
    other.restore(reamsim.State.load(tmp_path / "step.state"))
    assert other.pose == poses[199] and other.removed_mm3 == removed_mm3
    assert numpy.array_equal(values_of(other.run(poses[200:370])), values_of(first))
    other.state().save(tmp_path / "step.state")  # replaces it
    other.restore(reamsim.State.load(tmp_path / "step.state"))
    assert other.frame == 369 and numpy.array_equal(other.fill.values, fill)
    reamsim.State.load(tmp_path / "step.state").save(tmp_path / "copy.state")
    assert (tmp_path / "copy.state").read_bytes() == (tmp_path / "step.state").read_bytes()

    simulation.restore(unstarted)
    assert simulation.pose is None and simulation.removed_mm3 == 0
    assert numpy.array_equal(simulation.fill.values, reamsim.Simulation(block).fill.values)
    assert simulation.start(*poses[0]).frame == 0


def test_damaged_and_foreign_states_are_named(block, tmp_path):
    simulation = reamsim.Simulation(block)
    simulation.run(simulation.planned_poses()[:300])
    path = tmp_path / "s.state"
    simulation.state().save(path)
    whole = path.read_bytes()
    assert len(whole) > 10_000, "it has bricks"
    load = reamsim.State.load
    assert message_of(load, tmp_path / "none").startswith(f"{tmp_path / 'none'}: no such file; expected a state")
    for damaged in (whole[:-1], whole[:60], whole[:5000] + bytes([whole[5000] ^ 1]) + whole[5001:], whole + b"x"):
        path.write_bytes(damaged)
        assert "is damaged" in message_of(load, path)
    path.write_bytes(whole.replace(b"state 1", b"state 9", 1))
    assert "another version" in message_of(load, path)
    path.write_bytes(b"time_s,x_mm\n")
    assert "is no state of a simulation" in message_of(load, path)
    assert str(tmp_path / "no folder") in message_of(simulation.state().save, tmp_path / "no folder/s.state",
                                                     error=reamsim.RunError)
    denser = reamsim.Simulation(block, bone__phantom__density_g_cm3=0.7)
    assert message_of(denser.restore, simulation.state()) == "the state is one of another bone"
    path.write_bytes(whole)
    assert message_of(denser.restore, load(path)) == "the state is one of another bone"


def test_a_wrong_scenario_names_key_and_place(block, tmp_path):
    del block["tool"]
    with pytest.raises(reamsim.InputError) as raised:
        reamsim.Simulation(block, {"bone.voxel_mm": -1})
    assert len(raised.value.lines) == 2 and all("/tmp" not in line for line in raised.value.lines), raised.value
    assert "bone.voxel_mm" in str(raised.value) and "tool" in str(raised.value) and raised.value.status == 2
    assert str(tmp_path / "none.yaml") in message_of(reamsim.Simulation, tmp_path / "none.yaml")
    assert "no such device" in message_of(reamsim.Simulation, BLOCK, device="no such device")
    passes = ROOT / "trajectories/several_passes.yaml"
    assert "motion.passes" in message_of(reamsim.Simulation, passes, bone__voxel_mm=1)


def test_wrong_arguments_change_nothing(block):
    simulation = reamsim.Simulation(block)
    poses = simulation.planned_poses()
    for call in (simulation.step, simulation.peek):
        assert "call start()" in message_of(call, *poses[0])
    simulation.start(*poses[0])
    assert "start() has been called" in message_of(simulation.start, *poses[0])
    nan, unit = float("nan"), [1, 0, 0, 0]
    for arguments, found in (
            (([0, 0], unit, 0), "position_mm: found [0, 0]; expected 3 numbers"), ((5, unit, 0), "position_mm: found 5"),
            (([[0, 0, 0]], unit, 0), "position_mm"), (("abc", unit, 0), "position_mm: found 'abc'"),
            (([0, 0, "x"], unit, 0), "position_mm"), ((None, unit, 0), "position_mm: found None"),
            (([0, 0, nan], unit, 0), "not finite"), (([0, 0, 0], [1, 0, 0], 0), "quaternion: found [1, 0, 0]"),
            (([0, 0, 0], [0, 0, 0, 0], 0), "quaternion is no rotation"), (([0, 0, 0], [nan] * 4, 0), "no rotation"),
            (([0, 0, 0], unit, "fast"), "spin_rpm: found 'fast'; expected a number"), (([0, 0, 0], unit, nan), "not finite"),
            (([0, 0, 0], unit, 0, nan), "spin angle is not finite"), (([0, 0, 0], unit, 0, None, 0), "dt: a time above 0"),
            (([0, 0, 0], unit, 0, None, "1 s"), "dt_s: found '1 s'")):
        assert found in message_of(simulation.step, *arguments)
    with pytest.raises(TypeError):
        simulation.step([0, 0, 0])
    wrong = poses[:50].copy()
    wrong.position_mm[40, 2] = nan
    assert "not finite" in message_of(simulation.run, wrong)
    for rows, found in ((numpy.zeros((4, 7)), "(4, 7)"), (numpy.zeros(8), "(8,)"), ("poses", "poses"), (None, "poses"),
                        ({"tool_x_mm": [1]}, "no column tool_y_mm"), ([[1, 2], [3]], "poses")):
        assert found in message_of(simulation.run, rows)
    assert len(simulation.run(poses[:0])) == 0
    assert simulation.frame == 0 and simulation.pose == poses[0]
    fresh = reamsim.Simulation(block)
    fresh.start(*poses[0])
    assert fresh.step(*poses[1]) == simulation.step(*poses[1])


def test_peek_is_the_step_that_follows(block):
    simulation = reamsim.Simulation(block)
    poses = simulation.planned_poses()
    simulation.run(poses[:200])
    removed_mm3 = simulation.removed_mm3
    peeked = simulation.peek(*poses[200])
    assert simulation.removed_mm3 == removed_mm3 and simulation.frame == 199
    done = simulation.step(*poses[200])
    assert done.removed_mm3 > 0 and peeked == done


def test_peek_has_the_substeps_of_the_step(block):
    simulation = reamsim.Simulation(block)
    simulation.start([0, 0, 1], [1, 0, 0, 0], 250)
    for place, dt_s in (([0, 0, -3], 0.5), ([2, 0, -4], 2.0)):
        peeked = simulation.peek(place, [1, 0, 0, 0], 250, dt_s=dt_s)
        done = simulation.step(place, [1, 0, 0, 0], 250, dt_s=dt_s)
        assert done.removed_mm3 > 0 and peeked == done


def test_warnings_of_the_simulator_are_warnings_of_python(block):
    simulation = reamsim.Simulation(block)
    with pytest.warns(reamsim.ReamsimWarning, match="starts in the bone") as caught:
        simulation.start([0, 0, -1], [1, 0, 0, 0], 250)
    assert caught[0].filename == __file__, "it names the caller"
    with pytest.warns(reamsim.ReamsimWarning, match="spindle speed is zero"):
        simulation.step([0, 0, -1.2], [1, 0, 0, 0], 0)


def test_planned_poses_of_a_push_are_warned_of(block):
    block["motion"] = {"frame_rate_hz": 500, "push": {"thrust_n": 60, "depth_mm": 1}}
    with pytest.warns(reamsim.ReamsimWarning, match="motion.push: without a hand here"):
        simulation = reamsim.Simulation(block)
    assert len(simulation.planned_poses()) > 10


def test_simulations_do_not_meet(block):
    """Two with different voxels, steps in turn, give what each gives alone."""
    coarse = {"bone__voxel_mm": 0.8, "device": "serial"}
    pair = [reamsim.Simulation(block), reamsim.Simulation(block, **coarse)]
    poses = pair[0].planned_poses()[:150]
    alone = [reamsim.Simulation(block), reamsim.Simulation(block, **coarse)]
    in_turn = [[s.start(*poses[0]) for s in pair]] + [[s.step(*pose) for s in pair] for pose in poses[1:]]
    for i, simulation in enumerate(alone):
        expected = [simulation.start(*poses[0])] + [simulation.step(*pose) for pose in poses[1:]]
        assert [row[i] for row in in_turn] == expected
    assert in_turn[-1][0] != in_turn[-1][1]


def descent(simulation, frames):
    """Poses that go 1.5 mm into the bone, in many small steps."""
    poses = numpy.repeat(simulation.planned_poses()[:1], frames).view(numpy.recarray)
    poses.position_mm[:, 2] = numpy.linspace(0.1, -1.5, frames)
    poses.spin_angle_rad = numpy.linspace(0, 1, frames)
    return poses


def test_other_threads_go_on_while_it_computes(block):
    """A second thread sees that the first one computes, so it does not hold the interpreter."""
    simulation = reamsim.Simulation(block)
    done = []
    worker = threading.Thread(target=lambda: done.append(simulation.run(descent(simulation, 5_000))))
    worker.start()
    refused = 0
    while worker.is_alive():
        try:
            simulation.frame
        except reamsim.InputError as error:
            assert "use one thread at a time" in str(error)
            refused += 1
    worker.join()
    assert refused > 0 and len(done[0]) == 5_000 and simulation.frame == 4_999


def test_an_interrupt_ends_a_run_between_two_frames(block):
    simulation = reamsim.Simulation(block)
    poses = descent(simulation, 400_000)

    def interrupt_while_it_computes():
        try:
            while True:
                simulation.frame
        except reamsim.InputError:
            os.kill(os.getpid(), signal.SIGINT)

    other = threading.Thread(target=interrupt_while_it_computes, daemon=True)
    with pytest.raises(KeyboardInterrupt):
        other.start()
        simulation.run(poses)
    other.join()
    stopped = simulation.frame
    assert 0 <= stopped < 399_999 and simulation.pose.position_mm[2] == poses.position_mm[stopped, 2]
    more = simulation.run(poses[stopped + 1:stopped + 101])
    assert list(more["frame"]) == list(range(stopped + 1, stopped + 101))


def test_a_fork_is_refused_and_harms_nobody(block):
    simulation = reamsim.Simulation(block)
    simulation.start(*STANDING)
    child = os.fork()
    if child == 0:
        try:
            reamsim.Simulation(BLOCK)
            os._exit(1)
        except reamsim.RunError as error:
            if "spawn" not in str(error):
                os._exit(2)
        try:
            simulation.step(*STANDING)
        except reamsim.RunError:
            del simulation
            os._exit(0)
        os._exit(3)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert simulation.step(*STANDING).frame == 1


# One statement, whatever the module is called (openvdb since OpenVDB 11).
OPENVDB = "import importlib.util, importlib; pyopenvdb = importlib.import_module('pyopenvdb' if importlib.util.find_spec('pyopenvdb') else 'openvdb')"


@pytest.mark.parametrize("first", ["pyopenvdb", "simulation"])
def test_pyopenvdb_works_in_the_same_process(first, block_run, tmp_path):
    """Both use libopenvdb and TBB, in either order."""
    code = f"""
import sys
import numpy, reamsim
if {first!r} == "pyopenvdb":
    {OPENVDB}
simulation = reamsim.Simulation({{**{BLOCK!r}, "bone": {{"source": "vdb", "vdb": {{"path": {str(block_run.dir / "reamed.vdb")!r}}}}}}})
reamed = simulation.fill.values
assert ((reamed > 0) & (reamed < 1)).sum() > 100, "it is the bone of that run"
simulation = reamsim.Simulation({BLOCK!r})
simulation.run(simulation.planned_poses()[:300])
{OPENVDB}
grid = pyopenvdb.FloatGrid()
grid.copyFromArray(numpy.ascontiguousarray(simulation.fill.values))
pyopenvdb.write("fill.vdb", grids=[grid])
back = numpy.empty(simulation.fill.values.shape, dtype=numpy.float32)
pyopenvdb.read("fill.vdb", "").copyToArray(back)
assert numpy.array_equal(back, simulation.fill.values) and simulation.removed_mm3 > 1
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_module_of_another_version_is_refused(monkeypatch):
    from reamsim import simulation

    present = simulation.__version__
    simulation.simulation_module.cache_clear()
    monkeypatch.setattr(simulation, "__version__", "0.0.9")
    try:
        message = message_of(reamsim.Simulation, BLOCK, error=reamsim.ProgramNotFound)
    finally:
        simulation.simulation_module.cache_clear()
    assert f"of version {present}, and this package of version 0.0.9" in message
