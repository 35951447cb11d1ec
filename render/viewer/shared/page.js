// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What every page needs: elements, packed data, and numbers as people read them.
import { unzlibSync } from "fflate";

export const find = (id) => document.getElementById(id);

// What C++ has put into the page.
export const pageData = () => JSON.parse(find("page-data").textContent);

// What compressed_base64() of page.cpp has packed.
export function unpacked(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return unzlibSync(bytes);
}

export function part(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (key in made && typeof value !== "string") made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

export function svgPart(name, attributes, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

// Radio buttons behind the legend of the fieldset `id`: `options` are [value, text], act(value) is called when another one is
// chosen. Returns what chooses one.
export function choices(id, name, options, act) {
  const inputs = options.map(([value]) => part("input", { type: "radio", name, value, onchange: () => act(value) }));
  find(id).querySelector("legend").after(...inputs.flatMap((input, i) => ["\n", part("label", {}, input, ` ${options[i][1]}`)]));
  return (value) => { for (const input of inputs) input.checked = input.value === value; };
}

// Shows and says what the slider `id` stands for.
export function sayValue(id, text, said = text) {
  find(`${id}-value`).textContent = text;
  find(id).setAttribute("aria-valuetext", said);
}

// A row of a table; cells are texts, elements or cells.
export function tableRow(head, ...cells) {
  return part("tr", {}, part("th", { scope: "row" }, head), ...cells.map((cell) => (cell.tagName === "TD" ? cell : part("td", {}, cell))));
}

// Says where the 3D view would be that there is none.
export const viewMissing = (error, instead) => part("p", { class: "note" }, `This browser cannot show the 3D view (${error.message}). ${instead}`);

// --- numbers

// A true minus sign, and thin spaces between thousands from five digits on.
function typeset(text) {
  const [, sign, whole, rest] = /^(-?)(\d+)(.*)$/.exec(text);
  return (sign && "\u2212") + (whole.length < 5 ? whole : whole.replace(/\B(?=(\d{3})+$)/g, "\u2009")) + rest;
}

// With this many decimals, and never "−0.0".
export function fixedText(value, decimals) {
  const text = value.toFixed(decimals);
  return typeset(Number(text) === 0 ? text.replace("-", "") : text);
}

// As short as its significant digits allow.
export function significantText(value, digits = 5) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e9) return value.toExponential(2).replace("e+", "e").replaceAll("-", "\u2212");
  return typeset(String(Number(value.toPrecision(digits))));
}

const rounded = (value, decimals) => (Math.sign(value) * Math.round(Math.abs(value) * 10 ** decimals)) / 10 ** decimals;

// 0.25 stays 0.25, but 28.996 becomes 29.00, where the zeros are significant.
function withoutZeros(value, decimals) {
  let kept = decimals;
  while (kept > 0 && Math.abs(value - rounded(value, kept - 1)) < 1e-9 * Math.abs(value)) --kept;
  return kept;
}

// With this many significant digits, and exponents as in 1.2 × 10⁻⁸.
export function numberText(value, digits = 4) {
  if (value === 0) return "0";
  const exponent = Number(value.toExponential(digits - 1).split("e")[1]);
  if (exponent >= -4) return typeset(value.toFixed(withoutZeros(value, Math.max(0, digits - 1 - exponent))));
  const raised = String(-exponent).replace(/\d/g, (digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]);
  return `${typeset((value / 10 ** exponent).toFixed(1))} × 10⁻${raised}`;
}

// Decimals that mean something for a quantity of a reamed bone.
const decimalsOf = { mm: 2, "mm²": 1, "mm³": 1, N: 1, "N·mm": 0, mJ: 0, "°": 1, "%": 1, s: 3, HU: 0, "g/cm³": 2 };

// A measured value with the decimals of its unit, and digits behind the point only up to the fourth significant one:
// 0.2734 mm is "0.27". Below ten steps it has one decimal more, and a positive value that would be zero is "< 0.01".
// A value of another unit has three significant digits.
export function measuredText(value, unit) {
  const digits = 4;
  if (!(unit in decimalsOf)) return numberText(value, digits - 1);
  if (value === 0) return "0";
  let decimals = decimalsOf[unit];
  if (Math.abs(value) < 10 * 10 ** -decimals) ++decimals;  // two digits of a small value
  decimals = Math.min(decimals, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value)))));
  const step = 10 ** -decimals, shown = rounded(value, decimals);
  if (value > 0 && value < 0.5 * step) return `< ${step.toFixed(decimals)}`;
  return shown === 0 ? (0).toFixed(decimals) : typeset(shown.toFixed(withoutZeros(value, decimals)));
}

export const extremes = (values) => values.reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);

// Ends of the steps of an axis: 1, 2 or 5 times a power of ten.
export function stepsOf(low, high, most) {
  const span = high - low;
  if (!(span > 0)) return [low];
  const decade = 10 ** Math.floor(Math.log10(span / most));
  const step = decade * [1, 2, 5, 10].find((times) => span / (decade * times) <= most);
  const out = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * span; ++i) out.push(Number((i * step).toPrecision(12)));
  return out;
}
