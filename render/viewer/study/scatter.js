// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A scatter plot of one column over another, coloured by a third.
import { extremes, find, part, significantText, stepsOf } from "../shared/page.js";
import { fillColumns } from "./data.js";

// Okabe and Ito's colours, as in the plots; black for the eighth.
const kColors = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a6a00", "#000000"];
const kRamp = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [220, 200, 30]];  // viridis; its yellow is too light on white
const kHigh = 420, kLeft = 74, kRight = 14, kTop = 12, kBottom = 46;
const kReach = 14;  // px from the pointer to a run
const kSelects = ["scatter-x", "scatter-y", "scatter-color"];

function rampColor(t) {
  const at = Math.min(0.9999, Math.max(0, t)) * (kRamp.length - 1);
  const [i, f] = [Math.floor(at), at % 1];
  return `rgb(${kRamp[i].map((c, k) => Math.round(c + f * (kRamp[i + 1][k] - c))).join(" ")})`;
}

function limits(column, runs) {
  return extremes(Array.from(runs, (run) => column.values[run]).filter((value) => !Number.isNaN(value)));
}

export class Scatter {
  constructor(study, showRun) {
    Object.assign(this, { study, showRun });
    this.canvas = find("scatter-canvas");
    this.context = this.canvas.getContext("2d", { willReadFrequently: true });
    this.runs = new Uint32Array();
    this.chosen = -1;
    for (const id of kSelects) find(id).addEventListener("change", () => this.draw());
    this.canvas.addEventListener("pointermove", (event) => this.point(event));
    this.canvas.addEventListener("click", (event) => {
      const chosen = this.point(event);
      if (chosen >= 0) this.showRun(this.points[chosen].run);
    });
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    // A change of height alone, as of the text below the plot, changes nothing in it.
    new ResizeObserver(() => { if (this.canvas.parentElement.clientWidth !== this.width) this.draw(); }).observe(this.canvas.parentElement);
  }

  choose(x, y, color) {
    const all = [["Parameters", this.study.parameters], ["Results", this.study.results]];
    fillColumns(find("scatter-x"), all, x);
    fillColumns(find("scatter-y"), all, y);
    fillColumns(find("scatter-color"), [["", [{ key: "", title: "None" }]], ...all], color ?? "");
  }

  show(runs) {
    this.runs = runs;
    this.draw();
  }

  // Across, up and colour; undefined: none.
  get columns() { return kSelects.map((id) => this.study.byKey.get(find(id).value)); }

  // Room for levels beside one another; for numbers some air.
  static axis(column, runs) {
    const [low, high] = limits(column, runs);
    const isText = column.levels && !column.numeric;
    const air = isText ? 0.5 : 0.04 * (high - low) || Math.abs(high) * 0.1 || 1;
    const ticks = isText && column.levels.length <= 12 ? column.levels.map((text, i) => [i + 1, text]) : null;
    return { low: low - air, high: high + air, ticks, isText };
  }

  draw() {
    const [x, y, color] = this.columns;
    const ratio = devicePixelRatio || 1, width = this.canvas.parentElement.clientWidth;
    if (!x || !y || width < 50) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(kHigh * ratio);
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${kHigh}px` });
    const runs = this.runs.filter((run) => !Number.isNaN(x.values[run]) && !Number.isNaN(y.values[run]));
    const draw = this.context;
    draw.setTransform(ratio, 0, 0, ratio, 0, 0);
    draw.font = "12px system-ui, sans-serif";
    this.width = width;
    this.chosen = -1;
    find("scatter-run").textContent = "";
    if (runs.length === 0) {
      this.points = [];
      draw.fillText("No run has values of both columns.", kLeft, 40);
    } else {
      this.makePoints(x, y, runs);
      this.drawAxes(draw, x, y);
      this.drawPoints(draw, color);
    }
    this.legend(color, runs);
    const without = this.runs.length - runs.length;
    this.canvas.setAttribute("aria-label", `Scatter plot of ${y.title} over ${x.title}${color ? `, coloured by ${color.title}` : ""}: ${runs.length} runs${without > 0 ? `; ${without} have no value` : ""}. The table has the same values.`);
  }

  makePoints(x, y, runs) {
    [this.across, this.up] = [Scatter.axis(x, runs), Scatter.axis(y, runs)];
    const [wide, high] = [this.width - kLeft - kRight, kHigh - kTop - kBottom];
    this.toX = (value) => kLeft + ((value - this.across.low) / (this.across.high - this.across.low)) * wide;
    this.toY = (value) => kTop + high - ((value - this.up.low) / (this.up.high - this.up.low)) * high;
    // Runs of the same level stand beside one another.
    const spread = x.levels ? Math.min(18, (0.3 * wide) / x.levels.length) : 0;
    this.points = Array.from(runs, (run, i) => ({ run, x: this.toX(x.values[run]) + (((i * 0.618) % 1) - 0.5) * spread, y: this.toY(y.values[run]) }));
    this.order = this.points.map((_, i) => i).sort((a, b) => this.points[a].x - this.points[b].x);
  }

  drawAxes(draw, x, y) {
    const line = (...points) => draw.stroke(new Path2D(`M${points.map((p) => p.join()).join("L")}`));
    Object.assign(draw, { strokeStyle: "#e3e5e8", fillStyle: "#333", lineWidth: 1, textAlign: "right" });
    for (const value of stepsOf(this.up.low, this.up.high, 7)) {
      if (this.up.ticks) break;
      line([kLeft, this.toY(value)], [this.width - kRight, this.toY(value)]);
      draw.fillText(significantText(value), kLeft - 8, this.toY(value) + 4);
    }
    for (const [value, text] of this.up.ticks ?? []) draw.fillText(text.slice(0, 10), kLeft - 8, this.toY(value) + 4);
    draw.textAlign = "center";
    const ticks = this.across.ticks ?? stepsOf(this.across.low, this.across.high, Math.max(3, this.width / 110)).map((value) => [value, significantText(value)]);
    let free = -Infinity;
    for (const [value, text] of ticks) {
      const half = draw.measureText(text).width / 2;
      if (this.toX(value) - half < free) continue;
      free = this.toX(value) + half + 6;
      draw.fillText(text, this.toX(value), kHigh - kBottom + 18);
    }
    draw.strokeStyle = "#606060";
    line([kLeft, kTop], [kLeft, kHigh - kBottom], [this.width - kRight, kHigh - kBottom]);
    draw.fillText(x.title, kLeft + (this.width - kLeft - kRight) / 2, kHigh - 8, this.width - kLeft - kRight);
    draw.save();
    draw.translate(14, kTop + (kHigh - kTop - kBottom) / 2);
    draw.rotate(-Math.PI / 2);
    draw.fillText(y.title, 0, 0, kHigh - kTop - kBottom);
    draw.restore();
  }

  // The colour of a run: of up to eight levels their own, of numbers a ramp.
  colors(color, runs) {
    if (!color) return () => kColors[0];
    if (color.levels?.length <= kColors.length) return (run) => kColors[color.codes[run]];
    const [low, high] = limits(color, runs);
    return (run) => (Number.isNaN(color.values[run]) ? "#b9bec5" : rampColor((color.values[run] - low) / (high - low || 1)));
  }

  drawPoints(draw, color) {
    const colorOf = this.colors(color, this.points.map((point) => point.run));
    const radius = this.points.length > 3000 ? 2 : this.points.length > 400 ? 2.7 : 3.6;
    draw.globalAlpha = this.points.length > 400 ? 0.65 : 0.85;
    for (const { run, x, y } of this.points) {
      draw.fillStyle = colorOf(run);
      draw.beginPath();
      draw.arc(x, y, radius, 0, 2 * Math.PI);
      draw.fill();
    }
    draw.globalAlpha = 1;
    this.picture = draw.getImageData(0, 0, this.canvas.width, this.canvas.height);
  }

  legend(color, runs) {
    const place = find("scatter-legend");
    place.replaceChildren();
    if (!color || runs.length === 0) return;
    place.append(part("span", { class: "legend-title" }, color.title));
    if (color.levels?.length <= kColors.length) {
      for (const i of color.order) place.append(part("span", { class: "key" }, part("i", { style: `background: ${kColors[i]}` }), color.levels[i]));
      return;
    }
    const [low, high] = limits(color, runs);
    const stops = [0, 0.25, 0.5, 0.75, 1].map(rampColor).join(", ");
    place.append(part("span", {}, significantText(low)), part("i", { class: "ramp", style: `background: linear-gradient(to right, ${stops})` }), part("span", {}, significantText(high)));
  }

  point(event) {
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let [nearest, least] = [-1, kReach ** 2];
    (this.points ?? []).forEach((point, i) => {
      const distance = (point.x - x) ** 2 + (point.y - y) ** 2;
      if (distance < least) [nearest, least] = [i, distance];
    });
    if (nearest >= 0 && nearest !== this.chosen) this.mark(nearest);
    return nearest;
  }

  key(event) {
    if (!this.points?.length) return;
    if (event.key === "Enter" && this.chosen >= 0) {
      event.preventDefault();  // or the key would press the button that has the focus now
      this.showRun(this.points[this.chosen].run);
      return;
    }
    const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const at = this.order.indexOf(this.chosen);
    const to = at < 0 ? (step > 0 ? 0 : this.order.length - 1) : Math.min(this.order.length - 1, Math.max(0, at + step));
    this.mark(this.order[to]);
  }

  mark(chosen) {
    this.chosen = chosen;
    const draw = this.context;
    if (this.picture) draw.putImageData(this.picture, 0, 0);
    const { run, x, y } = this.points[chosen];
    Object.assign(draw, { strokeStyle: "#000", lineWidth: 2 });
    draw.beginPath();
    draw.arc(x, y, 7, 0, 2 * Math.PI);
    draw.stroke();
    const named = [...new Set(this.columns)].filter(Boolean);
    find("scatter-run").textContent = `Run ${this.study.numbers[run]}: ${named.map((column) => `${column.title} ${column.cell(run)}`).join("; ")}`;
  }
}
