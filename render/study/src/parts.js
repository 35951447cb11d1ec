// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Makes elements.
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

export const find = (id) => document.getElementById(id);

// Fills a list of columns to choose from.
export function fillColumns(select, groups, chosen) {
  select.replaceChildren(...groups.flatMap(([label, columns]) => {
    const options = columns.map((column) => part("option", { value: column.key, selected: column.key === chosen }, column.title));
    if (options.length === 0) return [];
    return label === "" ? options : [part("optgroup", { label }, ...options)];
  }));
}

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
