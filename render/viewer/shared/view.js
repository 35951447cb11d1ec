// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

import { OrthographicCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { find, part } from "./elements.js";
import { drawAxes, drawScale } from "./marks.js";

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

  key(event) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const zoom = { "+": 1.15, "=": 1.15, "-": 1 / 1.15 }[event.key];
    if (zoom !== undefined) this.zoomBy(zoom);
    else if (event.key in turns && event.shiftKey) this.pan(...turns[event.key]);
    else if (event.key in turns) this.turn(...turns[event.key]);
    else return;
    event.preventDefault();
  }

  zoomBy(factor) {
    this.camera.zoom *= factor;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  // Steps of 5° to the right and down.
  turn(right, down) {
    const { camera, controls } = this, step = Math.PI / 36;
    const away = camera.position.clone().sub(controls.target).applyAxisAngle(camera.up, -right * step);
    const across = new Vector3().crossVectors(camera.up, away).normalize();
    const tipped = away.clone().applyAxisAngle(across, down * step);
    if (Math.abs(tipped.clone().normalize().dot(camera.up)) < 0.999) away.copy(tipped);
    camera.position.copy(controls.target).add(away);
    controls.update();
    this.draw();
  }

  // Steps of a twentieth of the view's height to the right and down.
  pan(right, down) {
    const step = 0.05 * this.mmPerPixel() * this.canvas.clientHeight;
    const shift = new Vector3(-right, down, 0).transformDirection(this.camera.matrixWorld).multiplyScalar(step);
    this.camera.position.add(shift);
    this.controls.target.add(shift);
    this.controls.update();
    this.draw();
  }

  mmPerPixel() {
    return (this.camera.top - this.camera.bottom) / this.camera.zoom / this.canvas.clientHeight;
  }

  // At most once per picture of the screen, because it takes long without a GPU.
  draw() {
    this.drawing ??= requestAnimationFrame(() => {
      this.drawing = undefined;
      this.render();
    });
    this.camera.updateMatrixWorld();
    // For tests: what the picture alone does not tell.
    const away = this.camera.position.clone().sub(this.controls.target).normalize();
    this.canvas.dataset.towardsViewer = away.toArray().map((v) => v.toFixed(4)).join(" ");
    drawAxes(find("bone-axes"), this.directions(), this.camera);
    drawScale(find("bone-scale"), this.mmPerPixel());
  }

  render() {
    this.renderer.render(this.scene, this.camera);
  }
}
