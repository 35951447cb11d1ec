// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

import { find, pageData, part, significantText, tableRow } from "../shared/page.js";
import { fillColumns, readStudy } from "./data.js";
import { Effects } from "./effects.js";
import { Filters, addChecks } from "./filters.js";
import { Scatter } from "./scatter.js";
import { Table } from "./table.js";

const start = performance.now();
const study = readStudy(pageData());
const withState = (state) => Uint32Array.from(study.states.keys()).filter((run) => study.stateText(run) === state);
const done = withState("done");

// --- the values of one run

function valueRow(text, value, key) {
  return tableRow(text.charAt(0).toUpperCase() + text.slice(1), value, part("code", {}, key));
}

const dialog = find("run-dialog");
find("run-close").addEventListener("click", () => dialog.close());

function showRun(run) {
  find("run-title").textContent = `Run ${study.numbers[run]}, ${study.stateText(run)}`;
  find("run-message").textContent = study.message(run);
  const files = study.stateText(run) === "done" ? [...(study.reports[run] ? ["report.html"] : []), "summary.json", "scenario.yaml"] : [];
  find("run-links").replaceChildren(...files.flatMap((file) => [part("a", { href: `runs/${study.ids[run]}/${file}` }, file), " "]));
  find("run-values").replaceChildren(...study.columns.map((column) => valueRow(column.title, column.cell(run), column.key)));
  dialog.showModal();
  dialog.querySelector(".scroll").scrollTop = 0;
}

// --- which runs failed or have warnings, and why

function showMessages(id, runs, what) {
  if (runs.length === 0) return;
  const runsOf = new Map();
  for (const run of runs) {
    if (!runsOf.has(study.message(run))) runsOf.set(study.message(run), []);
    runsOf.get(study.message(run)).push(run);
  }
  find(id).hidden = false;
  find(`${id}-title`).textContent = `${runs.length} of ${study.count} runs ${what}`;
  const most = [...runsOf].sort((a, b) => b[1].length - a[1].length).slice(0, 10);
  find(`${id}-list`).replaceChildren(...most.map(([message, same]) => part("li", {},
    part("button", { type: "button", class: "as-link", onclick: () => showRun(same[0]) }, `Run ${study.numbers[same[0]]}`),
    `${same.length > 1 ? ` and ${same.length - 1} more` : ""}: ${message}`)));
}

// --- columns of the table

function listColumns(table) {
  const headline = study.headline.length > 0 ? study.headline : study.results.slice(0, 6).map((column) => column.key);
  const hidden = new Set(study.results.map((column) => column.key).filter((key) => !headline.includes(key)));
  const show = () => table.showColumns(study.columns.filter((column) => !hidden.has(column.key)));
  addChecks(find("column-list"), study.columns.map(({ key, title }) => [key, `${title} `, part("code", {}, key)]), hidden, show);
  const labels = find("column-list").querySelectorAll("label");
  find("column-search").addEventListener("input", (event) => {
    const wanted = event.target.value.trim().toLowerCase();
    study.columns.forEach(({ key, title }, i) => { labels[i].hidden = !`${title} ${key}`.toLowerCase().includes(wanted); });
  });
  show();
}

// --- what depends on the filters

const table = new Table(study, showRun);
const effects = new Effects(study);
const scatter = new Scatter(study, showRun);
let waiting = 0;
const filters = new Filters(study, () => {
  clearTimeout(waiting);
  waiting = setTimeout(showFiltered, 60);
});

function showFiltered() {
  const runs = filters.runs();
  find("shown").textContent = `${significantText(runs.length)} of ${significantText(study.count)} runs shown`;
  table.show(runs);
  effects.show(runs);
  scatter.show(runs);
}

const counts = ["done", "failed", "interrupted", "missing"].map((state) => [withState(state).length, state]);
const missing = study.count < study.all ? ` The page has ${study.count} of the ${study.all} runs, drawn at random; runs.csv has all.` : "";
find("counts").textContent = `${significantText(study.count)} runs: ${counts.filter(([n]) => n > 0).map(([n, state]) => `${significantText(n)} ${state}`).join(", ")}.${missing}`;
showMessages("failures", withState("failed"), "failed");
showMessages("warned", done.filter((run) => study.message(run) !== ""), "are done and have warnings");
const results = study.headline.map((key) => study.byKey.get(key));
const others = study.results.filter((column) => !results.includes(column));
fillColumns(find("effect-result"), [["Headline", results], ["Other results", others]], study.headline[0]);
const result = study.byKey.get(find("effect-result").value);
const ranked = result && done.length > 1 ? effects.ranked(result, done) : [];
const first = ranked[0]?.parameter ?? study.columns[0];
scatter.choose(first?.key, (result ?? study.columns[study.columns.length - 1])?.key, ranked[1]?.parameter.key);
listColumns(table);
find("same-table").tBodies[0].append(...study.constants.map((made) => valueRow(made.unit ? `${made.text}, ${made.unit}` : made.text, made.value, made.key)));
find("same").hidden = study.constants.length === 0;
showFiltered();
window.study = { study, effects };  // for tests
requestAnimationFrame(() => { document.documentElement.dataset.readyMs = String(Math.round(performance.now() - start)); });
