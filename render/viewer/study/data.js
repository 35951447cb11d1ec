// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The runs of the study: decodes what render/viewer/page.cpp encodes.
import { part, significantText, unpacked } from "../shared/page.js";

export const STATES = ["missing", "interrupted", "failed", "done"];

// Four planes of bytes, as numbers of 32 bits.
function words(base64, Type) {
  const bytes = unpacked(base64);
  const count = bytes.length / 4;
  const out = new Uint32Array(count);
  for (let i = 0; i < count; ++i) {
    out[i] = bytes[i] | (bytes[count + i] << 8) | (bytes[2 * count + i] << 16) | (bytes[3 * count + i] << 24);
  }
  return new Type(out.buffer);
}

// A column of the table, decoded when it is first used.
class Column {
  constructor(made) {
    Object.assign(this, made);
    this.name = this.text.charAt(0).toUpperCase() + this.text.slice(1);
    this.title = this.unit ? `${this.name}, ${this.unit}` : this.name;
  }

  // The level of each run.
  get codes() { return this.decodedCodes ??= words(this.data, Uint32Array); }

  // Numbers to sort, filter and plot by; of texts their numbers in the order of the plan.
  get values() {
    const number = (code) => (this.numeric ? Number(this.levels[code]) : code + 1);
    return this.decoded ??= this.levels ? Float64Array.from(this.codes, number) : words(this.data, Float32Array);
  }

  // Numbers of the levels in the order in which they are listed: numbers ascend.
  get order() {
    const order = [...this.levels.keys()];
    return this.numeric ? order.sort((a, b) => Number(this.levels[a]) - Number(this.levels[b])) : order;
  }

  // What the table shows of a run.
  cell(run) {
    const value = this.values[run];
    if (this.levels) return this.numeric ? significantText(value) : this.levels[this.codes[run]];
    return Number.isNaN(value) ? "–" : significantText(value);
  }
}

export function readStudy(data) {
  const columns = (data.columns ?? []).map((made) => new Column(made));
  const states = words(data.states, Uint32Array);
  const messages = words(data.messages.data, Uint32Array);
  return {
    all: data.all,
    count: data.runs,
    numbers: words(data.numbers, Uint32Array),
    states,
    stateText: (run) => STATES[states[run]],
    reports: words(data.reports, Uint32Array),
    ids: new TextDecoder().decode(unpacked(data.ids)).split("\n"),
    message: (run) => data.messages.texts[messages[run]],
    hasMessages: data.messages.texts.some((text) => text !== ""),
    columns,
    byKey: new Map(columns.map((column) => [column.key, column])),
    parameters: columns.filter((column) => column.parameter),
    results: columns.filter((column) => !column.parameter),
    headline: data.headline.filter((key) => columns.some((column) => column.key === key)),
    constants: data.constants,
  };
}

// Fills a list of columns to choose from.
export function fillColumns(select, groups, chosen) {
  select.replaceChildren(...groups.flatMap(([label, columns]) => {
    const options = columns.map((column) => part("option", { value: column.key, selected: column.key === chosen }, column.title));
    if (options.length === 0) return [];
    return label === "" ? options : [part("optgroup", { label }, ...options)];
  }));
}
