// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A slice across an axis: image, outlines, reamer, points, cross; in the radiological convention where axes are a patient's.
import { find, fixedText } from "../shared/scene.js";
import { colors, marksOf } from "./model.js";

// Lines where a function on a grid is `level`, by marching squares.
// `value(column, row)`; `segment(x0, y0, x1, y1)` gets the ends of each piece in columns and rows.
function contour(columns, rows, value, level, segment) {
  let above = new Float32Array(columns), below = new Float32Array(columns);
  for (let column = 0; column < columns; ++column) below[column] = value(column, 0) - level;
  const ends = new Float64Array(8);
  for (let row = 0; row + 1 < rows; ++row) {
    [above, below] = [below, above];
    for (let column = 0; column < columns; ++column) below[column] = value(column, row + 1) - level;
    for (let column = 0; column + 1 < columns; ++column) {
      const corners = [above[column], above[column + 1], below[column + 1], below[column]];
      if (corners[0] > 0 === corners[1] > 0 && corners[1] > 0 === corners[2] > 0 && corners[2] > 0 === corners[3] > 0) continue;
      let count = 0;
      for (let side = 0; side < 4; ++side) {
        const a = corners[side], b = corners[(side + 1) % 4];
        if (a > 0 === b > 0) continue;
        const t = a / (a - b);
        ends[count++] = column + [t, 1, 1 - t, 0][side];
        ends[count++] = row + [0, t, 1, 1 - t][side];
      }
      // With four crossings the sign of the mean decides which corners are connected.
      const first = count === 8 && (corners[0] + corners[1] + corners[2] + corners[3] > 0) === corners[0] > 0 ? 2 : 0;
      for (let i = 0; i < count; i += 4) {
        const from = (first + i) % count, to = (first + i + 2) % count;
        segment(ends[from], ends[from + 1], ends[to], ends[to + 1]);
      }
    }
  }
}

// across, down: axes of columns and rows; `up`: the rows' axis points up.
const kViews = {
  2: { name: "Axial", across: 0, down: 1, up: false, letters: ["R", "L", "A", "P"] },
  1: { name: "Coronal", across: 0, down: 2, up: true, letters: ["R", "L", "S", "I"] },
  0: { name: "Sagittal", across: 1, down: 2, up: true, letters: ["A", "P", "S", "I"] },
};
const kNear_mm = 8;  // points further from the slice are not drawn

export class Slice {
  constructor(axis, model, window) {
    const figure = find("slice").content.firstElementChild.cloneNode(true);
    Object.assign(this, { axis, figure, model, window, ...kViews[axis] });
    figure.dataset.axis = axis;
    document.querySelector(".solid").before(figure);
    this.canvas = figure.querySelector("canvas");
    this.slider = figure.querySelector("input");
    this.context = this.canvas.getContext("2d");
    this.image = document.createElement("canvas");
    const { lattice } = model.volume;
    this.image.width = lattice.dims[this.across];
    this.image.height = lattice.dims[this.down];
    if (!model.data.anatomical) {
      const axes = ["x", "y", "z"], a = axes[this.across], d = axes[this.down];
      this.name = `Across ${axes[axis]}`;
      this.letters = [`−${a}`, `+${a}`, ...(this.up ? [`+${d}`, `−${d}`] : [`−${d}`, `+${d}`])];
    }
    figure.querySelector(".name").textContent = this.name;
    this.slider.max = lattice.dims[this.axis] - 1;
    this.slider.setAttribute("aria-label", `${this.name} slice`);
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
  }

  listen() {
    // Not on pointerdown, with which a finger begins to scroll the page.
    this.canvas.addEventListener("click", (event) => this.press(event, true));
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.pointerType === "mouse" && event.buttons === 1 && this.model.tool === "look") this.press(event, false);
    });
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    this.canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== this.canvas) return;  // without focus the wheel scrolls the page
      event.preventDefault();
      this.step(Math.sign(event.deltaY));
    }, { passive: false });
    this.slider.addEventListener("input", () => {
      const cross = [...this.model.cross];
      cross[this.axis] = this.model.volume.lattice.mm(Number(this.slider.value), this.axis);
      this.model.moveCross(cross);
    });
  }

  press(event, places) {
    const box = this.canvas.getBoundingClientRect();
    const place = this.placeAt(event.clientX - box.left, event.clientY - box.top);
    if (!this.model.volume.lattice.contains(place)) return;
    this.model.moveCross(place);
    if (places) this.model.place(this.model.tool, this.model.cross);
  }

  // Page Up and Page Down, and the wheel.
  step(by) {
    const { lattice } = this.model.volume, cross = [...this.model.cross];
    cross[this.axis] = lattice.mm(Math.min(lattice.dims[this.axis] - 1, Math.max(0, lattice.nearest(cross, this.axis) + by)), this.axis);
    this.moveTo(cross);
  }

  // The chosen point goes along if it is at the cross.
  moveTo(cross) {
    const { model } = this, point = model.pointOf(model.tool);
    const along = model.tool !== "look" && point !== null && point.every((p, i) => Math.abs(p - model.cross[i]) < 0.011);
    model.moveCross(cross);
    if (along) model.place(model.tool, model.cross, true);
  }

  key(event) {
    const moves = { ArrowLeft: [this.across, -1], ArrowRight: [this.across, 1], ArrowUp: [this.down, this.up ? 1 : -1], ArrowDown: [this.down, this.up ? -1 : 1] };
    if (event.key in moves) {
      const [axis, by] = moves[event.key], cross = [...this.model.cross];
      cross[axis] += by * this.model.volume.lattice.spacing[axis] * (event.shiftKey ? 5 : 1);
      this.moveTo(cross);
    } else if (event.key === "PageUp" || event.key === "PageDown") this.step(event.key === "PageUp" ? 1 : -1);
    else if (event.key === "Enter") this.model.place(this.model.tool, this.model.cross);
    else return;
    event.preventDefault();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0) return;
    this.ratio = Math.min(window.devicePixelRatio, 2);
    this.canvas.width = Math.round(this.ratio * clientWidth);
    this.canvas.height = Math.round(this.ratio * clientHeight);
    this.draw();
  }

  // The middle of the view in mm and CSS pixels per mm. Zoomed in, it follows the cross.
  frame() {
    const { lattice } = this.model.volume, { clientWidth: width, clientHeight: height } = this.canvas;
    const size = [this.across, this.down].map((axis) => lattice.high(axis) - lattice.low(axis));
    const scale = this.window.zoom * Math.min(width / size[0], height / size[1]);
    const middle = [this.across, this.down].map((axis, i) => {
      const half = (0.5 * [width, height][i]) / scale;
      const low = lattice.low(axis) + half, high = lattice.high(axis) - half;
      return low >= high ? 0.5 * (lattice.low(axis) + lattice.high(axis)) : Math.min(high, Math.max(low, this.model.cross[axis]));
    });
    return { middle, scale, width, height };
  }

  placeAt(x, y) {
    const { middle, scale, width, height } = this.frame(), place = [...this.model.cross];
    place[this.across] = middle[0] + (x - 0.5 * width) / scale;
    place[this.down] = middle[1] + ((this.up ? -1 : 1) * (y - 0.5 * height)) / scale;
    return place;
  }

  pixelOf(point) {
    const { middle, scale, width, height } = this.frame();
    return [0.5 * width + scale * (point[this.across] - middle[0]), 0.5 * height + (this.up ? -1 : 1) * scale * (point[this.down] - middle[1])];
  }

  paintImage(index) {
    const { volume } = this.model, { lattice, values } = volume;
    const shade = new Uint8Array(256);
    for (let v = 0; v < 256; ++v) {
      const value = volume.low + volume.step * v;
      shade[v] = Math.max(0, Math.min(255, 255 * ((value - this.window.level) / this.window.width + 0.5)));
    }
    const { width, height } = this.image, pixels = new ImageData(width, height), words = new Uint32Array(pixels.data.buffer);
    for (let row = 0; row < height; ++row) {
      let at = index * lattice.steps[this.axis] + (this.up ? height - 1 - row : row) * lattice.steps[this.down];
      for (let column = 0; column < width; ++column, at += lattice.steps[this.across]) {
        const s = shade[values[at]];
        words[row * width + column] = 0xff000000 | (s << 16) | (s << 8) | s;
      }
    }
    this.image.getContext("2d").putImageData(pixels, 0, 0);
  }

  draw() {
    const { model, context } = this, { lattice } = model.volume;
    if (this.canvas.width === 0) return;
    const index = lattice.nearest(model.cross, this.axis);
    const painted = `${index} ${this.window.level} ${this.window.width}`;
    if (painted !== this.painted) this.paintImage(index);
    this.painted = painted;
    this.slider.value = index;
    this.slider.setAttribute("aria-valuetext", `${"xyz"[this.axis]} = ${lattice.mm(index, this.axis).toFixed(1)} mm`);
    this.figure.querySelector(".where").textContent = `${"xyz"[this.axis]} = ${fixedText(model.cross[this.axis], 1)} mm`;
    this.canvas.setAttribute("aria-label", `${this.name} slice. Cross at ${model.cross.map((c, i) => `${"xyz"[i]} ${c.toFixed(1)}`).join(", ")} mm.`);
    const { scale, width, height } = this.frame();
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    context.fillStyle = "#000";
    context.fillRect(0, 0, width, height);
    const corner = [0, 0, 0];
    corner[this.across] = lattice.low(this.across);
    corner[this.down] = this.up ? lattice.high(this.down) : lattice.low(this.down);
    const [x, y] = this.pixelOf(corner);
    context.imageSmoothingEnabled = true;
    context.drawImage(this.image, x, y, scale * this.image.width * lattice.spacing[this.across], scale * this.image.height * lattice.spacing[this.down]);
    if (model.segmented !== null) this.outline(model.segmented, colors.bone);
    if (model.live !== null) this.outline(model.live, colors.live);
    this.drawSpheres();
    this.drawReamer();
    this.drawCross(width, height);
    this.drawMarks();
    this.drawLetters(width, height);
  }

  stroke(color, width, trace) {
    const { context } = this;
    Object.assign(context, { strokeStyle: color, lineWidth: width });
    context.beginPath();
    trace(context);
    context.stroke();
  }

  // Lines between two points each: [x0, y0, x1, y1].
  strokeLines(color, width, lines) {
    this.stroke(color, width, (context) => {
      for (const [x0, y0, x1, y1] of lines) {
        context.moveTo(x0, y0);
        context.lineTo(x1, y1);
      }
    });
  }

  // The contour of a function on a grid; `from` and `step`, mm: its first point, and its spacing along both axes of the slice.
  strokeContour(color, width, [columns, rows], value, level, from, step) {
    const frame = this.frame(), sign = this.up ? -1 : 1;
    const x = (i) => 0.5 * frame.width + frame.scale * (from[0] + step[0] * i - frame.middle[0]);
    const y = (j) => 0.5 * frame.height + sign * frame.scale * (from[1] + step[1] * j - frame.middle[1]);
    this.stroke(color, width, (context) => contour(columns, rows, value, level, (i0, j0, i1, j1) => {
      context.moveTo(x(i0), y(j0));
      context.lineTo(x(i1), y(j1));
    }));
  }

  // The outline of a field where it meets the slice.
  outline({ lattice, bytes }, color) {
    const axes = [this.across, this.down], k = lattice.nearest(this.model.cross, this.axis) * lattice.steps[this.axis];
    const [columns, rows] = axes.map((axis) => lattice.dims[axis]), [da, dd] = axes.map((axis) => lattice.steps[axis]);
    // A border of air closes the outline at the edge of the image.
    const value = (i, j) => (i === 0 || j === 0 || i > columns || j > rows ? 0 : bytes[k + (i - 1) * da + (j - 1) * dd]);
    this.strokeContour(color, 1.4, [columns + 2, rows + 2], value, 127.5, axes.map((axis) => lattice.mm(-1, axis)), axes.map((axis) => lattice.spacing[axis]));
  }

  drawSpheres() {
    const { context, model } = this;
    context.setLineDash([5, 4]);
    for (const { center_mm: center, radius_mm } of model.values.cut_spheres) {
      const away = model.cross[this.axis] - center[this.axis];
      if (Math.abs(away) >= radius_mm) continue;
      const radius = this.frame().scale * Math.sqrt(radius_mm ** 2 - away ** 2);
      this.stroke(colors.sphere, 1.4, () => context.arc(...this.pixelOf(center), radius, 0, 2 * Math.PI));
    }
    context.setLineDash([]);
  }

  drawReamer() {
    const { reamer, posed, showsReamer, cross } = this.model;
    if (reamer === null || posed === null || !showsReamer) return;
    const cells = 110, reach = reamer.reach + 1, step = (2 * reach) / cells;
    const point = [...cross], from = [posed.origin[this.across] - reach, posed.origin[this.down] - reach];
    if (Math.abs(cross[this.axis] - posed.origin[this.axis]) > reach) return;
    const value = (i, j) => {
      point[this.across] = from[0] + step * i;
      point[this.down] = from[1] + step * j;
      return -reamer.distanceAt(posed, point);
    };
    this.strokeContour(colors.reamer, 1.8, [cells + 1, cells + 1], value, 0, from, [step, step]);
  }

  drawCross(width, height) {
    const [x, y] = this.pixelOf(this.model.cross), gap = 9;
    this.strokeLines("rgb(255 255 255 / 55%)", 1, [[0, y, x - gap, y], [x + gap, y, width, y], [x, 0, x, y - gap], [x, y + gap, x, height]]);
  }

  drawMarks() {
    const { context, model } = this;
    context.font = "600 12px system-ui, sans-serif";
    context.textBaseline = "alphabetic";
    if (model.glenoid !== null) this.drawNormal();
    for (const { tool, place, color, letter } of marksOf(model)) {
      const away = Math.abs(place[this.axis] - model.cross[this.axis]);
      if (away > kNear_mm) continue;
      const [x, y] = this.pixelOf(place), on = away <= 0.75 * model.volume.lattice.spacing[this.axis];
      context.globalAlpha = on ? 1 : 0.45;
      context.beginPath();
      context.arc(x, y, on ? 4 : 3, 0, 2 * Math.PI);
      Object.assign(context, { fillStyle: color, strokeStyle: "#000", lineWidth: tool === model.tool ? 2.5 : 1 });
      context.stroke();
      context.fill();
      context.lineWidth = 3;
      context.strokeText(letter, x + 7, y - 5);
      context.fillText(letter, x + 7, y - 5);
      context.globalAlpha = 1;
    }
  }

  // From the glenoid centre, 15 mm out of the bone, as far as it lies in the slice.
  drawNormal() {
    const { model } = this, { center, axes } = model.glenoid;
    if (Math.abs(center[this.axis] - model.cross[this.axis]) > kNear_mm) return;
    const [x0, y0] = this.pixelOf(center), [x1, y1] = this.pixelOf(center.map((c, i) => c + 15 * axes[2][i]));
    const size = Math.hypot(x1 - x0, y1 - y0);
    if (size < 4) return;
    const [ux, uy] = [(x1 - x0) / size, (y1 - y0) / size];
    const head = [-1, 1].map((side) => [x1, y1, x1 - 8 * ux + side * 4 * uy, y1 - 8 * uy - side * 4 * ux]);
    this.strokeLines(colors.center, 2, [[x0, y0, x1, y1], ...head]);
  }

  drawLetters(width, height) {
    const { context } = this, [left, right, top, bottom] = this.letters;
    Object.assign(context, { fillStyle: "#fff", strokeStyle: "#000", lineWidth: 3, font: "13px system-ui, sans-serif", textBaseline: "middle" });
    for (const [letter, x, y, align] of [[left, 6, 0.5 * height, "left"], [right, width - 6, 0.5 * height, "right"],
      [top, 0.5 * width, 12, "center"], [bottom, 0.5 * width, height - 12, "center"]]) {
      context.textAlign = align;
      context.strokeText(letter, x, y);
      context.fillText(letter, x, y);
    }
    context.textAlign = "left";
  }
}

// The whole density or radiodensity range that bone and soft tissue have.
export const windowOf = (unit) => unit === "HU"
  ? { level: 300, width: 1500, zoom: 1, least: -300, most: 1400, step: 10 }
  : { level: 0.8, width: 1.8, zoom: 1, least: 0, most: 2, step: 0.05 };
