// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Finds and makes elements.
export const find = (id) => document.getElementById(id);

// What C++ has put into the page.
export const pageData = () => JSON.parse(find("page-data").textContent);

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

// Calls act(value) when another radio button of this name is chosen; returns what chooses one.
export function choices(name, act) {
  const inputs = [...document.querySelectorAll(`input[name=${name}]`)];
  for (const input of inputs) input.addEventListener("change", () => act(input.value));
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
