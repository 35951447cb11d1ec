// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

import { pageData, viewMissing } from "../shared/scene.js";
import { Controls } from "./controls.js";
import { applyMarkups, markupsText } from "./markups.js";
import { Model } from "./model.js";
import { ScenarioView } from "./scenario_view.js";
import { Slice, windowOf } from "./slices.js";
import { Solid } from "./solid.js";
import { edited } from "./scenario_text.js";

function solidOf(model) {
  try {
    return new Solid(model);
  } catch (error) {
    document.querySelector(".stage").replaceChildren(viewMissing(error, "The slices do without it."));
    return null;
  }
}

const model = new Model(pageData());
const view = windowOf(model.volume.unit);
const slices = [...document.querySelectorAll(".slice")].map((figure) => new Slice(figure, model, view));
const solid = solidOf(model);
const controls = new Controls(model, slices, view);
const scenario = new ScenarioView(model);

model.listen((what) => {
  for (const slice of slices) slice.draw();
  controls.show();
  if (what === "values") scenario.show();
  if (solid === null) return;
  if (what === "values") solid.rebuild();
  else {
    solid.moveReamer();
    solid.remark();
    solid.draw();
  }
});

// For tests: what a user can see, as numbers.
globalThis.preview = { model, slices, solid, edited, applyMarkups: (text) => applyMarkups(model, text), markupsText: () => markupsText(model) };
requestAnimationFrame(() => setTimeout(() => { document.documentElement.dataset.readyMs = Math.round(performance.now()); }));
