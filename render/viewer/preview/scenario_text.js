// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The scenario's text with the keys that the page has changed.
import { isAlias, isMap, isScalar, isSeq, parseDocument } from "yaml";
import { inOrder } from "./checks.js";
import { same } from "./volume.js";

// --- single keys are changed where the parser says that they stand; every other byte stays

const spliced = (text, from, to, put = "") => text.slice(0, from) + put + text.slice(to);
const lineStart = (text, at) => text.lastIndexOf("\n", at - 1) + 1;
function lineEnd(text, at) {
  const end = text.indexOf("\n", at);
  return end < 0 ? text.length : end > 0 && text[end - 1] === "\r" ? end - 1 : end;
}
const newLines = (text, lines) => lines.map((line) => (text.includes("\r\n") ? "\r\n" : "\n") + line).join("");

// Values are texts, lists or objects of values.
function flowText(value) {
  if (typeof value === "string") return value;
  return Array.isArray(value) ? `[${value.map(flowText).join(", ")}]` : `{${Object.entries(value).map(([key, v]) => `${key}: ${flowText(v)}`).join(", ")}}`;
}
function blockLines(value, indent) {
  const pad = " ".repeat(indent);
  if (!Array.isArray(value)) {
    return Object.entries(value).flatMap(([key, v]) => (typeof v === "string" ? [`${pad}${key}: ${v}`] : [`${pad}${key}:`, ...blockLines(v, indent + 2)]));
  }
  return value.flatMap((item) => (typeof item === "string" ? [`${pad}- ${item}`]
    : blockLines(item, indent + 2).map((line, i) => (i > 0 ? line : `${pad}- ${line.trimStart()}`))));
}
const nested = (path, value) => path.reduceRight((inner, key) => ({ [key]: inner }), value);

const isEmpty = (node) => node === null || (isScalar(node) && node.range[0] === node.range[1]);
function colonEnd(pair, name) {
  const colon = pair.srcToken.sep?.find((token) => token.type === "map-value-ind");
  if (colon === undefined) throw new Error(`${name} has no value: change it by hand`);
  return colon.offset + 1;
}
// Where the content of a node, or of a pair, ends: before spaces and comments.
function endOf(node) {
  if ((isMap(node) || isSeq(node)) && !node.flow) return endOfPair(node.items.at(-1));
  return node.range[1];
}
const endOfPair = (item) => ("key" in item ? (isEmpty(item.value) ? colonEnd(item, item.key) : endOf(item.value)) : endOf(item));
// A block scalar ends with its last line.
const contentEnd = (text, item) => text.slice(0, endOfPair(item)).trimEnd().length;

function inserted(text, map, value) {
  const last = map.items.at(-1);
  if (map.flow) {
    return last === undefined ? spliced(text, map.range[0] + 1, map.range[0] + 1, flowText(value).slice(1, -1))
      : spliced(text, endOfPair(last), endOfPair(last), `, ${flowText(value).slice(1, -1)}`);
  }
  const { range: [start] } = map.items[0].key, at = lineEnd(text, contentEnd(text, last));
  return spliced(text, at, at, newLines(text, blockLines(value, start - lineStart(text, start))));
}

function removed(text, map, pair) {
  const at = map.items.indexOf(pair), start = pair.key.range[0], end = contentEnd(text, pair);
  if (!map.flow) return spliced(text, lineStart(text, start), text.indexOf("\n", end) + 1 || text.length);
  if (at > 0) return spliced(text, endOfPair(map.items[at - 1]), end);
  return spliced(text, start, map.items.length > 1 ? map.items[1].key.range[0] : end);
}

// The comment behind the key, or behind a value on its line, stays.
function replaced(text, map, pair, value, name) {
  const colon = colonEnd(pair, name), { value: old } = pair, start = pair.key.range[0];
  const isBelow = !isEmpty(old) && old.range[0] > lineEnd(text, colon);
  const cut = isEmpty(old) ? text : isBelow ? spliced(text, lineEnd(text, colon), lineEnd(text, contentEnd(text, pair))) : spliced(text, colon, endOf(old));
  if (map.flow || typeof value === "string") return spliced(cut, colon, colon, ` ${flowText(value)}`);
  const at = lineEnd(cut, colon);
  return spliced(cut, at, at, newLines(text, blockLines(value, start - lineStart(text, start) + 2)));
}

function refuse(text, pair, name) {
  const { value } = pair;
  if (!isAlias(value) && !value?.anchor && !value?.tag && !/BLOCK/.test(isScalar(value) ? value.type : "")) return;
  throw new Error(`${name} is written with ${text.slice(colonEnd(pair, name)).trim().slice(0, 12)}, which this page does not change: change it by hand`);
}

// Sets the key `path` (names; numbers for items of a sequence) to a value; undefined removes the key.
function setKey(text, path, value) {
  const { contents, errors } = parseDocument(text, { keepSourceTokens: true, strict: false, uniqueKeys: false });
  if (errors.length > 0) throw new Error(`the page cannot read the text (${errors[0].code}): change it by hand`);
  if (contents === null) return value === undefined ? text : text + blockLines(nested(path, value), 0).join("\n");
  let node = contents;
  for (let depth = 0; depth < path.length; ++depth) {
    const name = path.slice(0, depth + 1).join("."), rest = path.slice(depth + 1);
    if (isSeq(node) && path[depth] in node.items) {
      node = node.items[path[depth]];
      continue;
    }
    if (!isMap(node)) throw new Error(`${path.slice(0, depth).join(".")} has no keys below it: change it by hand`);
    const pair = node.items.find(({ key }) => key.value === path[depth]);
    if (pair === undefined) return value === undefined ? text : inserted(text, node, nested(path.slice(depth), value));
    refuse(text, pair, name);
    if (rest.length === 0) return value === undefined ? removed(text, node, pair) : replaced(text, node, pair, value, name);
    if (isEmpty(pair.value) || pair.value.value === null) return value === undefined ? text : replaced(text, node, pair, nested(rest, value), name);
    node = pair.value;
  }
  return text;
}

// `changes`: [path, value] pairs, see setKey().
export const edited = (text, changes) => changes.reduce((changed, [path, value]) => setKey(changed, path, value), text);

// --- which keys

const number = (value) => String(Number(value.toFixed(4)));
const vector = (value) => `[${value.map(number).join(", ")}]`;

// Keys of `bone.glenoid` and of its landmarks, and what the page calls their values.
const kFace = [["center_mm", "center"], ["normal", "normal"], ["superior", "superior"]];
const kLandmarks = [["glenoid_center_mm", "center"], ["trigonum_spinae_mm", "trigonum"], ["inferior_angle_mm", "inferior"]];

function glenoidChanges(values, initial, given) {
  const path = ["bone", "glenoid"], remove = (...keys) => keys.map((key) => [[...path, key], undefined]);
  const changed = (keys) => keys.filter(([, name]) => !same(values[name], initial[name]));
  const write = (keys, below = path) => keys.map(([key, name]) => [[...below, key], values[name] === null ? undefined : vector(values[name])]);
  if (values.from === "landmarks") {
    if (given === "landmarks") return write(changed(kLandmarks), [...path, "landmarks"]);
    if (kLandmarks.some(([, name]) => values[name] === null)) return [];
    const removed = ["face", "near"].includes(given) ? remove("near_mm", ...kFace.map(([key]) => key)) : [];
    return [...removed, [[...path, "landmarks"], Object.fromEntries(kLandmarks.map(([key, name]) => [key, vector(values[name])]))]];
  }
  const faceChanged = changed(kFace).length > 0;
  // A frame that was found gives way to one that is set.
  const removed = given === "landmarks" ? remove("landmarks") : given === "near" && faceChanged ? remove("near_mm", "landmarks") : [];
  // Where the bone itself gave the frame, the scenario needs all three keys, not one.
  const all = faceChanged || removed.length > 0 ? kFace.filter(([, name]) => values[name] !== null) : [];
  return [...removed, ...write(given === "face" ? changed(kFace) : all)];
}

function withSpheres(text, { cut_spheres: spheres }, { cut_spheres: before }) {
  if (same(spheres, before)) return text;
  const at = ["bone", "ct", "cut_spheres"];
  const texts = spheres.map((one) => ({ center_mm: vector(one.center_mm), radius_mm: number(one.radius_mm) }));
  const anew = () => edited(text, [[at, texts.length === 0 ? undefined : texts]]);
  if (spheres.length !== before.length) return anew();
  const changedKeys = (i) => ["center_mm", "radius_mm"].filter((key) => !same(spheres[i][key], before[i][key]));
  const changes = texts.flatMap((sphere, i) => changedKeys(i).map((key) => [[...at, i, key], sphere[key]]));
  try {
    return edited(text, changes);
  } catch {
    return anew();  // a list in another style
  }
}

// `model`: values, initial, data, glenoid. Throws where the text has what cannot be changed in place.
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
  return withSpheres(edited(data.scenario, changes), values, initial);
}
