// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Points of the page as markups of 3D Slicer, and back. The spellings of labels are those of cli/landmark_roles.cpp.
import { inOrder } from "./checks.js";
import { same } from "./volume.js";

const kLabels = { center: "Glenoid center", superior: "Superior", seed: "Seed", trigonum: "Trigonum spinae", inferior: "Inferior angle" };
const kSchema = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#";

const kIgnored = new Set(["the", "of", "point", "landmark", "lm", "mm", "fossa", "left", "right", "scapulae", "scapula", "scapular", "my"]);
const kSpellings = {
  center: ["center glenoid", "center", "gc", "glenoid", "glenoid midpoint", "glenoid middle"],
  superior: ["superior", "glenoid superior", "pole superior", "glenoid pole superior", "rim superior", "glenoid rim superior", "supraglenoid tubercle", "glenoid sup", "sup"],
  seed: ["seed"],
  trigonum: ["spinae trigonum", "trigonum", "ts", "root spine"],
  inferior: ["angle inferior", "angulus inferior", "ai", "ia"],
  rim: ["rim", "glenoid rim"],
};

function roleOf(label) {
  const words = label.replace(/([a-z])([A-Z])/g, "$1 $2").toLowerCase().match(/[a-z]+/g) ?? [];
  const key = [...new Set(words.filter((word) => !kIgnored.has(word)).map((word) => (word === "centre" ? "center" : word)))].sort().join(" ");
  return Object.keys(kSpellings).find((role) => kSpellings[role].includes(key)) ?? null;
}

// [{label, point}] of an .mrk.json, or of an .fcsv, in LPS and mm.
function pointsOfJson(text) {
  const { markups } = JSON.parse(text);
  if (!Array.isArray(markups)) throw new Error("no markups in the file");
  return markups.flatMap(({ coordinateSystem = "LPS", coordinateUnits = "mm", controlPoints }) => {
    const mm = { mm: 1, um: 1e-3, cm: 10, m: 1000 }[Array.isArray(coordinateUnits) ? coordinateUnits[0] : coordinateUnits];
    if (mm === undefined || !["LPS", "RAS"].includes(coordinateSystem)) throw new Error(`unknown unit or frame: ${coordinateUnits}, ${coordinateSystem}`);
    const sign = coordinateSystem === "RAS" ? -mm : mm;
    return (controlPoints ?? []).filter((point) => point.position && (point.positionStatus ?? "defined") === "defined")
      .map(({ label, position: [x, y, z] }) => ({ label: label ?? "", point: [sign * x, sign * y, mm * z] }));
  });
}

// Cells of a line; one in quotes may hold commas.
const cellsOf = (line) => [...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map(([, quoted, plain]) => quoted?.replaceAll('""', '"') ?? plain.trim());

function pointsOfFcsv(text) {
  let sign = -1, columns = ["label", "x", "y", "z"];
  const points = [];
  for (const line of text.split(/\r?\n/).map((each) => each.trim()).filter((each) => each !== "")) {
    const [, key, value] = line.match(/^#\s*(.*?)\s*=\s*(.*)$/) ?? [];
    if (key === "CoordinateSystem") {
      if (!["0", "1", "RAS", "LPS"].includes(value)) throw new Error(`unknown frame: ${value}`);
      sign = value === "1" || value === "LPS" ? 1 : -1;
    } else if (key === "columns") columns = cellsOf(value);
    if (line.startsWith("#")) continue;
    const cells = cellsOf(line), at = (name) => cells[columns.indexOf(name)];
    const [x, y, z] = ["x", "y", "z"].map((name) => (at(name) === undefined || at(name) === "" ? NaN : Number(at(name))));
    if (![x, y, z].every(Number.isFinite)) throw new Error("a line without three numbers");
    if (cells.length < 15 || ["", "2"].includes(cells[14])) points.push({ label: at("label") ?? "", point: [sign * x, sign * y, z] });
  }
  return points;
}

// Places the points of an .mrk.json or .fcsv; returns what was understood, for the user.
export function applyMarkups(model, text) {
  const found = {}, unused = [];
  for (const { label, point } of /^\s*\{/.test(text) ? pointsOfJson(text) : pointsOfFcsv(text)) {
    const role = roleOf(label);
    if (role === null || (role !== "rim" && role in found)) unused.push(label);
    else if (role === "rim") (found.rim ??= []).push(point);
    else found[role] = point;
  }
  const clean = (point) => point.map((c) => Number(c.toFixed(4)) + 0);
  for (const role of ["center", "superior", "trigonum", "inferior", "seed"]) {
    if (!found[role] || (role === "seed" && model.data.ct === null)) continue;
    // A point that is there already stays with what was made of it: the normal at the centre may have been changed.
    if (!same(model.pointOf(role), clean(found[role]))) model.place(role, clean(found[role]));
  }
  if (found.rim) model.set({ rim: found.rim.map(clean) });
  const names = Object.keys(found);
  if (found.center) model.moveCross(found.center);
  const read = names.length === 0 ? "No label was understood" : `Read: ${names.map((role) => (role === "rim" ? `rim (${found.rim.length})` : kLabels[role].toLowerCase())).join(", ")}`;
  return unused.length === 0 ? `${read}.` : `${read}. Not used: ${unused.join(", ")}.`;
}

// The placed points as an .mrk.json.
export function markupsText(model) {
  const { values, glenoid } = model;
  const named = Object.entries(kLabels).map(([role, label]) => ({ label, point: model.pointOf(role) })).filter(({ point }) => point !== null);
  const rim = inOrder(values.rim, glenoid?.axes[2] ?? null).map((point, i) => ({ label: `Rim-${i + 1}`, point }));
  const controlPoints = [...named, ...rim].map(({ label, point }, i) => ({ id: String(i + 1), label, position: point, positionStatus: "defined" }));
  return `${JSON.stringify({ "@schema": kSchema, markups: [{ type: "Fiducial", name: "landmarks", coordinateSystem: "LPS", coordinateUnits: "mm", controlPoints }] }, null, 1)}\n`;
}
