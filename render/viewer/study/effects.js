// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Main effects of the runs that are shown: as python/src/reamsim/lab/effects.py computes them.
import { extremes, find, part, significantText, stepsOf, svgPart } from "../shared/page.js";

const kMostLevels = 40, kMostIntervals = 8, kLeastValuesOfInterval = 8, kMostPanels = 12, kMostDots = 500;

// Which group each run is in, and how the groups are named; null where a parameter does not group them.
function groupsOf(column, runs) {
  if (column.levels) {
    const present = new Set(Array.from(runs, (run) => column.codes[run])), codes = column.order.filter((code) => present.has(code));
    const differs = codes.length === runs.length && runs.length > 2 && !column.numeric;
    if (codes.length < 2 || codes.length > kMostLevels || differs) return null;
    const place = new Map(codes.map((code, i) => [code, i]));
    return { count: codes.length, of: (run) => place.get(column.codes[run]), names: column.numeric ? codes.map((code) => column.levels[code]) : shortened(codes.map((code) => column.levels[code])), intervals: false };
  }
  const values = Float64Array.from(new Set(Array.from(runs, (run) => column.values[run]))).sort();
  if (values.length < 2) return null;
  const isLevels = values.length <= kMostIntervals;
  const count = isLevels ? values.length : Math.min(kMostIntervals, Math.max(2, Math.floor(values.length / kLeastValuesOfInterval)));
  const place = new Map(Array.from(values, (value, i) => [value, isLevels ? i : Math.floor((i * count) / values.length)]));
  return { count, of: (run) => place.get(column.values[run]), names: isLevels ? Array.from(values, (value) => significantText(value)) : null, intervals: !isLevels };
}

// Without what all begin with, up to the last separator in it: "reamer_flat" is "flat".
function shortened(names) {
  let same = 0;
  while (names.every((name) => same < name.length && name[same] === names[0][same])) ++same;
  const separator = Math.max(...["_", "-", " "].map((c) => names[0].slice(0, same).lastIndexOf(c)));
  return names.some((name) => name.length === separator + 1) ? names : names.map((name) => name.slice(separator + 1));
}

const sumOf = (values) => values.reduce((sum, value) => sum + value, 0);
const meanOf = (values) => sumOf(values) / values.length;
const squaresOf = (values) => {
  const mean = meanOf(values);
  return sumOf(values.map((value) => (value - mean) ** 2));
};

function effectOf(parameter, result, runs) {
  const used = runs.filter((run) => !Number.isNaN(result.values[run]));
  const groups = used.length < 2 ? null : groupsOf(parameter, used);
  if (groups === null) return null;
  const members = Array.from({ length: groups.count }, () => []);
  for (const run of used) members[groups.of(run)].push(run);
  const sums = members.map((own, i) => {
    const xs = own.map((run) => parameter.values[run]), ys = own.map((run) => result.values[run]), squares = squaresOf(ys);
    const sd = own.length > 1 ? Math.sqrt(squares / (own.length - 1)) : 0;
    const name = groups.names?.[i] ?? extremes(xs).map((end) => significantText(end)).join(" to ");
    return { x: meanOf(xs), mean: meanOf(ys), squares, sd, name };
  });
  const values = Array.from(used, (run) => result.values[run]), mean = meanOf(values), all = squaresOf(values);
  let within = sumOf(sums.map((sum) => sum.squares));
  if (groups.intervals && used.length > groups.count) within *= (used.length - 1) / (used.length - groups.count);
  const explained = all > 1e-18 * mean * mean * used.length ? Math.min(1, Math.max(0, 1 - within / all)) : 0;
  return { parameter, result, runs: used, sums, explained, intervals: groups.intervals };
}

// Vectors that are tilted or shifted have columns of their parts.
const hasParts = (column, all) => all.some((other) => other.key.startsWith(`${column.key}.tilt_`) || other.key.startsWith(`${column.key}.shift_`));

const truncated = (text) => (text.length > 13 ? `${text.slice(0, 12)}…` : text);
const percent = (fraction) => (fraction < 0.005 ? "< 1 %" : `${Math.round(100 * fraction)} %`);

const kWide = 260, kHigh = 190, kLeft = 52, kRight = 8, kTop = 28, kBottom = 40;

// A panel: single runs in grey, means with standard deviations.
function panelOf(effect) {
  const { parameter, result, sums } = effect;
  const svg = svgPart("svg", { viewBox: `0 0 ${kWide} ${kHigh}`, role: "img" });
  const means = sums.map((sum) => `${sum.name}: ${significantText(sum.mean)}`).join("; ");
  svg.setAttribute("aria-label", `${result.title} over ${parameter.title}, which explains ${percent(effect.explained)} of its variance. Means: ${means}`);
  const byNumber = !parameter.levels || parameter.numeric;
  const xs = byNumber ? Array.from(effect.runs, (run) => parameter.values[run]) : sums.map((_, i) => i + 1);
  const padded = ([low, high], air) => [low - air(high - low), high + air(high - low)];
  const [xLow, xHigh] = padded(extremes(xs), (range) => (byNumber ? 0.08 * range : 0.5));
  const ys = [...Array.from(effect.runs, (run) => result.values[run]), ...sums.flatMap((sum) => [sum.mean - sum.sd, sum.mean + sum.sd])];
  const [yLow, yHigh] = padded(extremes(ys), (range) => 0.06 * range || 1);
  const x = (value) => kLeft + ((value - xLow) / (xHigh - xLow)) * (kWide - kLeft - kRight);
  const y = (value) => kHigh - kBottom - ((value - yLow) / (yHigh - yLow)) * (kHigh - kTop - kBottom);
  for (const tick of stepsOf(yLow, yHigh, 5)) {
    svg.append(svgPart("line", { x1: kLeft, x2: kWide - kRight, y1: y(tick), y2: y(tick), class: "grid" }));
    svg.append(svgPart("text", { x: kLeft - 5, y: y(tick) + 4, "text-anchor": "end" }, significantText(tick)));
  }
  const place = (sum, i) => x(byNumber ? sum.x : i + 1);
  const ticks = effect.intervals || sums.length > 6 ? stepsOf(xLow, xHigh, 5).map((value) => [x(value), significantText(value)]) : sums.map((sum, i) => [place(sum, i), truncated(sum.name)]);
  let free = -Infinity;
  for (const [at, text] of ticks) {
    if (at - 3.2 * text.length < free) continue;
    free = at + 3.2 * text.length + 4;
    svg.append(svgPart("text", { x: at, y: kHigh - kBottom + 15, "text-anchor": "middle" }, text));
  }
  const step = Math.max(1, Math.floor(effect.runs.length / kMostDots));
  const spread = effect.intervals ? 0 : Math.min(12, 0.2 * (kWide / sums.length));
  for (let i = 0; i < effect.runs.length; i += step) {
    const run = effect.runs[i];
    const aside = (((i * 0.618) % 1) - 0.5) * spread;
    svg.append(svgPart("circle", { cx: (x(parameter.values[run]) + aside).toFixed(1), cy: y(result.values[run]).toFixed(1), r: 1.6, class: "dot" }));
  }
  if (byNumber) svg.append(svgPart("polyline", { points: sums.map((sum, i) => `${place(sum, i)},${y(sum.mean)}`).join(" "), class: "mean" }));
  sums.forEach((sum, i) => {
    svg.append(svgPart("line", { x1: place(sum, i), x2: place(sum, i), y1: y(sum.mean - sum.sd), y2: y(sum.mean + sum.sd), class: "mean" }));
    svg.append(svgPart("circle", { cx: place(sum, i), cy: y(sum.mean), r: 3.6, class: "mark" }));
  });
  svg.append(svgPart("text", { x: 2, y: 13, class: "head" }, parameter.title.length > 34 ? `${parameter.title.slice(0, 33)}…` : parameter.title));
  svg.append(svgPart("text", { x: kWide - kRight, y: kHigh - 6, "text-anchor": "end" }, `explains ${percent(effect.explained)}`));
  return part("figure", {}, svg);
}

export class Effects {
  constructor(study) {
    this.study = study;
    this.parameters = study.parameters.filter((column) => !hasParts(column, study.parameters));
    find("effect-result").addEventListener("change", () => this.draw());
  }

  // The parameters by what they explain of a result, the dominant one first.
  ranked(result, runs) {
    const effects = this.parameters.map((parameter) => effectOf(parameter, result, runs)).filter((effect) => effect !== null);
    return effects.sort((a, b) => b.explained - a.explained);
  }

  show(runs) {
    this.runs = runs.filter((run) => this.study.stateText(run) === "done");
    this.draw();
  }

  draw() {
    const result = this.study.byKey.get(find("effect-result").value);
    const effects = result && this.runs.length > 1 ? this.ranked(result, this.runs) : [];
    const shown = effects.slice(0, kMostPanels);
    find("effect-panels").replaceChildren(...shown.map(panelOf));
    const more = effects.length > shown.length ? ` ${effects.length - shown.length} more explain less.` : "";
    find("effects-help").textContent = effects.length === 0
      ? "No parameter varies in the runs that are shown."
      : `Of ${this.runs.length} runs that are done and shown: mean and standard deviation over all other parameters; single runs in grey. The parameter that explains most of the variance comes first.${more}`;
  }
}
