// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The filters: text, status, levels of parameters, ranges of any column.
import { find, part } from "../shared/page.js";
import { STATES, fillColumns } from "./data.js";

const kMostLevels = 60;  // longer lists are searched as text

// Adds check boxes with texts or elements; `hidden` has the values of those that are not checked.
export function addChecks(fieldset, items, hidden, changed) {
  for (const [value, ...words] of items) {
    const box = part("input", { type: "checkbox", checked: !hidden.has(value), onchange: () => {
      if (box.checked) hidden.delete(value);
      else hidden.add(value);
      changed();
    } });
    fieldset.append(part("label", {}, box, " ", ...words));
  }
}

export class Filters {
  constructor(study, changed) {
    Object.assign(this, { study, changed });
    this.hiddenStates = new Set();
    this.hiddenLevels = new Map();  // column -> codes
    this.ranges = new Map();  // column -> [low, high]
    find("search").addEventListener("input", () => changed());
    find("reset").addEventListener("click", () => this.reset());
    find("add-range").addEventListener("change", (event) => {
      if (event.target.value !== "") this.addRange(study.byKey.get(event.target.value), true);
      event.target.value = "";
    });
    this.makeStates();
    for (const column of study.parameters) {
      if (!column.levels) this.addRange(column, false);
      else if (column.levels.length <= kMostLevels) this.makeLevels(column);
    }
    this.listRanges();
  }

  makeStates() {
    const counts = new Array(STATES.length).fill(0);
    for (const state of this.study.states) ++counts[state];
    const items = [3, 2, 1, 0].filter((state) => counts[state] > 0).map((state) => [state, `${STATES[state]} (${counts[state]})`]);
    addChecks(find("states"), items, this.hiddenStates, this.changed);
  }

  makeLevels(column) {
    const hidden = new Set();
    this.hiddenLevels.set(column, hidden);
    const fieldset = part("fieldset", { class: "checks" }, part("legend", {}, column.title));
    addChecks(fieldset, column.order.map((code) => [code, column.levels[code]]), hidden, this.changed);
    find("parameter-filters").append(fieldset);
  }

  addRange(column, focus) {
    if (this.ranges.has(column)) return;
    const range = [-Infinity, Infinity];
    this.ranges.set(column, range);
    const end = (place, text) => part("input", { type: "number", step: "any", "aria-label": `${column.title}, ${text}`, placeholder: text, oninput: (event) => {
      const value = event.target.value === "" ? NaN : Number(event.target.value);
      range[place] = Number.isNaN(value) ? [-Infinity, Infinity][place] : value;
      this.changed();
    } });
    const fieldset = part("fieldset", { class: "range" }, part("legend", {}, column.title), end(0, "from"), end(1, "to"));
    if (!column.parameter) {
      fieldset.append(part("button", { type: "button", "aria-label": `Remove the range of ${column.title}`, onclick: () => {
        this.ranges.delete(column);
        fieldset.remove();
        this.listRanges();
        this.changed();
        find("add-range").focus();
      } }, "Remove"));
    }
    find(column.parameter ? "parameter-filters" : "ranges").append(fieldset);
    this.listRanges();
    if (focus) fieldset.querySelector("input").focus();
  }

  // The columns that have no range yet.
  listRanges() {
    const left = (columns) => columns.filter((column) => !this.ranges.has(column) && (!column.levels || column.numeric));
    fillColumns(find("add-range"), [["", [{ key: "", title: "Choose a column" }]], ["Parameters", left(this.study.parameters)], ["Results", left(this.study.results)]], "");
  }

  reset() {
    find("search").value = "";
    for (const box of document.querySelectorAll("#states input, #parameter-filters input")) {
      if (box.type === "checkbox") box.checked = true;
      else box.value = "";
    }
    this.hiddenStates.clear();
    for (const hidden of this.hiddenLevels.values()) hidden.clear();
    for (const [column, range] of [...this.ranges]) {
      range.splice(0, 2, -Infinity, Infinity);
      if (!column.parameter) this.ranges.delete(column);
    }
    find("ranges").replaceChildren();
    this.listRanges();
    this.changed();
  }

  // The runs that all filters let pass, in the order of the plan.
  runs() {
    const { study } = this;
    const levels = [...this.hiddenLevels].filter(([, hidden]) => hidden.size > 0);
    const ranges = [...this.ranges].filter(([, [low, high]]) => low > -Infinity || high < Infinity);
    const wanted = find("search").value.trim().toLowerCase();
    const out = [];
    for (let run = 0; run < study.count; ++run) {
      if (this.hiddenStates.has(study.states[run])) continue;
      if (levels.some(([column, hidden]) => hidden.has(column.codes[run]))) continue;
      if (ranges.some(([column, [low, high]]) => !(column.values[run] >= low && column.values[run] <= high))) continue;
      if (wanted !== "" && !this.text(run).includes(wanted)) continue;
      out.push(run);
    }
    return Uint32Array.from(out);
  }

  text(run) {
    const { study } = this;
    const cells = study.parameters.filter((column) => column.levels).map((column) => column.cell(run));
    return [study.numbers[run], study.ids[run], study.stateText(run), study.message(run), ...cells].join(" ").toLowerCase();
  }
}
