// Picture, readings and plot at one time of the run.
import { Plots } from "./plot.js";
import { bytesOf } from "./decode.js";

const byId = (id) => document.getElementById(id);
const names = { oblique: "Oblique", glenoid: "En face", section: "Section", overview: "Overview" };

const readings = [
  ["Time", "time_s", 3, "s"], ["Tool depth", "depth_mm", 2, "mm"], ["Axial force", "axial_force_n", 1, "N"],
  ["Spin torque", "spin_torque_nmm", 0, "N·mm"], ["Removed", "removed_mm3", 1, "mm³"],
];

const fixed = (value, digits) => {
  const text = value.toFixed(digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
};

class Run {
  constructor(plot, pictures) {
    this.plot = plot;
    this.pictures = pictures;
    this.urls = new Map();
    this.camera = pictures.cameras[0];
    this.slider = byId("time");
    this.slider.max = plot.frame.length - 1;
    this.slider.addEventListener("input", () => this.moveTo(Number(this.slider.value)));
    this.addReadings();
    this.addCameras();
    this.addPlay();
    this.plots = new Plots(byId("plots"), plot, pictures.time_s, (row) => this.moveTo(row));
    this.moveTo(this.rowToStartWith());
  }

  // The row of the picture with the greatest force: picture and readings agree.
  rowToStartWith() {
    const force = this.plot.axial_force_n;
    return this.pictures.time_s.map((time) => this.rowAt(time)).reduce((best, row) => (force[row] > force[best] ? row : best), 0);
  }

  moveTo(row) {
    if (row === this.row) return;
    this.row = row;
    this.slider.value = row;
    const text = `${fixed(this.plot.time_s[row], 3)} s`;
    byId("time-value").textContent = text;
    this.slider.setAttribute("aria-valuetext", `${text}, axial force ${fixed(this.plot.axial_force_n[row], 1)} newton`);
    readings.forEach((reading, i) => this.showReading(reading, this.cells[i]));
    this.plots.moveTo(row);
    this.showPicture();
  }

  // A retracted reamer has no depth.
  showReading([, column, digits, unit], [value, unitCell]) {
    const number = this.plot[column][this.row];
    const lifted = column === "depth_mm" && number < 0;
    value.textContent = lifted ? "lifted" : fixed(number, digits);
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
    const image = byId("frame-picture");
    const key = `${this.camera.name}/${i}`;
    if (image.dataset.key === key) return;
    image.dataset.key = key;
    image.dataset.frame = this.pictures.frames[i];
    image.src = this.urlOf(key, i);
    image.alt = `${names[this.camera.name] ?? this.camera.name} picture of frame ${this.pictures.frames[i]}, ${fixed(this.pictures.time_s[i], 3)} s`;
    byId("frame-caption").textContent = `Nearest picture: frame ${this.pictures.frames[i]}, ${fixed(this.pictures.time_s[i], 3)}\u00a0s`;
  }

  urlOf(key, i) {
    if (!this.urls.has(key)) {
      this.urls.set(key, URL.createObjectURL(new Blob([bytesOf(this.camera.jpegs[i])], { type: "image/jpeg" })));
    }
    return this.urls.get(key);
  }

  addReadings() {
    this.cells = readings.map(([label]) => {
      const box = document.createElement("div");
      const value = document.createElement("span");
      const unit = Object.assign(document.createElement("span"), { className: "unit" });
      const cell = document.createElement("dd");
      cell.append(value, unit);
      box.append(Object.assign(document.createElement("dt"), { textContent: label }), cell);
      byId("readings").append(box);
      return [value, unit];
    });
  }

  addCameras() {
    const place = byId("frame-cameras");
    place.hidden = this.pictures.cameras.length < 2;
    document.querySelector(".frame figure").hidden = this.camera === undefined;
    if (this.camera !== undefined) Object.assign(byId("frame-picture"), { width: this.camera.width_px, height: this.camera.height_px });
    this.pictures.cameras.forEach((camera, i) => {
      const input = Object.assign(document.createElement("input"), { type: "radio", name: "camera", checked: i === 0 });
      input.addEventListener("change", () => { this.camera = camera; this.showPicture(); });
      const label = document.createElement("label");
      label.append(input, ` ${names[camera.name] ?? camera.name}`);
      place.append(label);
    });
  }

  // Plays all pictures within five seconds.
  addPlay() {
    const button = byId("play");
    button.hidden = this.pictures.frames.length < 2;
    const stop = () => {
      clearInterval(this.playing);
      this.playing = undefined;
      button.textContent = "Play";
      button.setAttribute("aria-pressed", "false");
    };
    button.addEventListener("click", () => {
      if (this.playing !== undefined) return stop();
      let i = this.nearestPicture() >= this.pictures.frames.length - 1 ? -1 : this.nearestPicture();
      button.textContent = "Pause";
      button.setAttribute("aria-pressed", "true");
      this.playing = setInterval(() => {
        this.moveTo(this.rowAt(this.pictures.time_s[++i]));
        if (i >= this.pictures.frames.length - 1) stop();
      }, Math.max(80, 5000 / this.pictures.frames.length));
    });
  }

  rowAt(time) {
    const row = this.plot.time_s.findIndex((t) => t >= time);
    return row < 0 ? this.plot.time_s.length - 1 : row;
  }
}

export function showRun(plot, pictures) {
  byId("run-interactive").hidden = false;
  new Run(plot, pictures);
}
