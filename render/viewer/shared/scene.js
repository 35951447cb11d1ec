// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What report and preview share, which dist/scene.js has once for both: a 3D view with what stands beside it.
import { OrthographicCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { find, part, svgPart } from "./page.js";

export {
  ArrowHelper, BackSide, Box3, BufferAttribute, BufferGeometry, Color, Data3DTexture, DecrementWrapStencilOp, FrontSide, Group,
  IncrementWrapStencilOp, LatheGeometry, LinearFilter, Matrix4, Mesh, MeshBasicMaterial, PlaneGeometry, Quaternion, RedFormat,
  SphereGeometry, Vector2, Vector3, Vector4,
} from "three";
export * from "./materials.js";
export * from "./page.js";

const lineLength = 34;
const shortest = 14;  // an axis viewed end-on has no label

// Places of a label at the end of an axis: beyond it, above, below and beside it. `text` has its size already.
function placesOf(text, x, y) {
  const { width, height } = text.getBBox();
  const length = Math.hypot(x, y);
  const [right, down] = [x / length, y / length];
  const beyond = [x + right * (5 + width / 2), y + down * (4 + height / 2)];
  const around = [[0, -1], [0, 1], [-1, 0], [1, 0]].map(([i, j]) => [x + i * (5 + width / 2), y + j * (3 + height / 2)]);
  return [beyond, ...around].map(([cx, cy], rank) => ({ cx, cy, rank, left: cx - width / 2, right: cx + width / 2, top: cy - height / 2, bottom: cy + height / 2 }));
}

const overlap = (a, b) =>
  Math.max(0, Math.min(a.right, b.right) + 3 - Math.max(a.left, b.left)) * Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));

// How many of the sampled points of an axis lie under a label.
const crossings = (box, [x, y]) =>
  [0, 0.25, 0.5, 0.75, 1].filter((t) => t * x > box.left - 2 && t * x < box.right + 2 && t * y > box.top && t * y < box.bottom).length;

// A place for each label, one after another: that with the least overlap with those before and with the axes.
function placesOfLabels(choices, ends) {
  const chosen = [];
  for (const places of choices) {
    const cost = (place) => 1000 * chosen.reduce((sum, other) => sum + overlap(place, other), 0)
      + 20 * ends.reduce((sum, end) => sum + crossings(place, end), 0) + place.rank;
    chosen.push(places.reduce((best, place) => (cost(place) < cost(best) ? place : best)));
  }
  return chosen;
}

function drawAxes(place, look, camera) {
  const directions = look.anatomical
    ? [["superior", look.superior], ["lateral", look.outward], ["anterior", look.anterior]]
    : [["tool axis", look.axis]];
  place.replaceChildren();
  const [labels, labelled, ends] = [[], [], []];
  for (const [name, direction] of directions) {
    if (direction === null) continue;
    const eye = new Vector3(...direction).transformDirection(camera.matrixWorldInverse);
    const end = [lineLength * eye.x, -lineLength * eye.y];
    place.append(svgPart("line", { x1: 0, y1: 0, x2: end[0], y2: end[1] }));
    ends.push(end);
    if (Math.hypot(...end) < shortest) continue;
    labels.push(svgPart("text", { "text-anchor": "middle", "dominant-baseline": "central" }, name));
    labelled.push(end);
  }
  place.append(...labels);
  placesOfLabels(labels.map((text, i) => placesOf(text, ...labelled[i])), ends).forEach(({ cx, cy }, i) => {
    labels[i].setAttribute("x", cx);
    labels[i].setAttribute("y", cy);
  });
}

function drawScale(place, mmPerPixel) {
  const most = 120 * mmPerPixel;
  const decade = 10 ** Math.floor(Math.log10(most));
  const length = decade * (most / decade >= 5 ? 5 : most / decade >= 2 ? 2 : 1);
  place.children[0].textContent = `${Number(length.toPrecision(3))} mm`;
  place.children[1].style.width = `${length / mmPerPixel}px`;
}

export function legend(title, colors) {
  const rgb = (stop) => `rgb(${stop.map((c) => Math.round(255 * c)).join(" ")})`;
  const bar = part("div", { class: "bar", style: `background: linear-gradient(to right, ${colors.stops.map(rgb).join(", ")})` });
  const ticks = colors.ticks.map((text, i) => part("span", { style: `left: ${(100 * i * colors.step) / colors.max}%` }, text));
  return part("div", { class: "legend" }, part("div", {}, title), bar, part("div", { class: "ticks" }, ...ticks));
}

export const vector = (v) => new Vector3(...v);

// A 3D view that turns, moves and zooms by mouse and keyboard, with axes and a scale bar. It draws on request only.
export class View {
  // `frame`: `focus`, what it looks at; `reach`, the extent of what it shows, and `half`, the least height that it shows
  // above the focus, mm; `up`; `aside`, by which it tilts a direction along "up"; `directions`, those of drawAxes().
  constructor(canvas, frame, rendering = {}) {
    Object.assign(this, frame, { canvas });
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, ...rendering });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new Scene();
    this.camera = new OrthographicCamera();
    this.camera.up = vector(frame.up);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.controls.enableZoom = false;  // without focus the wheel scrolls the page
    canvas.addEventListener("focus", () => { this.controls.enableZoom = true; });
    canvas.addEventListener("blur", () => { this.controls.enableZoom = false; });
    canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(canvas);
  }

  addButton(name, action) {
    const button = part("button", { type: "button", onclick: action }, name);
    find("bone-views").append(button);
    return button;
  }

  look(direction, focus = this.focus, zoom = 1) {
    const { camera, controls } = this, towards = direction.clone().normalize();
    // A direction along "up" leaves the rotation of the camera undefined.
    if (Math.abs(towards.dot(camera.up)) > 0.999) towards.addScaledVector(this.aside, 0.002).normalize();
    camera.zoom = zoom;
    camera.position.copy(focus).addScaledVector(towards, 3 * this.reach + 50);
    controls.target.copy(focus);
    this.resize();
    controls.update();
    this.draw();
  }

  // A square of twice `half` remains visible for every aspect ratio of the canvas.
  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    const half = this.half * Math.max(1, height / width);
    Object.assign(this.camera, {
      left: (-half * width) / height, right: (half * width) / height, top: half, bottom: -half, near: 0.1, far: 8 * this.reach + 200,
    });
    this.camera.updateProjectionMatrix();
  }

  // Arrow keys turn by 5°, or with Shift move by a twentieth of the view's height.
  key(event) {
    const { controls } = this, turn = Math.PI / 36, move = 0.05 * this.canvas.clientHeight;
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const zoom = { "+": 1.15, "=": 1.15, "-": 1 / 1.15 }[event.key];
    if (zoom !== undefined) controls.dollyOut(zoom);
    else if (arrow === undefined) return;
    else if (event.shiftKey) controls.pan(move * arrow[0], move * arrow[1]);
    else {
      controls.rotateLeft(turn * arrow[0]);
      controls.rotateUp(-turn * arrow[1]);
    }
    event.preventDefault();
  }

  // At most once per picture of the screen, because it takes long without a GPU.
  draw() {
    this.drawing ??= requestAnimationFrame(() => {
      this.drawing = undefined;
      this.renderer.render(this.scene, this.camera);
    });
    this.camera.updateMatrixWorld();
    // For tests: what the picture alone does not tell.
    const away = this.camera.position.clone().sub(this.controls.target).normalize();
    this.canvas.dataset.towardsViewer = away.toArray().map((v) => v.toFixed(4)).join(" ");
    drawAxes(find("bone-axes"), this.directions(), this.camera);
    drawScale(find("bone-scale"), (this.camera.top - this.camera.bottom) / this.camera.zoom / this.canvas.clientHeight);
  }
}
