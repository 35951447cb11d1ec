// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

import { find, pageData, part, viewMissing } from "../shared/scene.js";
import { Controls, saveText } from "./controls.js";
import { applyMarkups, markupsText } from "./markups.js";
import { Model } from "./model.js";
import { Slice, windowOf } from "./slices.js";
import { Solid } from "./solid.js";
import { edited, scenarioText } from "./scenario_text.js";

// --- the text of the scenario with its changed lines marked, to copy or to save

// Which lines of `after` are not in `before`, or more often than there, between the first and the last line that differ.
function changedLines(before, after) {
  const most = Math.min(before.length, after.length);
  let first = 0, same = 0;
  while (first < most && before[first] === after[first]) ++first;
  while (same < most - first && before.at(-1 - same) === after.at(-1 - same)) ++same;
  const left = new Map();
  for (const line of before.slice(first, before.length - same)) left.set(line, (left.get(line) ?? 0) + 1);
  return after.map((line, i) => {
    if (i < first || i >= after.length - same) return false;
    const count = left.get(line) ?? 0;
    left.set(line, count - 1);
    return count <= 0;
  });
}

class ScenarioView {
  constructor(model) {
    this.model = model;
    this.text = model.data.scenario;
    find("save").addEventListener("click", () => this.save());
    find("copy").addEventListener("click", () => this.copy());
    find("undo").addEventListener("click", () => model.undo());
    this.show();
  }

  show() {
    const { data } = this.model;
    let problem = "";
    try {
      this.text = scenarioText(this.model);
    } catch (error) {
      problem = error.message;
    }
    const before = data.scenario.split("\n"), after = this.text.split("\n");
    const changed = this.text === data.scenario ? [] : changedLines(before, after);
    find("yaml").replaceChildren(...after.flatMap((line, i) => [changed[i] ? part("mark", {}, line) : line, i + 1 < after.length ? "\n" : ""]));
    const count = changed.filter((each) => each).length;
    find("yaml-state").textContent = problem !== "" ? `Not written: ${problem}.` : this.text === data.scenario ? "Unchanged." : count === 0 ? "Lines removed." : `${count} ${count === 1 ? "line" : "lines"} changed.`;
    find("yaml-state").classList.toggle("bad", problem !== "");
    find("undo").disabled = this.model.same();
  }

  save() {
    saveText(this.text, this.model.data.file_name, "application/yaml");
    find("yaml-state").textContent = `Saved as ${this.model.data.file_name}.`;
  }

  async copy() {
    let done = true;
    try {
      await navigator.clipboard.writeText(this.text);
    } catch {
      getSelection().selectAllChildren(find("yaml"));
      done = document.execCommand("copy");
    }
    find("yaml-state").textContent = done ? "Copied." : "Copying is not allowed here: select the text.";
  }
}

// --- the page

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
const slices = [2, 1, 0].map((axis) => new Slice(axis, model, view));
const solid = solidOf(model);
const controls = new Controls(model, slices, view);
const scenario = new ScenarioView(model);

model.notify = (what) => {
  for (const slice of slices) slice.draw();
  controls.show();
  if (what === "values") scenario.show();
  solid?.show();
};

// For tests: what a user can see, as numbers.
globalThis.preview = { model, slices, solid, edited, applyMarkups: (text) => applyMarkups(model, text), markupsText: () => markupsText(model) };
requestAnimationFrame(() => setTimeout(() => { document.documentElement.dataset.readyMs = Math.round(performance.now()); }));
