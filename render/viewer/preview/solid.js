// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The 3D view: bone, reamer, points, cut spheres, glenoid frame. Draws on request only.
import {
  ArrowHelper, Box3, BufferGeometry, Color, FrontSide, Group, LatheGeometry, Matrix4, Mesh, MeshBasicMaterial, SphereGeometry,
  Vector2, Vector3, Vector4, View, boneMaterial, find, toolLook, vector,
} from "../shared/scene.js";
import { colors, marksOf } from "./model.js";

const kSurface = 127.5;

// The bounding box of the bone, or without bone that of the volume.
function extentOf({ volume: { lattice }, surface }) {
  const corner = (end) => new Vector3(...[0, 1, 2].map((axis) => lattice[end](axis)));
  const box = surface === null || surface.boundingBox.isEmpty() ? new Box3(corner("low"), corner("high")) : surface.boundingBox;
  return { focus: box.getCenter(new Vector3()), reach: 0.5 * box.getSize(new Vector3()).length() };
}

export class Solid extends View {
  constructor(model) {
    const { data, glenoid } = model, { focus, reach } = extentOf(model);
    const up = data.anatomical || glenoid === null ? [0, 0, 1] : glenoid.axes[1];
    super(find("bone-canvas"), {
      focus, reach, half: 1.02 * reach, up, aside: vector(Math.abs(up[1]) < 0.9 ? [0, -1, 0] : [1, 0, 0]), directions: () => this.axes(),
    });
    this.model = model;
    this.addBone();
    this.addReamer();
    this.marks = new Group();
    this.scene.add(this.marks);
    this.addViews();
    this.listen();
    this.look(vector(this.views[0][1]));
    this.show();
  }

  addBone() {
    const uniforms = {
      cut: { value: new Vector4(0, 0, 0, 1) }, stops: { value: [new Vector3(), new Vector3()] }, depth_max_mm: { value: 1 }, contour_mm: { value: 1 },
      shows_depth: { value: 0 }, lift_axis: { value: new Vector3() },
    };
    this.bone = new Mesh(new BufferGeometry(), boneMaterial(uniforms));
    // Not reamed, of middling density, and open to light from all sides.
    this.bone.material.defaultAttributeValues = { vertex_attributes: [0, 110 / 255, 240 / 255], depth: [0], lift: [0, 0] };
    this.bone.frustumCulled = false;
    this.scene.add(this.bone);
  }

  addReamer() {
    const { reamer } = this.model;
    if (reamer === null) return;
    const profile = reamer.points.map(([r, z]) => new Vector2(r, z));
    const geometry = new LatheGeometry([...profile, profile[0]], 64);
    geometry.rotateX(Math.PI / 2);  // from an axis along y to one along z
    const { uniforms, modelOf } = toolLook(new Color(colors.reamer), new Vector4(0, 0, 0, 1));
    uniforms.opaque.value = 0.4;
    this.tool = modelOf(geometry);
    this.tool.matrixAutoUpdate = false;
    this.scene.add(this.tool);
  }

  addViews() {
    const { data, glenoid } = this.model, left = data.side !== "right";
    const lateral = [left ? 1 : -1, 0, 0];
    const oblique = data.anatomical ? [0.75 * lateral[0], -0.6, 0.25] : glenoid === null ? [0.6, -0.7, 0.4] : glenoid.axes[2].map((n, i) => n + 0.45 * glenoid.axes[0][i] + 0.2 * glenoid.axes[1][i]);
    this.views = [["Oblique", oblique]];
    this.views.push(...(data.anatomical
      ? [["Lateral", lateral], ["Anterior", [0, -1, 0]], ["Posterior", [0, 1, 0]], ["Superior", [0, 0, 1]]]
      : [["+x", [1, 0, 0]], ["−x", [-1, 0, 0]], ["+y", [0, 1, 0]], ["−y", [0, -1, 0]], ["+z", [0, 0, 1]], ["−z", [0, 0, -1]]]));
    for (const [name, direction] of this.views) this.addButton(name, () => this.look(vector(direction)));
    this.enFace = this.addButton("En face", () => {
      const { axes, center } = this.model.glenoid;
      this.look(vector(axes[2]), vector(center), Math.max(1, this.reach / 35));
    });
  }

  listen() {
    let pressed = null;
    this.canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY, event.button]; });
    this.canvas.addEventListener("pointerup", (event) => {
      if (pressed === null || pressed[2] !== 0 || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 3) return;
      const box = this.canvas.getBoundingClientRect();
      this.place(event.clientX - box.left, event.clientY - box.top);
    });
  }

  key(event) {
    super.key(event);
    if (event.key !== "Enter") return;
    this.place(0.5 * this.canvas.clientWidth, 0.5 * this.canvas.clientHeight);
    event.preventDefault();
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

  show() {
    const { model } = this;
    if (model.surface !== this.drawn) {
      this.bone.geometry.dispose();
      if (model.surface !== null) this.bone.geometry = model.surface;
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
    const size = Math.max(0.7, 0.016 * this.reach);
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
  axes() {
    const { data, glenoid } = this.model;
    if (!data.anatomical) return { anatomical: true, superior: glenoid?.axes[1] ?? null, outward: null, anterior: null };
    return { anatomical: true, superior: [0, 0, 1], outward: data.side === null ? null : [data.side === "left" ? 1 : -1, 0, 0], anterior: [0, -1, 0] };
  }
}
