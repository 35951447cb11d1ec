// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Colours and short names of what both slices and 3D view draw; after Okabe and Ito, which colour-blind readers tell apart.
export const colors = {
  bone: "#E69F00", live: "#56B4E9", reamer: "#2fd6a4", sphere: "#CC79A7", cross: "#ffffff",
  center: "#ff6a1f", superior: "#F0E442", seed: "#ffffff", trigonum: "#5fb1ff", inferior: "#ff9bd2", rim: "#9df27d",
};

export const letters = { center: "C", superior: "S", seed: "seed", trigonum: "TS", inferior: "IA", rim: "" };

// The points of a model: tool, place, colour, letter.
export function marksOf(model) {
  const { values } = model, marks = [];
  for (const tool of ["center", "superior", "seed", "trigonum", "inferior"]) {
    const place = model.pointOf(tool);
    if (place !== null) marks.push({ tool, place, color: colors[tool], letter: letters[tool] });
  }
  values.rim.forEach((place, i) => marks.push({ tool: "rim", place, color: colors.rim, letter: String(i + 1) }));
  return marks;
}
