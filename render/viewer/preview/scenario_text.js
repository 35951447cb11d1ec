// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The scenario's text with the keys that the page has changed.
import { inOrder } from "./glenoid.js";
import { same } from "./vector.js";
import { edited } from "./yaml_edit.js";

const number = (value) => String(Number(value.toFixed(4)));
const vector = (value) => `[${value.map(number).join(", ")}]`;

function glenoidChanges(values, initial, given) {
  const at = (key) => ["bone", "glenoid", key];
  const keys = { center_mm: values.center, normal: values.normal, superior: values.superior };
  const before = { center_mm: initial.center, normal: initial.normal, superior: initial.superior };
  if (values.from === "landmarks") {
    const marks = { glenoid_center_mm: values.center, trigonum_spinae_mm: values.trigonum, inferior_angle_mm: values.inferior };
    if (given === "landmarks") {
      const old = { glenoid_center_mm: initial.center, trigonum_spinae_mm: initial.trigonum, inferior_angle_mm: initial.inferior };
      return Object.entries(marks).filter(([key, value]) => !same(value, old[key]))
        .map(([key, value]) => [["bone", "glenoid", "landmarks", key], value === null ? undefined : vector(value)]);
    }
    if (Object.values(marks).includes(null)) return [];
    const removed = ["face", "near"].includes(given) ? ["near_mm", ...Object.keys(keys)].map((key) => [at(key), undefined]) : [];
    return [...removed, [at("landmarks"), Object.fromEntries(Object.entries(marks).map(([key, value]) => [key, vector(value)]))]];
  }
  const changed = Object.entries(keys).filter(([key, value]) => !same(value, before[key]));
  const switched = given === "landmarks" ? [[at("landmarks"), undefined]] : [];
  // A frame that was found gives way to one that is set.
  if (given === "near" && changed.length > 0) switched.push([at("near_mm"), undefined], [at("landmarks"), undefined]);
  // Where the bone itself gave the frame, the scenario needs all three keys, not one.
  const wanted = given === "face" ? changed : changed.length > 0 || switched.length > 0 ? Object.entries(keys).filter(([, value]) => value !== null) : [];
  return [...switched, ...wanted.map(([key, value]) => [at(key), value === null ? undefined : vector(value)])];
}

function sphereChanges(values, initial) {
  const at = ["bone", "ct", "cut_spheres"];
  if (same(values.cut_spheres, initial.cut_spheres)) return [];
  if (values.cut_spheres.length !== initial.cut_spheres.length || initial.cut_spheres.length === 0) return null;
  const changes = [];
  values.cut_spheres.forEach((sphere, i) => {
    if (!same(sphere.center_mm, initial.cut_spheres[i].center_mm)) changes.push([[...at, i, "center_mm"], vector(sphere.center_mm)]);
    if (sphere.radius_mm !== initial.cut_spheres[i].radius_mm) changes.push([[...at, i, "radius_mm"], number(sphere.radius_mm)]);
  });
  return changes;
}

function withSpheres(text, values, changes) {
  const spheres = values.cut_spheres.map((sphere) => ({ center_mm: vector(sphere.center_mm), radius_mm: number(sphere.radius_mm) }));
  const all = [[["bone", "ct", "cut_spheres"], spheres.length === 0 ? undefined : spheres]];
  if (changes === null) return edited(text, all);
  try {
    return edited(text, changes);
  } catch {
    return edited(text, all);  // a list in another style is written anew
  }
}

// `model`: values, initial, data, glenoid. Throws EditError where the text has what cannot be changed in place.
export function scenarioText({ values, initial, data, glenoid }) {
  const changes = [];
  if (values.side !== initial.side) changes.push([["bone", "side"], values.side]);
  if (values.threshold_hu !== initial.threshold_hu) changes.push([["bone", "ct", "threshold_hu"], number(values.threshold_hu)]);
  if (!same(values.seed, initial.seed)) changes.push([["bone", "ct", "seed_mm"], values.seed === null ? undefined : vector(values.seed)]);
  changes.push(...glenoidChanges(values, initial, data.glenoid.given));
  if (!same(values.rim, initial.rim)) {
    const rim = inOrder(values.rim, glenoid?.axes[2] ?? null);
    changes.push([["bone", "glenoid", "rim_mm"], rim.length === 0 ? undefined : rim.map(vector)]);
  }
  return withSpheres(edited(data.scenario, changes), values, sphereChanges(values, initial));
}
