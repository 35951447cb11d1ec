# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""For each numeric key of the schema, a scenario of few voxels and frames in which it applies.

SECTIONS: what a section of the schema needs, beside BASE. A section that is not listed fails the test: list it.
KEYS: what a key needs in addition, or one end of a key ("KEY@min", "KEY@max"), so that the run stays small and no
other key's limit is met. DIRECTED: the same by value, for components of vectors. A new key runs in its section's
scenario until it needs more.
"""

import math

from range_inputs import POSES, cube, cylinder, scan

# Coarse and short. Tool and bone meet in it, so that numbers have something to act on.
BASE = {
    "version": 2,
    "bone": {"source": "phantom", "voxel_mm": 0.5, "phantom": {"shape": "half_space", "size_mm": [10, 10, 6]}},
    "tool": {"mesh": "tool.obj"},
    "motion": {
        "frame_rate_hz": 100,
        "plunge": {
            "approach_mm": 0.5, "feed_mm_s": 10, "depth_mm": 1, "dwell_s": 0, "retract_mm": 1, "retract_mm_s": 20,
            "spin_rpm": 250,
        },
    },
    "render": {"enabled": False},
    "output": {"vti": False, "meshes": False, "plots": False},
}
FILES = {"tool.obj": cylinder(4, 6), "poses.csv": POSES}

HALF = 10.0  # half the side of the cube that stands for a scanned bone, mm


def implant(**more):
    return {"metrics": {"implant": {"backside_radius_mm": 30, "diameter_mm": 6, **more}}}


def shape(name, **more):
    return {"bone": {"phantom": {"shape": name, "size_mm": None, **more}}}


GLENOID = {
    "bone": {"side": "left", "voxel_mm": 1, "phantom": {"shape": "glenoid", "size_mm": None}},
    "motion": {"frame": "glenoid"},
}


def glenoid(**more):
    return merged(GLENOID, {"bone": {"phantom": more}})


def mesh_bone(middle=(0, 0, 0), **more):
    return {
        "bone": {"source": "mesh", "phantom": None, "voxel_mm": 2, "mesh": {"path": "bone.obj", **more}},
        "files": {"bone.obj": cube(2 * HALF, middle)},
    }


def ct_bone(middle=(0, 0, 0), bone=1000, air=-1000, **more):
    return {
        "bone": {"source": "ct", "phantom": None, "voxel_mm": 1, "ct": {"path": "scan.nrrd", **more}},
        "files": {"scan.nrrd": scan(middle, bone, air)},
    }


def labelled(bone=1000, **more):
    labels = {"path": "labels.nrrd", "label": 1, **more}
    return merged(ct_bone(bone=bone, label_map=labels), {"files": {"labels.nrrd": scan(bone=1, air=0)}})


def pictures(**more):
    small = {"enabled": True, "width_px": 64, "height_px": 64, "cameras": ["oblique"], "report": False}
    return {"render": {**small, "before_after": False, "contact_sheet": False, "every_frames": 1000, **more}}


def camera(**more):
    return pictures(user_cameras=[{"name": "own", "position_mm": [30, 20, 40], **more}])


def plunge(rate_hz, **more):
    return {"motion": {"frame_rate_hz": rate_hz, "plunge": more}}


def push(**more):
    """A push that ends after a tenth of a second at the latest."""
    hand = {"approach_mm": 0.1, "thrust_n": 20, "max_feed_mm_s": 10, "until": "time", "time_s": 0.1, "spin_rpm": 250, **more}
    return {"motion": {"plunge": None, "push": hand}}


def keyframes(first, last, rate_hz=100):
    keys = [{"time_s": 0, "position_mm": [0, 0, 0.5], "axis": [0, 0, 1], **first}]
    keys += [{"time_s": 0.2, "position_mm": [0, 0, -0.5], "axis": [0, 0, 1], **last}]
    keys = [{name: value for name, value in key.items() if value is not None} for key in keys]
    return {"motion": {"plunge": None, "frame_rate_hz": rate_hz, "keyframes": keys}}


def keyframe(value, **more):
    """More keys of the keyframe that has the value: the first at a minimum, else the last."""
    return keyframes(more, {}) if value < 0 else keyframes({}, more)


def cutting(**more):
    return {"cutting": more}


SIZE_EFFECT = {"size_effect": {"exponent": 0.3, "reference_mm": 0.05, "cutting_edges": 2}}
EDGE_FORCE = {"edge_force": {"tangential_n_mm": 1, "normal_n_mm": 0.5, "cutting_edges": 2}}
TABLE = {"specific_energy_table": [{"density_g_cm3": 0.5, "energy_j_mm3": 0.02}, {"density_g_cm3": 1.5, "energy_j_mm3": 0.1}]}
HOLE = {"bone": {"pilot_hole": {"diameter_mm": 2, "entry_mm": [0, 0, 0], "axis": [0, 0, -1], "depth_mm": 3}}}
SKIN = {"files": {"skin.obj": cube(30)}, "clearance": {"envelope": {"path": "skin.obj"}}}
SLOW = {"approach_mm": 0.001, "depth_mm": 0.001, "retract_mm": 0.001}


RECORDED = {"motion": {"plunge": None, "csv": {"path": "poses.csv"}}}


def rotated(section):
    """A rotation whose first row is an axis or its opposite."""
    def scene(component, value):
        rows = [axis((component + i) % 3, value if i == 0 else 1.0) for i in range(3)]
        rows[2] = [value * x for x in rows[2]]
        return merged(RECORDED, {"motion": {"csv": {section: {"rotation": rows}}}})

    return scene


def holder(**part):
    return {"tool": {"holder": [{"from_z_mm": 8, "to_z_mm": 40, "diameter_mm": 3, **part}]}}


def merged(base, patch):
    """`base` with the keys of `patch`, section by section; None removes a key."""
    out = dict(base)
    for key, value in patch.items():
        if value is None:
            out.pop(key, None)
        else:
            out[key] = merged(out.get(key) or {}, value) if isinstance(value, dict) else value
    return out


def axis(component, length=1.0):
    return [length if i == component else 0.0 for i in range(3)]


SECTIONS = {
    "": {},
    "bone": {},
    "bone.density": ct_bone(),
    "bone.glenoid": merged(mesh_bone(), {"bone": {"side": "left"}, "motion": {"frame": "glenoid"}}),
    "bone.glenoid.landmarks": merged(mesh_bone(), {"bone": {"side": "left"}, "motion": {"frame": "glenoid"}}),
    "bone.glenoid.version_landmarks": merged(
        glenoid(), {"bone": {"glenoid": {"version_landmarks": {"face_mm": [[0, 12, 0], [0, -12, 0], [0, 0, 15]]}}}}),
    "bone.phantom": {},
    "bone.ct": ct_bone(),
    "bone.ct.hu": ct_bone(hu={"slope": 1}),
    "bone.ct.label_map": labelled(),
    "bone.ct.cut_spheres": ct_bone(cut_spheres=[{"center_mm": [5, 5, 5], "radius_mm": 2}]),
    "bone.ct.cut_planes": ct_bone(cut_planes=[{"point_mm": [0, 0, 3], "normal": [0, 0, 1]}]),
    "bone.mesh": mesh_bone(),
    "bone.pilot_hole": HOLE,
    "tool": {},
    "tool.holder": holder(),
    "clearance": holder(),
    "clearance.envelope": merged(holder(), SKIN),
    "motion": {},
    "motion.plunge": {},
    "motion.push": push(),
    "motion.compliance": {"motion": {"compliance": {"stiffness_n_mm": [100, 100, 100]}}},
    "motion.keyframes": keyframes({}, {}),
    "motion.csv": RECORDED,
    "motion.csv.bone_from_tracker": RECORDED,
    "motion.csv.marker_from_tool": RECORDED,
    "engine": {},
    "cutting": {},
    "cutting.specific_energy_table": cutting(**TABLE),
    "cutting.size_effect": cutting(**SIZE_EFFECT),
    "cutting.edge_force": cutting(**EDGE_FORCE),
    "metrics": {},
    "metrics.implant": implant(),
    "metrics.implant.augment": implant(augment={"angle_deg": 15}),
    "metrics.implant.mesh": {
        "metrics": {"implant": {"backside_radius_mm": 0, "mesh": {"path": "implant.obj"}}}, "files": {"implant.obj": cylinder(3, 4)},
    },
    "metrics.implant.pegs": implant(pegs=[{"from_mm": [0, 0, 0.05], "to_mm": [0, 0.1, -3], "diameter_mm": 2}]),
    "render": pictures(),
    "render.user_cameras": camera(),
    "output": {},
}

PHANTOM = "bone.phantom."
KEYS = {
    "bone.ct.hu.intercept@min": ct_bone(hu={"slope": 100}),
    "bone.ct.hu.slope@min": ct_bone(threshold_hu=0.5),
    "motion.csv.skip_lines": merged(RECORDED, {"motion": {"csv": {"path": "late.csv"}}, "files": {"late.csv": "#\n" * 10000 + POSES}}),
    "bone.voxel_mm@min": merged(shape("half_space", size_mm=[0.5] * 3), plunge(1000, approach_mm=0.01, depth_mm=0.02, retract_mm=0.01)),
    PHANTOM + "size_mm@min": {"bone": {"voxel_mm": 0.1}},
    PHANTOM + "size_mm@max": {"bone": {"voxel_mm": 2}},
    PHANTOM + "radius_mm@min": merged(shape("sphere"), {"bone": {"voxel_mm": 0.1}}),
    PHANTOM + "radius_mm@max": merged(shape("sphere"), {"bone": {"voxel_mm": 5}}),
    PHANTOM + "cup_depth_mm@min": shape("cup", size_mm=[10, 10, 6]),
    PHANTOM + "cup_depth_mm@max": merged(shape("cup", size_mm=[1000, 1000, 505], radius_mm=500), {"bone": {"voxel_mm": 5}}),
    PHANTOM + "cortical_mm@min": shape("layered", size_mm=[10, 10, 6]),
    PHANTOM + "cortical_mm@max": merged(shape("layered", size_mm=[10, 10, 505]), {"bone": {"voxel_mm": 1}}),
    PHANTOM + "cortical_density_g_cm3": shape("layered", size_mm=[10, 10, 6]),
    PHANTOM + "trabecular_density_g_cm3": shape("layered", size_mm=[10, 10, 6]),
    PHANTOM + "height_mm@min": glenoid(width_mm=8),
    PHANTOM + "height_mm@max": glenoid(width_mm=40, face_radius_mm=60),
    PHANTOM + "width_mm@max": glenoid(height_mm=80, face_radius_mm=60),
    PHANTOM + "width_mm@min": glenoid(height_mm=12),
    PHANTOM + "face_radius_mm@min": glenoid(height_mm=25, width_mm=20),
    PHANTOM + "medialization_mm": glenoid(walch="A2", vault_depth_mm=100),
    PHANTOM + "wear_radius_mm": glenoid(walch="B2"),
    PHANTOM + "wear_direction_deg": glenoid(walch="B2"),
    PHANTOM + "wear_ridge_mm": glenoid(walch="B2", height_mm=80, width_mm=79, face_radius_mm=60, wear_radius_mm=60),
    PHANTOM + "wear_tilt_deg": glenoid(walch="B2"),
    PHANTOM + "rim_rounding_mm": glenoid(walch="C"),
    **{
        PHANTOM + key: GLENOID
        for key in (
            "face_radius_mm@max", "vault_depth_mm", "version_deg", "inclination_deg", "shell_mm",
            "subchondral_density_g_cm3", "subchondral_mm", "trabecular_gradient", "texture", "seed",
        )
    },
    "bone.ct.median_radius_voxels": merged(ct_bone(filter="median"), {"files": {"scan.nrrd": scan(side=48)}}),
    "bone.ct.anisotropic_iterations": ct_bone(filter="curvature_anisotropic"),
    "bone.ct.anisotropic_conductance": ct_bone(filter="curvature_anisotropic"),
    "bone.ct.threshold_hu@min": ct_bone(air=-3000),
    "bone.ct.threshold_hu@max": ct_bone(bone=20000),
    "bone.ct.label_map.refine_hu@min": labelled(bone=1000, refine_mm=1),
    "bone.ct.label_map.refine_hu@max": labelled(bone=20000, refine_mm=1),
    "bone.ct.cut_spheres[].radius_mm@max": ct_bone(cut_spheres=[{"center_mm": [503, 0, 0]}]),
    "bone.mesh.scale@min": {"files": {"bone.obj": cube(2e7)}},
    "bone.mesh.scale@max": {"files": {"bone.obj": cube(2e-5)}},
    "tool.scale@min": {"files": {"tool.obj": cylinder(4e6, 6e6)}},
    "tool.scale@max": {"files": {"tool.obj": cylinder(4e-6, 6e-6)}},
    "tool.shell_resolution": merged(cutting(erosion="remove"), {"files": {"tool.obj": cylinder(0.4, 6)}}),
    "tool.holder[].from_z_mm@max": holder(to_z_mm=1000),
    "tool.holder[].to_z_mm@min": holder(from_z_mm=-1000),
    "clearance.envelope.scale@min": merged(merged(holder(), SKIN), {"files": {"skin.obj": cube(3e7)}}),
    "clearance.envelope.scale@max": merged(merged(holder(), SKIN), {"files": {"skin.obj": cube(3e-5)}}),
    "motion.frame_rate_hz@min": plunge(1, feed_mm_s=0.1, retract_mm_s=0.1),
    "motion.frame_rate_hz@max": plunge(1e5, approach_mm=0.05, depth_mm=0.05, retract_mm=0.05, feed_mm_s=500, retract_mm_s=500),
    "motion.plunge.approach_mm@max": plunge(100, feed_mm_s=1000),
    "motion.plunge.depth_mm@max": plunge(100, feed_mm_s=1000),
    "motion.push.time_s@max": push(until="depth", depth_mm=0.05),
    "motion.push.max_feed_mm_s@max": merged(push(time_s=0.01), {"motion": {"frame_rate_hz": 5000}}),
    "motion.plunge.feed_mm_s@min": plunge(1, **SLOW),
    "motion.plunge.retract_mm_s@min": plunge(1, **SLOW),
    "motion.plunge.dwell_s@max": plunge(1),
    "motion.plunge.retract_mm@max": plunge(100, retract_mm_s=1000),
    "motion.keyframes[].time_s@min": keyframes({}, {}),
    "motion.keyframes[].time_s@max": keyframes({"time_s": 99990}, {}, rate_hz=1),
    "engine.max_step_voxels@min": plunge(100, approach_mm=0.1, depth_mm=0.1),
    "cutting.force_per_point_n": cutting(law="per_point"),
    "cutting.wear_g_cm3_per_s": cutting(erosion="wear"),
    "cutting.size_effect.least_mm@max": cutting(size_effect={"most_mm": 10}),
    "cutting.size_effect.most_mm@min": cutting(size_effect={"least_mm": 1e-5}),
    "metrics.implant.augment.step_mm": implant(augment={"shape": "step", "angle_deg": None}),
    "metrics.implant.mesh.scale@min": {"files": {"implant.obj": cylinder(3e6, 4e6)}},
    "metrics.implant.mesh.scale@max": {"files": {"implant.obj": cylinder(3e-6, 4e-6)}},
    "metrics.implant.diameter_mm@max": {"metrics": {"implant": {"backside_radius_mm": 100}}},
    "metrics.implant.backside_radius_mm@min": {},
    "metrics.implant.width_mm": implant(diameter_mm=0, height_mm=8, backside_radius_mm=100),
    "metrics.implant.width_mm@min": implant(diameter_mm=0, height_mm=0),
    "metrics.implant.height_mm": implant(diameter_mm=0, width_mm=8, backside_radius_mm=100),
    "metrics.implant.height_mm@min": implant(diameter_mm=0, width_mm=0),
    "render.every_frames@min": {"render": {"every_frames": 0}},
    "render.film_rate_hz": pictures(film="mp4"),
    "render.user_cameras[].width_mm": camera(projection="orthographic"),
}



# Ends of many seconds, which are run with --full only.
LONG = ("tool.shell_resolution@max", "render.turntable_pictures@max")

# Vectors: scenario by component (0 to 2) and value. The key's other components are those given here.


def sign(value):
    return 1 if value > 0 else -1


def glenoid_frame(middle, **keys):
    frame = {"center_mm": [0, 0, 0], "normal": [0, 0, 1], "superior": [0, 1, 0], **keys}
    return merged(mesh_bone(middle), {"bone": {"side": "left", "glenoid": frame}})


def center(component, value):
    place = axis(component, value)
    return glenoid_frame([place[0], place[1], place[2] - HALF], center_mm=place)


def near(component, value):
    place = axis(component, value)
    frame = {"near_mm": place}
    bone = merged(mesh_bone([place[0], place[1], place[2] - HALF]), {"bone": {"voxel_mm": 1}})
    return merged(bone, {"bone": {"side": "left", "glenoid": frame}})


def normal(component, value):
    return glenoid_frame(axis(component, -HALF * sign(value)), normal=axis(component), superior=axis((component + 1) % 3))


def superior(component, value):
    out = (component + 1) % 3
    return glenoid_frame(axis(out, -HALF), normal=axis(out), superior=axis(component, value))


def rim(component, value):
    """Eight points around the top face; the first is the one that lies furthest along the component."""
    along, across = (component, 1 - component) if component < 2 else (0, 1)
    middle = axis(component, value - (8 * sign(value) if component < 2 else 0))
    points = []
    for i in range(8):
        point = list(middle)
        point[along] += 8 * sign(value) * math.cos(math.pi * i / 4)
        point[across] += 8 * math.sin(math.pi * i / 4)
        points.append(point)
    return glenoid_frame([middle[0], middle[1], middle[2] - HALF], center_mm=middle, rim_mm=points)


def landmarks(middle, center_mm, trigonum_mm, inferior_mm):
    marks = {"glenoid_center_mm": center_mm, "trigonum_spinae_mm": trigonum_mm, "inferior_angle_mm": inferior_mm}
    return merged(mesh_bone(middle), {"bone": {"side": "left", "glenoid": {"landmarks": marks}}})


def landmark_center(component, value):
    place = axis(component, value)
    inwards = -sign(value)  # the other landmarks towards the origin
    trigonum = [p + 100 * inwards * a for p, a in zip(place, axis(component))]
    inferior = [t + 100 * a for t, a in zip(trigonum, axis((component + 1) % 3))]
    return landmarks([p + HALF * inwards * a for p, a in zip(place, axis(component))], place, trigonum, inferior)


def trigonum(component, value):
    return landmarks(axis(component, HALF * sign(value)), [0, 0, 0], axis(component, value), axis((component + 1) % 3, 100))


def inferior(component, value):
    return landmarks([-HALF, 0, 0], [0, 0, 0], [-1000, 500, 500], axis(component, value))


def plunge_axis(component, value):
    middle, half = [0, 0, -3], [5, 5, 3]
    entry = [m - sign(value) * h * a for m, h, a in zip(middle, half, axis(component))]
    return {"motion": {"plunge": {"axis": [0, 0, 0], "entry_mm": entry}}}


def crop(component, value, place, size):
    """A crop whose corner `place` (0: min) has the value; the scan lies in its middle."""
    corners = [[-HALF] * 3, [HALF] * 3]
    middle = [0.0, 0.0, 0.0]
    corners[place][component] = value
    other = value + (size if place == 0 else -size)
    corners[1 - place][component] = other
    middle[component] = (value + other) / 2
    return ct_bone(middle, crop_min_mm=corners[0], crop_max_mm=corners[1])


def cut_plane(component, value):
    plane = {"point_mm": [0, 0, 0], "normal": axis(component, sign(value))}
    return ct_bone(cut_planes=[plane])


def camera_up(component, value):
    return camera(position_mm=axis((component + 1) % 3, 60), target_mm=[0, 0, 0], up=[0, 0, 0])


DIRECTED = {
    "motion.csv.bone_from_tracker.rotation": rotated("bone_from_tracker"),
    "motion.csv.marker_from_tool.rotation": rotated("marker_from_tool"),
    "bone.glenoid.center_mm": center,
    "bone.glenoid.near_mm": near,
    "bone.glenoid.normal": normal,
    "bone.glenoid.superior": superior,
    "bone.glenoid.rim_mm": rim,
    "bone.glenoid.landmarks.glenoid_center_mm": landmark_center,
    "bone.glenoid.landmarks.trigonum_spinae_mm": trigonum,
    "bone.glenoid.landmarks.inferior_angle_mm": inferior,
    "bone.ct.crop_min_mm": lambda component, value: crop(component, value, 0, 10),
    "bone.ct.crop_max_mm": lambda component, value: crop(component, value, 1, 10),
    "bone.ct.seed_mm": lambda component, value: ct_bone(axis(component, value), seed_mm=[0, 0, 0]),
    "bone.ct.cut_planes[].point_mm": cut_plane,
    "bone.ct.cut_planes[].normal": lambda component, value: ct_bone(cut_planes=[{"point_mm": [0, 0, 0], "normal": [0, 0, 0]}]),
    "bone.pilot_hole.entry_mm": lambda component, value: merged(mesh_bone(axis(component, value)), HOLE),
    "bone.pilot_hole.axis": lambda component, value: merged(HOLE, {"bone": {"pilot_hole": {"entry_mm": [0, 0, -3], "axis": [0, 0, 0]}}}),
    "motion.plunge.axis": plunge_axis,
    "motion.keyframes[].axis": lambda component, value: keyframe(value, axis=[0, 0, 0]),
    "motion.keyframes[].quaternion": lambda component, value: keyframe(value, axis=None, quaternion=[0, 0, 0, 0]),
    "metrics.implant.axis": lambda component, value: implant(frame="bone", axis=[0, 0, 0]),
    "metrics.implant.superior": lambda component, value: implant(
        frame="bone", axis=[1, 0, 0] if component == 2 else [0, 0, 1], superior=[0, 0, 0]
    ),
    "metrics.implant.augment.direction": lambda component, value: implant(augment={"angle_deg": 15, "direction": [0.1, 0, 0]}),
    "render.user_cameras[].target_mm": lambda component, value: camera(target_mm=[0, 0, 0]),
    "render.user_cameras[].up": camera_up,
}
