// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Reamer, readings, curves and picture at one time of the run.
import uPlot from "uplot";
import { choices, extremes, find, fixedText, part, sayValue, significantText } from "../shared/scene.js";

// The plot: panels over one time axis, with one cursor, in Okabe and Ito's colours, as in forces.gp.
const panels = [
  { label: "Axial force", unit: "N", column: "axial_force_n", color: "#0072b2", light: "#b5d3e6", mean: "mean_axial_force_n" },
  { label: "Spin torque", unit: "N·mm", column: "spin_torque_nmm", color: "#d55e00", light: "#f3c9ab", mean: "mean_spin_torque_nmm" },
  { label: "Removed", unit: "mm³", column: "removed_mm3", color: "#009e73" },
  { label: "Tool depth", unit: "mm", column: "depth_mm", color: "#8c4f86" },
  { label: "Feed rate", unit: "mm/s", column: "feed_mm_s", color: "#0072b2" },  // of a push only
  { label: "Drill power", unit: "W", column: "drill_power_w", color: "#d55e00" },
];

// Padded axis limits. Single frames far above the mean and a retracted tool are clipped.
function limits(panel, data) {
  const [low, most] = extremes(data[panel.column]);
  let top = most, bottom = Math.min(0, low);
  if (data[panel.mean]) top = Math.min(top, 4 * extremes(data[panel.mean])[1] || top);
  if (panel.column === "depth_mm" && top > 0) bottom = Math.max(bottom, -0.25 * top);
  const air = 0.06 * (top - bottom) || 1;
  return [bottom < 0 ? bottom - air : -air / 2, top + air];
}

// The time in contact with a margin; null if that is about the whole run, or none.
function contactRange(data) {
  const removed = data.removed_mm3, times = data.time_s, last = times.length - 1;
  const end = removed.findIndex((v) => v >= removed[last]);
  const begin = removed.findIndex((v) => v > 0) - 1;
  if (!(removed[last] > 0) || end <= begin) return null;
  const air = 0.04 * (times[end] - times[Math.max(0, begin)]);
  const range = { min: Math.max(times[0], times[Math.max(0, begin)] - air), max: Math.min(times[last], times[end] + air) };
  return range.max - range.min > 0.85 * (times[last] - times[0]) ? null : range;
}

function optionsOf(panel, data, pictureTimes, onMove) {
  const line = { stroke: panel.color, width: 2, points: { show: false } };
  const series = [{}, data[panel.mean] ? { ...line, stroke: panel.light, width: 1 } : line];
  if (data[panel.mean]) series.push(line);
  const axis = { stroke: "#333", font: "12px system-ui, sans-serif", grid: { stroke: "#e3e5e8", width: 1 }, ticks: { stroke: "#b9bec5", size: 5 } };
  return {
    width: 300, height: 168, legend: { show: false },
    padding: [14, 8, 0, 0],
    scales: { x: { time: false }, y: { range: limits(panel, data) } },
    series,
    axes: [
      { ...axis, size: 44, label: "Time, s", labelSize: 18, labelGap: -6, labelFont: "12px system-ui, sans-serif" },
      { ...axis, size: 58, space: 26, values: (u, splits) => splits.map((v) => significantText(v, 6)) },
    ],
    cursor: {
      y: false, points: { size: 7, fill: panel.color }, drag: { x: true, y: false },
      sync: { key: "run" },
      bind: { mouseleave: () => null },  // keeps the cursor
    },
    hooks: {
      setCursor: [(u) => { if (u.cursor.event && u.cursor.idx != null) onMove(u.cursor.idx); }],
      draw: [(u) => { drawTicks(u, pictureTimes); }],
    },
  };
}

// Short ticks above the panel mark pictures.
function drawTicks(u, times) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.fillStyle = "#8a9099";
  for (const time of times) {
    const x = u.valToPos(time, "x", true);
    if (x >= bbox.left && x <= bbox.left + bbox.width) ctx.fillRect(Math.round(x) - 0.5, bbox.top - 6 * devicePixelRatio, devicePixelRatio, 5 * devicePixelRatio);
  }
  ctx.restore();
}

class Plots {
  constructor(place, data, pictureTimes, onMove) {
    Object.assign(this, { place, data });
    this.charts = panels.filter((panel) => data[panel.column]).map((panel) => {
      const means = data[panel.mean] ? `; dark: mean over ${data.mean_travel_mm} mm of travel` : "";
      const color = panel.color === "#009e73" ? "#00785a" : panel.color === "#d55e00" ? "#b34f00" : panel.color;
      const title = part("div", { class: "panel-title", style: `color: ${color}` }, `${panel.label}, ${panel.unit}${means}`);
      const box = part("div", { class: "panel", role: "img", "aria-label": `${panel.label} in ${panel.unit} against time` }, title);
      place.append(box);
      const columns = [data.time_s, data[panel.column], ...(data[panel.mean] ? [data[panel.mean]] : [])];
      return new uPlot(optionsOf(panel, data, pictureTimes, onMove), columns, box);
    });
    new ResizeObserver(() => this.resize()).observe(place);
    this.resize();
    this.addRanges();
  }

  // Contact only, or the whole run.
  addRanges() {
    const { time_s: times } = this.data;
    const contact = contactRange(this.data);
    const whole = { min: times[0], max: times[times.length - 1] };
    find("plot-ranges").hidden = contact === null;
    const show = (name) => {
      const range = name === "contact" ? contact : whole;
      for (const chart of this.charts) chart.setScale("x", range);
      const ends = [range.min, range.max].map((time) => time.toFixed(2));
      find("plot-range").textContent = `${ends[0]} to ${ends[1]} s of ${whole.max.toFixed(2)} s`;
    };
    const choose = choices("plot-ranges", "range", [["contact", "Contact"], ["whole", "Whole run"]], show);
    choose("contact");
    this.place.addEventListener("dblclick", () => { choose("whole"); show("whole"); });
    if (contact !== null) show("contact");
  }

  resize() {
    for (const chart of this.charts) {
      const width = chart.root.parentElement.clientWidth;
      if (width >= 50 && chart.width !== width) chart.setSize({ width, height: chart.height });
    }
    // uPlot applies the new size asynchronously, and the cursor position depends on it.
    requestAnimationFrame(() => { if (this.row !== undefined) this.moveTo(this.row); });
  }

  moveTo(row) {
    this.row = row;
    for (const chart of this.charts) {
      const left = chart.valToPos(this.data.time_s[row], "x");
      if (Math.abs(chart.cursor.left - left) > 0.5 || chart.cursor.idx !== row) chart.setCursor({ left, top: 10 }, false);
    }
  }
}

const names = { oblique: "Oblique", glenoid: "En face", section: "Section", overview: "Overview" };

const readings = [
  ["Tool depth", "depth_mm", 2, "mm"], ["Axial force", "axial_force_n", 1, "N"],
  ["Spin torque", "spin_torque_nmm", 0, "N·mm"], ["Removed", "removed_mm3", 1, "mm³"],
];

export class Run {
  // `onMove` is told the row and the time that are shown, and whether bone was removed by then.
  constructor(plot, pictures, onMove) {
    Object.assign(this, { plot, pictures, onMove });
    find("run-interactive").hidden = find("timeline").hidden = false;
    this.camera = pictures.cameras[0];
    this.slider = find("time");
    this.slider.max = plot.frame.length - 1;
    this.slider.addEventListener("input", () => { this.stop(); this.moveTo(Number(this.slider.value)); });
    this.addReadings();
    this.addCameras();
    this.addPlay();
    this.plots = new Plots(find("plots"), plot, pictures.time_s, (row) => this.moveTo(row));
    // At the last row in contact the reamer stands in the finished face.
    const last = plot.axial_force_n.findLastIndex((force, row) => force !== 0 && plot.removed_mm3[row] !== 0);
    this.moveTo(Math.max(0, last));
  }

  moveTo(row) {
    if (row === this.row) return;
    this.row = row;
    this.slider.value = row;
    const text = `${fixedText(this.plot.time_s[row], 3)} s`;
    const texts = readings.map((reading) => this.textOf(reading, row));
    sayValue("time", text, `${text}, tool depth ${texts[0].join("")}, axial force ${texts[1][0]} newton`);
    this.cells.forEach((cells, i) => cells.forEach((cell, k) => { cell.textContent = texts[i][k]; }));
    this.plots.moveTo(row);
    this.showPicture();
    this.onMove(row, this.plot.time_s[row], this.plot.removed_mm3[row] > 0);
  }

  // Number and unit of a reading. A retracted reamer has no depth.
  textOf([, column, digits, unit], row) {
    const number = this.plot[column][row];
    return column === "depth_mm" && number < 0 ? ["lifted", ""] : [fixedText(number, digits), ` ${unit}`];
  }

  // The picture nearest in time.
  showPicture() {
    if (this.camera === undefined) return;
    const time = this.plot.time_s[this.row], image = find("frame-picture");
    const i = this.pictures.time_s.reduce((best, t, k, all) => (Math.abs(t - time) < Math.abs(all[best] - time) ? k : best), 0);
    const key = `${this.camera.name}/${i}`;
    if (image.dataset.key === key) return;
    Object.assign(image.dataset, { key, frame: this.pictures.frames[i] });
    image.src = `data:image/jpeg;base64,${this.camera.jpegs[i]}`;
    image.alt = `${names[this.camera.name] ?? this.camera.name} picture of frame ${this.pictures.frames[i]}, ${fixedText(this.pictures.time_s[i], 3)} s`;
    find("frame-caption").textContent = `Nearest picture: frame ${this.pictures.frames[i]}, ${fixedText(this.pictures.time_s[i], 3)}\u00a0s`;
  }

  addReadings() {
    this.cells = readings.map(([label]) => {
      const cells = [part("span"), part("span", { class: "unit" })];
      find("readings").append(part("div", {}, part("dt", {}, label), part("dd", {}, ...cells)));
      return cells;
    });
  }

  addCameras() {
    const place = find("frame-cameras");
    place.hidden = this.pictures.cameras.length < 2;
    document.querySelector(".frame figure").hidden = this.camera === undefined;
    if (this.camera !== undefined) Object.assign(find("frame-picture"), { width: this.camera.width_px, height: this.camera.height_px });
    this.pictures.cameras.forEach((camera, i) => {
      const choose = () => { this.camera = camera; this.showPicture(); };
      place.append(part("label", {}, part("input", { type: "radio", name: "camera", checked: i === 0, onchange: choose }), ` ${names[camera.name] ?? camera.name}`));
    });
  }

  // Plays the run once, in 5 to 15 s. Who wants less motion gets the next picture with every press.
  addPlay() {
    const button = find("play");
    const still = matchMedia("(prefers-reduced-motion: reduce)");
    const name = () => { button.textContent = this.playing !== undefined ? "Pause" : still.matches ? "Next" : "Play"; };
    this.stop = () => {
      cancelAnimationFrame(this.playing);
      this.playing = undefined;
      name();
    };
    button.addEventListener("click", () => {
      if (this.playing !== undefined) this.stop();
      else if (still.matches) this.showNext();
      else this.play();
      name();
    });
    still.addEventListener("change", () => this.stop());
    name();
  }

  play() {
    const times = this.plot.time_s;
    const end = times[times.length - 1];
    const begin = this.row === times.length - 1 ? times[0] : times[this.row];
    const speed = (end - times[0]) / Math.min(15, Math.max(5, end - times[0])) / 1000;
    const start = performance.now();
    const step = (now) => {
      const time = begin + speed * Math.max(0, now - start);
      this.playing = requestAnimationFrame(step);
      this.moveTo(this.rowAt(time));
      if (time >= end) this.stop();
    };
    this.playing = requestAnimationFrame(step);
  }

  // The next picture, or a tenth of the run without pictures.
  showNext() {
    const times = this.plot.time_s;
    const end = times[times.length - 1];
    const stops = this.pictures.time_s.length > 1 ? this.pictures.time_s : Array.from({ length: 11 }, (_, i) => times[0] + (i / 10) * (end - times[0]));
    const next = stops.find((time) => this.rowAt(time) > this.row);
    this.moveTo(this.rowAt(next ?? stops[0]));
  }

  rowAt(time) {
    const row = this.plot.time_s.findIndex((t) => t >= time);
    return row < 0 ? this.plot.time_s.length - 1 : row;
  }
}
