// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What the page edits, and what follows from it.
import { Vector3 } from "../shared/scene.js";
import { contactOf, faceNormal, warningsOf } from "./checks.js";
import { Reamer, frameOf, frameOfLandmarks } from "./reamer.js";
import { Field, add, liveMask, minus, positionsOf, reduced, rounded, same, surfaceOf, unit, volumeOf } from "./volume.js";

// Colours and short names of what both slices and 3D view draw; after Okabe and Ito, which colour-blind readers tell apart.
export const colors = {
  bone: "#E69F00", live: "#56B4E9", reamer: "#2fd6a4", sphere: "#CC79A7", cross: "#ffffff",
  center: "#ff6a1f", superior: "#F0E442", seed: "#ffffff", trigonum: "#5fb1ff", inferior: "#ff9bd2", rim: "#9df27d",
};

const letters = { center: "C", superior: "S", seed: "seed", trigonum: "TS", inferior: "IA" };

// The points of a model: tool, place, colour, letter.
export function marksOf(model) {
  const named = Object.entries(letters).map(([tool, letter]) => ({ tool, place: model.pointOf(tool), color: colors[tool], letter }));
  const rim = model.values.rim.map((place, i) => ({ tool: "rim", place, color: colors.rim, letter: String(i + 1) }));
  return [...named.filter(({ place }) => place !== null), ...rim];
}

const kMaskVoxels = 1_600_000;
const copy = (value) => JSON.parse(JSON.stringify(value));

// The keys of the scenario as they are given.
function valuesOf(data) {
  const { glenoid, ct } = data;
  const marks = glenoid.landmarks;
  return {
    side: data.side, from: glenoid.given === "landmarks" ? "landmarks" : "face",
    center: marks !== null && glenoid.given === "landmarks" ? marks.glenoid_center_mm : glenoid.center_mm,
    normal: glenoid.normal, superior: glenoid.superior,
    trigonum: marks?.trigonum_spinae_mm ?? null, inferior: marks?.inferior_angle_mm ?? null,
    rim: glenoid.rim_given ? glenoid.rim_mm : [],
    threshold_hu: ct?.threshold_hu ?? null, seed: ct?.seed_mm ?? null, cut_spheres: ct?.cut_spheres ?? [],
  };
}

export class Model {
  constructor(data) {
    this.data = data;
    this.volume = volumeOf(data.volume);
    this.initial = valuesOf(data);
    this.values = copy(this.initial);
    this.notify = () => {};  // the page sets what is told what has changed: values, cross, tool or pose
    this.tool = "look";
    this.reamer = data.tool === null || data.motion.poses.length === 0 ? null : new Reamer(data.tool, data.motion);
    this.pose = 0;
    this.showsReamer = true;
    const { lattice } = this.volume;
    this.segmented = this.volume.bone === null ? null : new Field(lattice, this.volume.bone);
    this.segmentedSurface = this.segmented === null ? null : surfaceOf(reduced(lattice, this.volume.bone, 2 * kMaskVoxels));
    this.cross = this.interest();
    this.update();
  }

  // The centre of the glenoid, else the seed, else the middle of the bone.
  interest() {
    const { center, seed } = this.values;
    if (center !== null) return center;
    if (seed !== null) return seed;
    const box = this.segmentedSurface?.boundingBox;
    if (!box || box.isEmpty()) return this.volume.lattice.center();
    return rounded(box.getCenter(new Vector3()).toArray(), 2);
  }

  get segmentationChanged() {
    return ["threshold_hu", "seed", "cut_spheres"].some((key) => !same(this.values[key], this.initial[key]));
  }

  // Recomputes the live mask if the segmentation is not the one that the program made.
  updateMask() {
    const { data, values } = this;
    const key = JSON.stringify([values.threshold_hu, values.seed, values.cut_spheres]);
    if (key === this.maskKey) return;
    this.maskKey = key;
    this.live = null;
    this.seedMissed = false;
    this.bone = this.segmented;
    this.surface = this.segmentedSurface;
    if (data.ct === null || data.ct.label_map || (!this.segmentationChanged && this.segmented !== null)) return;
    this.coarse ??= reduced(this.volume.lattice, this.volume.values, kMaskVoxels);
    const ct = { ...data.ct, threshold_hu: values.threshold_hu, seed_mm: values.seed ?? data.ct.separated_seed_mm,
      cut_spheres: [...values.cut_spheres, ...data.ct.separated] };
    const { field, seedMissed } = liveMask(this.coarse, ct, this.volume);
    this.seedMissed = seedMissed;
    this.live = this.bone = field === null ? null : new Field(this.coarse.lattice, field);
    this.surface = field === null ? null : surfaceOf({ lattice: this.coarse.lattice, bytes: field });
  }

  update() {
    const { values } = this;
    this.updateMask();
    this.glenoid = values.from === "landmarks" ? frameOfLandmarks(values) : frameOf(values.center, values.normal, values.superior);
    const key = JSON.stringify([this.maskKey, this.glenoid]);
    if (key !== this.contactKey) {  // the contact does not depend on the pose that is shown
      this.contactKey = key;
      this.contact = null;
      this.reamer?.startAtContact(this.glenoid, positionsOf(this.surface));
      if (this.reamer !== null && this.surface !== null && this.reamer.pose(0, this.glenoid) !== null) this.contact = contactOf(this);
    }
    this.posed = this.reamer === null ? null : this.reamer.pose(this.pose, this.glenoid);
    this.findings = warningsOf(this);
    if (this.same()) {  // what the program itself has said
      this.findings.push(...this.data.warnings.map((text) => ({ level: "note", text })));
      this.findings.unshift(...this.data.problems.map((text) => ({ level: "problem", text })));
    }
  }

  // A frame that the scenario gives needs a side; one that a phantom has of itself does not.
  get needsSide() {
    const keys = ["from", "center", "normal", "superior"];
    return this.glenoid !== null && (this.data.glenoid.given !== "none" || keys.some((key) => !same(this.values[key], this.initial[key])));
  }

  same() { return same(this.values, this.initial); }

  set(changes) {
    Object.assign(this.values, changes);
    this.update();
    this.notify("values");
  }

  moveCross(point) {
    this.cross = rounded(this.volume.lattice.clamped(point), 2);
    this.notify("cross");
  }

  choose(tool) {
    this.tool = tool;
    this.notify("tool");
  }

  setPose(k) {
    this.pose = k;
    this.posed = this.reamer.pose(k, this.glenoid);
    this.notify("pose");
  }

  undo() {
    this.values = copy(this.initial);
    if (this.tool.startsWith("sphere") && this.pointOf(this.tool) === null) this.tool = "look";
    this.update();
    this.notify("values");
  }

  // The point that a tool places, or null before it is placed.
  pointOf(tool) {
    const { values } = this;
    if (tool === "superior") return values.center === null || values.superior === null ? null : rounded(add(values.center, unit(values.superior), 15), 2);
    if (tool === "rim") return values.rim.at(-1) ?? null;
    if (tool.startsWith("sphere")) return values.cut_spheres[Number(tool.slice(7))]?.center_mm ?? null;
    return tool === "look" ? this.cross : values[tool];
  }

  // Places what `tool` places. A rim grows by a point, or, with `moves`, its last point moves.
  place(tool, place, moves = false) {
    const point = rounded(place, 2), { values } = this;
    if (tool === "look") return;
    if (tool === "center") {
      this.set({ center: point, normal: (moves ? null : this.normalAt(point)) ?? values.normal });
    } else if (tool === "superior") {
      if (values.center === null || same(point, values.center)) return;
      this.set({ superior: rounded(unit(minus(point, values.center)), 4) });
    } else if (tool === "rim") {
      this.set({ rim: [...(moves ? values.rim.slice(0, -1) : values.rim), point] });
    } else if (tool.startsWith("sphere")) {
      const at = Number(tool.slice(7));
      this.set({ cut_spheres: values.cut_spheres.map((sphere, i) => (i === at ? { ...sphere, center_mm: point } : sphere)) });
    } else this.set({ [tool]: point });
  }

  remove(tool) {
    const { values } = this;
    if (tool === "rim") this.set({ rim: values.rim.slice(0, -1) });
    else if (tool.startsWith("sphere")) {
      this.tool = "look";
      this.set({ cut_spheres: values.cut_spheres.filter((_, i) => i !== Number(tool.slice(7))) });
    } else if (tool !== "look") this.set({ [tool]: null });
  }

  // The normal of the bone's surface near a point; null where there is none.
  normalAt(point) {
    const normal = this.surface === null ? null : faceNormal(this.surface, point);
    return normal === null ? null : rounded(normal, 4);
  }

  fitNormal() { this.set({ normal: this.normalAt(this.values.center) ?? this.values.normal }); }
}
