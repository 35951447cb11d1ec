// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Decorations of the 3D view: directions, scale bar, legends.
import { Vector3 } from "three";
import { part, svgPart } from "./elements.js";

const lineLength = 34;
const shortest = 14;  // an axis viewed end-on has no label

// Places of a label at the end of an axis: beyond it, above, below and beside it. `text` has its size already.
function placesOf(text, x, y) {
  const { width, height } = text.getBBox();
  const length = Math.hypot(x, y);
  const [right, down] = [x / length, y / length];
  const beyond = [x + right * (5 + width / 2), y + down * (4 + height / 2)];
  const around = [[0, -1], [0, 1], [-1, 0], [1, 0]].map(([i, j]) => [x + i * (5 + width / 2), y + j * (3 + height / 2)]);
  return [beyond, ...around].map(([cx, cy], rank) => ({ cx, cy, rank, left: cx - width / 2, right: cx + width / 2, top: cy - height / 2, bottom: cy + height / 2 }));
}

const overlap = (a, b) =>
  Math.max(0, Math.min(a.right, b.right) + 3 - Math.max(a.left, b.left)) * Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));

// How many of the sampled points of an axis lie under a label.
const crossings = (box, [x, y]) =>
  [0, 0.25, 0.5, 0.75, 1].filter((t) => t * x > box.left - 2 && t * x < box.right + 2 && t * y > box.top && t * y < box.bottom).length;

// The choice of one place for each label with the least overlap, and then with the best places.
function bestPlaces(choices, ends) {
  let best, least = Infinity;
  const extend = (chosen, cost) => {
    if (cost >= least) return;
    if (chosen.length === choices.length) {
      [best, least] = [chosen, cost];
      return;
    }
    for (const place of choices[chosen.length]) {
      const covered = chosen.reduce((sum, other) => sum + overlap(place, other), 0);
      const crossed = ends.reduce((sum, end) => sum + crossings(place, end), 0);
      extend([...chosen, place], cost + 1000 * covered + 20 * crossed + place.rank);
    }
  };
  extend([], 0);
  return best;
}

export function drawAxes(place, look, camera) {
  const directions = look.anatomical
    ? [["superior", look.superior], ["lateral", look.outward], ["anterior", look.anterior]]
    : [["tool axis", look.axis]];
  place.replaceChildren();
  const [labels, labelled, ends] = [[], [], []];
  for (const [name, direction] of directions) {
    if (direction === null) continue;
    const eye = new Vector3(...direction).transformDirection(camera.matrixWorldInverse);
    const end = [lineLength * eye.x, -lineLength * eye.y];
    place.append(svgPart("line", { x1: 0, y1: 0, x2: end[0], y2: end[1] }));
    ends.push(end);
    if (Math.hypot(...end) < shortest) continue;
    labels.push(svgPart("text", { "text-anchor": "middle", "dominant-baseline": "central" }, name));
    labelled.push(end);
  }
  place.append(...labels);
  bestPlaces(labels.map((text, i) => placesOf(text, ...labelled[i])), ends).forEach(({ cx, cy }, i) => {
    labels[i].setAttribute("x", cx);
    labels[i].setAttribute("y", cy);
  });
}

export function drawScale(place, mmPerPixel) {
  const most = 120 * mmPerPixel;
  const decade = 10 ** Math.floor(Math.log10(most));
  const length = decade * (most / decade >= 5 ? 5 : most / decade >= 2 ? 2 : 1);
  place.children[0].textContent = `${Number(length.toPrecision(3))} mm`;
  place.children[1].style.width = `${length / mmPerPixel}px`;
}

export function legend(title, colors) {
  const rgb = (stop) => `rgb(${stop.map((c) => Math.round(255 * c)).join(" ")})`;
  const bar = part("div", { class: "bar", style: `background: linear-gradient(to right, ${colors.stops.map(rgb).join(", ")})` });
  const ticks = colors.ticks.map((text, i) => part("span", { style: `left: ${(100 * i * colors.step) / colors.max}%` }, text));
  return part("div", { class: "legend" }, part("div", {}, title), bar, part("div", { class: "ticks" }, ...ticks));
}
