// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Reamer, readings, curves and picture at one time of the run.
import { bytesOf, find, fixedText, part } from "../shared/scene.js";
import { Plots } from "./plot.js";

const names = { oblique: "Oblique", glenoid: "En face", section: "Section", overview: "Overview" };

const readings = [
  ["Tool depth", "depth_mm", 2, "mm"], ["Axial force", "axial_force_n", 1, "N"],
  ["Spin torque", "spin_torque_nmm", 0, "N·mm"], ["Removed", "removed_mm3", 1, "mm³"],
];

class Run {
  // `onMove` is told the row and the time that are shown, and whether bone was removed by then.
  constructor(plot, pictures, onMove) {
    this.plot = plot;
    this.onMove = onMove;
    this.pictures = pictures;
    this.urls = new Map();
    this.camera = pictures.cameras[0];
    this.slider = find("time");
    this.slider.max = plot.frame.length - 1;
    this.slider.addEventListener("input", () => { this.stop(); this.moveTo(Number(this.slider.value)); });
    this.addReadings();
    this.addCameras();
    this.addPlay();
    this.plots = new Plots(find("plots"), plot, pictures.time_s, (row) => this.moveTo(row));
    this.moveTo(this.rowToStartWith());
  }

  // The last row in contact: the reamer stands in the finished face.
  rowToStartWith() {
    const { removed_mm3: removed, axial_force_n: force } = this.plot;
    let row = force.length - 1;
    while (row > 0 && (force[row] === 0 || removed[row] === 0)) --row;
    return row;
  }

  moveTo(row) {
    if (row === this.row) return;
    this.row = row;
    this.slider.value = row;
    const text = `${fixedText(this.plot.time_s[row], 3)} s`;
    find("time-value").textContent = text;
    this.slider.setAttribute("aria-valuetext", `${text}, tool depth ${this.depthText(row)}, axial force ${fixedText(this.plot.axial_force_n[row], 1)} newton`);
    readings.forEach((reading, i) => this.showReading(reading, this.cells[i]));
    this.plots.moveTo(row);
    this.showPicture();
    this.onMove(row, this.plot.time_s[row], this.plot.removed_mm3[row] > 0);
  }

  depthText(row) {
    return this.plot.depth_mm[row] < 0 ? "lifted" : `${fixedText(this.plot.depth_mm[row], 2)} mm`;
  }

  // A retracted reamer has no depth.
  showReading([, column, digits, unit], [value, unitCell]) {
    const number = this.plot[column][this.row];
    const lifted = column === "depth_mm" && number < 0;
    value.textContent = lifted ? "lifted" : fixedText(number, digits);
    unitCell.textContent = lifted ? "" : ` ${unit}`;
  }

  // The picture nearest in time.
  nearestPicture() {
    const time = this.plot.time_s[this.row];
    return this.pictures.time_s.reduce((best, t, i, all) => (Math.abs(t - time) < Math.abs(all[best] - time) ? i : best), 0);
  }

  showPicture() {
    if (this.camera === undefined) return;
    const i = this.nearestPicture();
    const image = find("frame-picture");
    const key = `${this.camera.name}/${i}`;
    if (image.dataset.key === key) return;
    image.dataset.key = key;
    image.dataset.frame = this.pictures.frames[i];
    image.src = this.urlOf(key, i);
    image.alt = `${names[this.camera.name] ?? this.camera.name} picture of frame ${this.pictures.frames[i]}, ${fixedText(this.pictures.time_s[i], 3)} s`;
    find("frame-caption").textContent = `Nearest picture: frame ${this.pictures.frames[i]}, ${fixedText(this.pictures.time_s[i], 3)}\u00a0s`;
  }

  urlOf(key, i) {
    if (!this.urls.has(key)) {
      this.urls.set(key, URL.createObjectURL(new Blob([bytesOf(this.camera.jpegs[i])], { type: "image/jpeg" })));
    }
    return this.urls.get(key);
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
    const times = this.plot.time_s;
    let [low, high] = [0, times.length - 1];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] >= time) high = middle;
      else low = middle + 1;
    }
    return low;
  }
}

export function showRun(plot, pictures, onMove) {
  find("run-interactive").hidden = find("timeline").hidden = false;
  new Run(plot, pictures, onMove);
}
