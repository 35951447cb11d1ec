# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""blender -b --factory-startup --python-exit-code 1 --python blender_results.py -- RESULTS: what Blender makes of
RESULTS/reamed.vdb, reamed.stl and reamed.glb: grids, sizes and places, in mm in the bone's frame."""

import json
import pathlib
import sys

import bpy
import numpy as np


class Mesh:
    """Vertices (n, 3) and triangles (m, 3) of a Blender object with its modifiers, in the world's coordinates."""

    def __init__(self, thing):
        made = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        mesh = made.to_mesh()
        mesh.calc_loop_triangles()
        matrix = np.array(thing.matrix_world)
        vertices = np.array([v.co[:] for v in mesh.vertices])
        self.vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        self.triangles = np.array([t.vertices[:] for t in mesh.loop_triangles])
        self.low, self.high = self.vertices.min(0), self.vertices.max(0)

    def volume(self):
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        return abs(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6


def expect_near(what, found, wanted, tolerance):
    if not np.all(np.abs(np.asarray(found) - np.asarray(wanted)) <= tolerance):
        raise AssertionError(f"{what}: found {found}, expected {wanted} to within {tolerance}")
    print(f"{what}: {found}, expected {wanted} to within {tolerance}")


def mesh_of_grid(volume, name, threshold):
    volume.data.grids.active_index = [grid.name for grid in volume.data.grids].index(name)
    bpy.ops.mesh.primitive_cube_add()
    thing = bpy.context.object
    modifier = thing.modifiers.new("surface", "VOLUME_TO_MESH")
    modifier.object, modifier.grid_name, modifier.threshold = volume, name, threshold
    modifier.resolution_mode = "GRID"
    return Mesh(thing)


def check_volume(path, bone, bone_mm3, voxel_mm):
    bpy.ops.object.volume_import(filepath=str(path))
    volume = bpy.context.object
    grids = volume.data.grids
    assert grids.load(), grids.error_message
    names = sorted(grid.name for grid in grids)
    assert names == ["density", "fill", "removed_frame", "surface"], names
    for grid in grids:
        expect_near(f"voxels of {grid.name}, mm", np.diag(np.array(grid.matrix_object))[:3], voxel_mm, 1e-6)
    surface = mesh_of_grid(volume, "surface", 0.0)
    expect_near("surface, lower corner, mm", surface.low, bone.low, voxel_mm)
    expect_near("surface, upper corner, mm", surface.high, bone.high, voxel_mm)
    expect_near("volume within surface, mm3", surface.volume(), bone_mm3, 0.01 * bone_mm3)
    density = mesh_of_grid(volume, "density", 0.1)
    # Blender's blocks end up to a voxel farther out; reaming has taken nothing of the bone's far ends.
    expect_near("density, lower corner, mm", density.low, bone.low, 2 * voxel_mm)
    expect_near("density, upper corner, mm", density.high, bone.high, 2 * voxel_mm)


def main():
    results = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
    summary = json.loads((results / "summary.json").read_text())["bone"]
    bone_mm3, voxel_mm = summary["bone_after_mm3"], summary["voxel_mm"]
    bpy.ops.import_mesh.stl(filepath=str(results / "reamed.stl"), axis_forward="Y", axis_up="Z")
    bone = Mesh(bpy.context.object)
    expect_near("volume of reamed.stl, mm3", bone.volume(), bone_mm3, 0.005 * bone_mm3)
    # As docs/guide/pictures.md says: with another shading, Debian 12's Blender 3.4.1 asks its NumPy 1.24 for a name that it no
    # longer has, and imports no glTF at all.
    bpy.ops.import_scene.gltf(filepath=str(results / "reamed.glb"), import_shading="SMOOTH")
    colors = [thing for thing in bpy.context.selected_objects if thing.type == "MESH"][0].data.color_attributes
    assert len(colors) == 1 and len(np.unique([c.color[:] for c in colors[0].data], axis=0)) > 10, "no depth colours"
    glb = Mesh([thing for thing in bpy.context.selected_objects if thing.type == "MESH"][0])
    expect_near("reamed.glb, lower corner, mm", glb.low, bone.low, 1e-3)
    expect_near("reamed.glb, upper corner, mm", glb.high, bone.high, 1e-3)
    expect_near("volume of reamed.glb, mm3", glb.volume(), bone_mm3, 0.005 * bone_mm3)
    check_volume(results / "reamed.vdb", bone, bone_mm3, voxel_mm)


main()
