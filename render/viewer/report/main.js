// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

import { find, fixedText, measuredText, numberText, pageData, part, tableRow } from "../shared/scene.js";
import { showBone } from "./bone.js";
import { Run } from "./run.js";

// --- figures, tables, warnings and verification of the run

const longestNumber = 24;  // characters

const textOf = (value, unit) => (typeof value === "number" ? measuredText(value, unit) : typeof value === "boolean" ? (value ? "yes" : "no") : value);
const unitOf = (unit) => (unit ? [" ", part("span", { class: "unit" }, unit)] : []);
const capitalized = (text) => text.charAt(0).toUpperCase() + text.slice(1);

function keyFigure([label, value, unit]) {
  return part("div", {}, part("dt", {}, capitalized(label)), part("dd", {}, textOf(value, unit), ...unitOf(unit)));
}

// Text longer than a number wraps.
function valueRow([label, value, unit]) {
  const text = textOf(value, unit);
  return tableRow(label, part("td", text.length > longestNumber ? { class: "words" } : {}, text, ...unitOf(unit)));
}

function listRow(row, { columns, decimals }) {
  const cells = row.map((value, i) => (value === null ? "–" : typeof value === "number" ? fixedText(value, decimals[i])
    : columns[i] === "SHA-256" ? part("code", {}, value) : value));
  return tableRow(...cells);
}

// A table of values, or with `columns` one of a list.
function tableOf(table) {
  const { title, columns, rows } = table;
  const head = columns ? [part("thead", {}, part("tr", {}, ...columns.map((text) => part("th", { scope: "col" }, text))))] : [];
  const body = rows.map((row) => (columns ? listRow(row, table) : valueRow(row)));
  return part("table", {}, part("caption", {}, title), ...head, part("tbody", {}, ...body));
}

function showVerification(balance, verification) {
  if (balance.length > 0) find("balance").textContent = textOf(balance[0][1], "");
  find("unverified").hidden = verification !== null;
  if (verification === null) return;
  const { passed, suite, cases, program, device, differs } = verification;
  const status = part("p", { class: `status ${passed ? "passed" : "failed"}` },
    `Verification ${passed ? "passed" : "FAILED"}: ${suite} suite, ${cases} cases against closed forms and invariants, ${program} on ${device}.`);
  const others = differs.map((what) => part("p", { class: "status unknown" }, `It was made with another ${what} than this run.`));
  find("verification").append(status, ...others);
}

function showSummary(summary) {
  find("warnings").hidden = summary.warnings.length === 0;
  find("warnings").querySelector("ul").append(...summary.warnings.map((text) => part("li", {}, text)));
  find("key-figures").append(...summary.key_figures.map(keyFigure));
  for (const name of ["planning", "measurements", "provenance"]) {
    find(`${name}-tables`).append(...summary[name].map(tableOf));
    find(`${name}-tables`).closest("section").hidden = summary[name].length === 0;
  }
  showVerification(summary.balance, summary.verification);
  find("verification").hidden = false;
}

// --- pictures open at full size, where their text is readable on small screens

function open(picture) {
  const shown = document.querySelector("#viewer img");
  shown.src = picture.src;
  shown.alt = picture.alt;
  find("viewer-caption").textContent = picture.closest("figure").querySelector("figcaption").textContent;
  find("viewer").showModal();
}

// A button round the picture, so that the keyboard reaches it.
function makeOpenable(picture) {
  const button = part("button", { type: "button", class: "open-picture", title: "Show at full size", onclick: () => open(picture) });
  picture.replaceWith(button);
  button.append(picture);
}

function showPictures() {
  const dialog = find("viewer");
  find("viewer-close").addEventListener("click", () => dialog.close());
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
  // The 3D view takes the place of the first picture, which then begins the gallery.
  const still = document.querySelector("#bone-still.print-only");
  if (still !== null) {
    const first = still.cloneNode(true);
    first.removeAttribute("id");
    first.className = "screen-only";
    find("gallery").prepend(first);
  }
  find("pictures-help").hidden = false;
  document.querySelectorAll(".gallery img, .frame img").forEach(makeOpenable);
}

const data = pageData();
showSummary(data.summary);
const bone = showBone(data.bone, data.tool);
new Run(data.plot, data.pictures, (...moment) => bone?.moveTo(...moment));
showPictures();
globalThis.report = { measuredText, numberText };  // for tests
