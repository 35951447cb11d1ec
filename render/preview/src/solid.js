// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The 3D view: bone, reamer, points, cut spheres, glenoid frame. Draws on request only.
import {
  AmbientLight, ArrowHelper, BufferAttribute, BufferGeometry, DirectionalLight, DoubleSide, FrontSide, GLSL3, Group, LatheGeometry,
  Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, OrthographicCamera, Scene, ShaderMaterial, SphereGeometry, Vector2,
  Vector3, Vector4, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { drawAxes, drawScale } from "../../report/src/marks.js";
import { boneFragment, boneVertex } from "../../report/src/shaders.js";
import { colors, marksOf } from "./looks.js";

const vector = (v) => new Vector3(...v);
const byId = (id) => document.getElementById(id);
const kSurface = 127.5;

function geometryOf({ positions, normals, indices }) {
  const geometry = new BufferGeometry(), count = positions.length / 3;
  // Not reamed, of middling density, and open to light from all sides.
  const attributes = new Uint8Array(3 * count);
  for (let i = 0; i < count; ++i) {
    attributes[3 * i + 1] = 110;
    attributes[3 * i + 2] = 240;
  }
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new BufferAttribute(normals, 3));
  geometry.setAttribute("vertex_attributes", new BufferAttribute(attributes, 3, true));
  geometry.setAttribute("depth", new BufferAttribute(new Uint16Array(count), 1, true));
  geometry.setIndex(new BufferAttribute(indices, 1));
  return geometry;
}

export class Solid {
  constructor(model) {
    this.model = model;
    this.canvas = byId("bone-canvas");
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new Scene();
    this.camera = new OrthographicCamera();
    this.superior = this.upwards();
    this.camera.up = vector(this.superior);
    this.addLights();
    this.addBone();
    this.addReamer();
    this.marks = new Group();
    this.scene.add(this.marks);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableZoom = false;  // without focus the wheel scrolls the page
    this.controls.addEventListener("change", () => this.draw());
    this.measure();
    this.addViews();
    this.listen();
    this.look(this.views[0][1]);
    this.rebuild();
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(this.canvas);
  }

  upwards() {
    const { data, glenoid } = this.model;
    return data.anatomical || glenoid === null ? [0, 0, 1] : glenoid.axes[1];
  }

  addLights() {
    this.scene.add(new AmbientLight(0xffffff, 1.3));
    const light = new DirectionalLight(0xffffff, 1.9);
    light.position.set(-0.5, 0.65, 0.57);
    this.camera.add(light);
    this.scene.add(this.camera);
  }

  addBone() {
    this.material = new ShaderMaterial({
      glslVersion: GLSL3, vertexShader: boneVertex, fragmentShader: boneFragment, side: DoubleSide, defines: { DEPTH_STOPS: 2 },
      uniforms: {
        cut: { value: new Vector4(0, 0, 0, 1) }, depth_stops: { value: [new Vector3(), new Vector3()] },
        depth_max_mm: { value: 1 }, contour_mm: { value: 1 }, shows_depth: { value: 0 },
      },
    });
    this.bone = new Mesh(new BufferGeometry(), this.material);
    this.bone.frustumCulled = false;
    this.scene.add(this.bone);
  }

  addReamer() {
    const { reamer } = this.model;
    if (reamer === null) return;
    const profile = reamer.points.map(([r, z]) => new Vector2(r, z));
    const geometry = new LatheGeometry([...profile, profile[0]], 64);
    geometry.rotateX(Math.PI / 2);  // from an axis along y to one along z
    const material = new MeshLambertMaterial({ color: colors.reamer, transparent: true, opacity: 0.55, side: DoubleSide, depthWrite: false });
    this.tool = new Mesh(geometry, material);
    this.tool.matrixAutoUpdate = false;
    this.tool.renderOrder = 2;
    this.scene.add(this.tool);
  }

  // The bone's bounding box, or without bone that of the volume.
  measure() {
    const { lattice } = this.model.volume, points = this.model.surface?.positions ?? [];
    let low = [0, 1, 2].map((axis) => lattice.low(axis)), high = [0, 1, 2].map((axis) => lattice.high(axis));
    if (points.length > 0) {
      [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
      for (let i = 0; i < points.length; ++i) {
        low[i % 3] = Math.min(low[i % 3], points[i]);
        high[i % 3] = Math.max(high[i % 3], points[i]);
      }
    }
    this.focus = new Vector3(...low.map((l, axis) => 0.5 * (l + high[axis])));
    this.radius = 0.5 * Math.hypot(...low.map((l, axis) => high[axis] - l));
  }

  addViews() {
    const { data, glenoid } = this.model, left = data.side !== "right";
    const lateral = [left ? 1 : -1, 0, 0];
    const oblique = data.anatomical ? [0.75 * lateral[0], -0.6, 0.25] : glenoid === null ? [0.6, -0.7, 0.4] : glenoid.axes[2].map((n, i) => n + 0.45 * glenoid.axes[0][i] + 0.2 * glenoid.axes[1][i]);
    this.views = [["Oblique", oblique]];
    this.views.push(...(data.anatomical
      ? [["Lateral", lateral], ["Anterior", [0, -1, 0]], ["Posterior", [0, 1, 0]], ["Superior", [0, 0, 1]]]
      : [["+x", [1, 0, 0]], ["−x", [-1, 0, 0]], ["+y", [0, 1, 0]], ["−y", [0, -1, 0]], ["+z", [0, 0, 1]], ["−z", [0, 0, -1]]]));
    const add = (name, action) => {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
      button.addEventListener("click", action);
      byId("bone-views").append(button);
      return button;
    };
    for (const [name, direction] of this.views) add(name, () => this.look(direction));
    this.enFace = add("En face", () => this.look(this.model.glenoid.axes[2], this.model.glenoid.center, this.radius / 35));
  }

  look(direction, focus = null, zoom = 1) {
    const towards = vector(direction).normalize(), up = this.camera.up;
    // A direction along "up" leaves the turn of the camera undefined.
    if (Math.abs(towards.dot(up)) > 0.999) towards.addScaledVector(Math.abs(up.y) < 0.9 ? new Vector3(0, -1, 0) : new Vector3(1, 0, 0), 0.002).normalize();
    const target = focus === null ? this.focus : vector(focus);
    this.camera.zoom = Math.max(1, zoom);
    this.camera.position.copy(target).addScaledVector(towards, 3 * this.radius + 50);
    this.controls.target.copy(target);
    this.resize();
    this.controls.update();
    this.draw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    const half = 1.02 * this.radius * Math.max(1, height / width);
    Object.assign(this.camera, { left: (-half * width) / height, right: (half * width) / height, top: half, bottom: -half, near: 0.1, far: 8 * this.radius + 200 });
    this.camera.updateProjectionMatrix();
  }

  listen() {
    this.canvas.addEventListener("focus", () => { this.controls.enableZoom = true; });
    this.canvas.addEventListener("blur", () => { this.controls.enableZoom = false; });
    let pressed = null;
    this.canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY, event.button]; });
    this.canvas.addEventListener("pointerup", (event) => {
      if (pressed === null || pressed[2] !== 0 || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 3) return;
      const box = this.canvas.getBoundingClientRect();
      this.place(event.clientX - box.left, event.clientY - box.top);
    });
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    this.canvas.addEventListener("keydown", (event) => {
      const zoom = { "+": 1.15, "=": 1.15, "-": 1 / 1.15 }[event.key];
      if (zoom !== undefined) this.zoomBy(zoom);
      else if (event.key in turns) this.turn(...turns[event.key]);
      else if (event.key === "Enter") this.place(0.5 * this.canvas.clientWidth, 0.5 * this.canvas.clientHeight);
      else return;
      event.preventDefault();
    });
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

  place(x, y) {
    const point = this.pick(x, y);
    if (point === null) return;
    this.model.moveCross(point);
    this.model.place(this.model.tool, this.model.cross);
  }

  // Where the line of sight through a pixel first meets the bone: the field itself, not its triangles. Null where it does not.
  pick(x, y) {
    const { bone } = this.model;
    if (bone === null) return null;
    this.camera.updateMatrixWorld();
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const start = new Vector3((2 * x) / width - 1, 1 - (2 * y) / height, -1).unproject(this.camera);
    const way = new Vector3(0, 0, -1).transformDirection(this.camera.matrixWorld);
    const at = (t) => bone.at([start.x + t * way.x, start.y + t * way.y, start.z + t * way.z]);
    const step = 0.3 * Math.min(...bone.lattice.spacing);
    let before = 0;
    for (let t = 0; t < this.camera.far; t += step) {
      if (at(t) < kSurface) { before = t; continue; }
      let [low, high] = [before, t];
      for (let round = 0; round < 20; ++round) {
        const middle = 0.5 * (low + high);
        if (at(middle) < kSurface) low = middle;
        else high = middle;
      }
      return [start.x + high * way.x, start.y + high * way.y, start.z + high * way.z];
    }
    return null;
  }

  // After changes of the values.
  rebuild() {
    const { model } = this;
    if (model.surface !== this.drawn) {
      this.bone.geometry.dispose();
      if (model.surface !== null) this.bone.geometry = geometryOf(model.surface);
      this.bone.visible = model.surface !== null;
      this.drawn = model.surface;
    }
    this.enFace.disabled = model.glenoid === null;
    this.moveReamer();
    this.remark();
    this.draw();
  }

  moveReamer() {
    const { posed, showsReamer } = this.model;
    if (this.tool === undefined) return;
    this.tool.visible = posed !== null && showsReamer;
    if (posed === null) return;
    this.tool.matrix.copy(new Matrix4().makeBasis(...posed.axes.map(vector)).setPosition(vector(posed.origin)));
    this.tool.matrixWorldNeedsUpdate = true;
  }

  remark() {
    for (const mark of this.marks.children) mark.geometry?.dispose();
    this.marks.clear();
    const ball = (place, radius, color, more) => {
      const mesh = new Mesh(new SphereGeometry(radius, 24, 16), new MeshBasicMaterial({ color, side: FrontSide, ...more }));
      mesh.position.copy(vector(place));
      mesh.renderOrder = 3;
      this.marks.add(mesh);
    };
    const size = Math.max(0.7, 0.016 * this.radius);
    for (const { place, color } of marksOf(this.model)) {
      ball(place, size, color, {});
      ball(place, size, color, { transparent: true, opacity: 0.3, depthTest: false });  // behind bone
    }
    ball(this.model.cross, 0.6 * size, 0x1b1f24, { transparent: true, opacity: 0.8, depthTest: false });
    for (const { center_mm, radius_mm } of this.model.values.cut_spheres) {
      ball(center_mm, radius_mm, colors.sphere, { transparent: true, opacity: 0.3, depthWrite: false });
    }
    const { glenoid } = this.model;
    if (glenoid === null) return;
    for (const [axis, length, color] of [[2, 18, colors.center], [1, 15, colors.superior]]) {
      this.marks.add(new ArrowHelper(vector(glenoid.axes[axis]), vector(glenoid.center), length, color, 4, 2.4));
    }
  }

  // The directions of the triad, as drawAxes() wants them.
  directions() {
    const { data, glenoid } = this.model;
    if (!data.anatomical) return { anatomical: true, superior: glenoid?.axes[1] ?? null, outward: null, anterior: null };
    return { anatomical: true, superior: [0, 0, 1], outward: data.side === null ? null : [data.side === "left" ? 1 : -1, 0, 0], anterior: [0, -1, 0] };
  }

  mmPerPixel() { return (this.camera.top - this.camera.bottom) / this.camera.zoom / this.canvas.clientHeight; }

  draw() {
    this.camera.updateMatrixWorld();
    this.renderer.render(this.scene, this.camera);
    drawAxes(byId("bone-axes"), this.directions(), this.camera);
    drawScale(byId("bone-scale"), this.mmPerPixel());
  }
}
