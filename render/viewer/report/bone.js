// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The bone before, during and after reaming and the reamer, with an optional section.
import {
  BackSide, BufferAttribute, BufferGeometry, Data3DTexture, DecrementWrapStencilOp, FrontSide, Group, IncrementWrapStencilOp,
  LinearFilter, Mesh, PlaneGeometry, Quaternion, RedFormat, Vector3, Vector4, View, boneMaterial, capMaterial, choices, find,
  legend, toolLook, unpacked, vector, viewMissing,
} from "../shared/scene.js";

// --- decodes what render/viewer/scene_data.cpp encodes

// The `plane`th plane of 16-bit numbers, delta and zigzag encoded.
function numbers16(bytes, plane, count) {
  const out = new Uint16Array(count);
  let value = 0;
  for (let i = 0; i < count; ++i) {
    const code = bytes[2 * plane * count + i] | (bytes[(2 * plane + 1) * count + i] << 8);
    value += (code >> 1) ^ -(code & 1);
    out[i] = value;
  }
  return out;
}

// Poses of the tool: position in mm, quaternion and spin angle in radians, one each for every row of the curves.
function posesOf(packed) {
  const bytes = unpacked(packed.bytes);
  const [low, high] = packed.box_mm;
  const column = (plane, from, size) => Float64Array.from(numbers16(bytes, plane, packed.count), (n) => from + (size * n) / 65535);
  const places = [0, 1, 2].map((axis) => column(axis, low[axis], high[axis] - low[axis]));
  const turns = [3, 4, 5, 6].map((plane) => column(plane, -1, 2));
  const spins = column(7, 0, 2 * Math.PI);
  return Array.from(spins, (spin, row) => ({ position: places.map((c) => c[row]), quaternion: turns.map((c) => c[row]), spin }));
}

// Three planes of numbers from the `first` on, interleaved.
function interleaved(bytes, first, count, Type, valueOf) {
  const out = new Type(3 * count);
  for (let part = 0; part < 3; ++part) {
    numbers16(bytes, first + part, count).forEach((n, i) => { out[3 * i + part] = valueOf(n, part); });
  }
  return out;
}

function corners(bytes, from, count) {
  const out = new Uint32Array(count);
  let at = from, next = 0;
  for (let i = 0; i < count; ++i) {
    let below = 0;
    for (let shift = 0; ; shift += 7) {
      const byte = bytes[at++];
      below |= (byte & 127) << shift;
      if (byte < 128) break;
    }
    out[i] = next - below;
    if (below === 0) ++next;
  }
  return out;
}

// A mesh: positions in mm, normals, attributes (reamed, density, ambient accessibility), depths, triangle indices.
function geometryOf(packed, [low, high]) {
  const bytes = unpacked(packed.bytes), count = packed.vertices;
  const placeOf = (n, axis) => low[axis] + ((high[axis] - low[axis]) / 65535) * n;
  return new BufferGeometry()
    .setAttribute("position", new BufferAttribute(interleaved(bytes, 0, count, Float32Array, placeOf), 3))
    .setAttribute("normal", new BufferAttribute(interleaved(bytes, 4, count, Int8Array, (n) => n - 127), 3, true))
    .setAttribute("vertex_attributes", new BufferAttribute(interleaved(bytes, 7, count, Uint8Array, (n) => n), 3, true))
    .setAttribute("depth", new BufferAttribute(numbers16(bytes, 3, count), 1, true))
    .setIndex(new BufferAttribute(corners(bytes, 20 * count, 3 * packed.triangles), 1));
}

// The bone during the run: the reamed vertices of the bone after it, lifted by the bone that was still there.
const blend_mm = 0.3;  // lifts over which the normals change from those after the run to recomputed ones

class Reaming {
  // `geometry` of the bone after the run.
  constructor(geometry, reaming, axis) {
    this.times = reaming.time_s;
    // The bone over each reamed vertex in mm, one list for each time.
    const bytes = unpacked(reaming.bytes), step = reaming.most_mm / 65535;
    this.states = this.times.map((_, state) =>
      Float32Array.from(numbers16(bytes, state, reaming.vertices), (n) => step * n));
    this.axis = axis;
    this.places = geometry.getAttribute("position").array;
    this.normals = geometry.getAttribute("normal");
    this.finalNormals = this.normals.array.slice();
    const attributes = geometry.getAttribute("vertex_attributes").array;
    const reamed = (vertex) => attributes[3 * vertex] > 0;
    this.moved = new Uint32Array(this.places.length / 3).map((_, i) => i).filter(reamed);
    this.lifts = new BufferAttribute(new Float32Array((2 * this.places.length) / 3), 2);  // mm, and as a fraction of the greatest
    geometry.setAttribute("lift", this.lifts);
    // The triangles at the reamed vertices, where these are during the run.
    const indices = geometry.getIndex().array, touching = indices.filter((_, i) => [0, 1, 2].some((k) => reamed(indices[i - (i % 3) + k])));
    this.lifted = new BufferGeometry().setAttribute("position", new BufferAttribute(this.places.slice(), 3));
    this.lifted.setIndex(new BufferAttribute(touching, 1));
  }

  // At a time of the run, linear between the pictures; undefined: after the run.
  moveTo(time) {
    if (time === this.time) return;
    this.time = time;
    const [before, after, part] = this.neighbours(time);
    const first = this.states[0];
    this.moved.forEach((vertex, slot) => {
      const lift = before === undefined ? 0 : (1 - part) * before[slot] + part * after[slot];
      this.lifts.array[2 * vertex] = lift;
      this.lifts.array[2 * vertex + 1] = first[slot] > 0 ? Math.min(1, lift / first[slot]) : 0;
    });
    this.lifts.needsUpdate = true;
    this.shade();
  }

  neighbours(time) {
    const { times, states } = this;
    if (time === undefined) return [undefined, undefined, 0];
    const next = times.findIndex((t) => t > time), after = next < 0 ? times.length - 1 : next, before = next > 0 ? next - 1 : after;
    return [states[before], states[after], before === after ? 0 : (time - times[before]) / (times[after] - times[before])];
  }

  // Normals of the lifted vertices: the mean of their triangles by area.
  shade() {
    const lifted = this.lifted.getAttribute("position").array;
    for (const vertex of this.moved) {
      for (let k = 0; k < 3; ++k) lifted[3 * vertex + k] = this.places[3 * vertex + k] + this.lifts.array[2 * vertex] * this.axis[k];
    }
    this.lifted.computeVertexNormals();
    const normals = this.lifted.getAttribute("normal").array;
    for (const vertex of this.moved) {
      const weight = Math.min(1, this.lifts.array[2 * vertex] / blend_mm);
      for (let at = 3 * vertex; at < 3 * vertex + 3; ++at) {
        this.normals.array[at] = Math.round(weight * 127 * normals[at] + (1 - weight) * this.finalNormals[at]);
      }
    }
    this.normals.needsUpdate = true;
  }
}

// The reamer: see-through as in the pictures, or of steel.
const spinAxis = new Vector3(0, 0, -1);  // of a positive spin, in the tool frame

class ToolModel {
  constructor(tool, cut) {
    this.poses = posesOf(tool.poses);
    const { uniforms, modelOf } = toolLook(new Vector3(0.42, 0.45, 0.49), cut);
    this.uniforms = uniforms;
    this.passes = tool.passes.map((pass) => ({ row: pass.row, model: modelOf(geometryOf(pass.mesh, pass.box_mm)) }));
    this.group = new Group().add(...this.passes.map((pass) => pass.model));
    this.moveTo(0);
  }

  // To the pose of a row.
  moveTo(row) {
    const { position, quaternion, spin } = this.poses[row];
    const present = this.passes.findLast((pass) => pass.row <= row);
    for (const pass of this.passes) pass.model.visible = pass === present;
    this.group.position.set(...position);
    this.group.quaternion.set(...quaternion).normalize();
    this.group.quaternion.multiply(new Quaternion().setFromAxisAngle(spinAxis, spin));
  }

  // "see-through", "steel" or "hidden".
  set look(look) {
    this.group.visible = look !== "hidden";
    this.uniforms.opaque.value = look === "steel" ? 1 : 0;
  }
}

// The section planes: `normal` points towards the viewer of the cut.
function planesOf(look) {
  const axis = vector(look.axis), front = vector(look.front);
  const side = new Vector3().crossVectors(axis, front).normalize();
  const upwards = side.dot(vector(look.superior)) < 0 ? side.clone().negate() : side;
  const known = look.anatomical && look.anterior !== null;
  return [
    { name: known ? "seen from anterior" : "seen from the front", normal: front },
    { name: known ? "seen from superior" : "seen from above", normal: upwards },
    { name: "perpendicular to the tool axis", normal: axis },
  ];
}

function viewsOf(look) {
  const views = [["Oblique", vector(look.towards_viewer)], [look.anatomical ? "En face" : "Along the axis", vector(look.outward)]];
  // Turned slightly towards lateral so that the reamed face is visible behind the cut edge.
  const front = vector(look.front).multiplyScalar(0.96).addScaledVector(vector(look.outward), 0.28).normalize();
  views.push([look.anterior ? "Anterior" : "Front", front], [look.anatomical ? "Superior" : "Above", vector(look.superior)]);
  return views;
}

class BoneView extends View {
  constructor(bone, tool) {
    const { look } = bone;
    super(find("bone-canvas"), {
      focus: vector(look.focus_mm), reach: look.reach_mm, half: 0.5 * look.height_mm, up: look.superior, aside: vector(look.outward),
      directions: () => look,
    }, { stencil: true });
    this.bone = bone;
    this.cut = new Vector4(0, 0, 0, 1);
    this.addBone();
    this.addCap();
    this.addTool(tool);
    this.planes = planesOf(look);
    for (const [name, direction] of viewsOf(look)) this.addButton(name, () => this.look(direction));
    this.addStates();
    this.addCuts();
    this.look(vector(look.towards_viewer));
  }

  addBone() {
    const { bone } = this, depth = bone.depth_colors;
    this.uniforms = {
      cut: { value: this.cut },
      stops: { value: depth.stops.map(vector) },
      depth_max_mm: { value: depth.max },
      contour_mm: { value: depth.step },
      shows_depth: { value: 1 },
      lift_axis: { value: vector(bone.look.axis) },
    };
    // Behind the cut, more back faces than front faces on a ray mean that the cut plane lies in bone there.
    const counting = (side, operation) => boneMaterial(this.uniforms, {
      side, depthWrite: false, depthTest: false, colorWrite: false, stencilWrite: true, stencilZPass: operation,
    });
    const materials = [counting(BackSide, IncrementWrapStencilOp), counting(FrontSide, DecrementWrapStencilOp), boneMaterial(this.uniforms)];
    this.states = {};
    for (const state of ["before", "after"]) {
      const geometry = geometryOf(bone[state], bone.box_mm);
      if (state === "after" && bone.reaming !== null) this.reaming = new Reaming(geometry, bone.reaming, bone.look.axis);
      this.states[state] = materials.map((made, i) => {
        const mesh = Object.assign(new Mesh(geometry, made), { renderOrder: i < 2 ? 1 : 3, frustumCulled: false });
        this.scene.add(mesh);
        return mesh;
      });
    }
  }

  addCap() {
    const { bone } = this, { bytes, dims, cell_mm, origin_mm } = bone.density, colors = bone.density_colors;
    const texture = new Data3DTexture(unpacked(bytes), ...dims);
    Object.assign(texture, { format: RedFormat, minFilter: LinearFilter, magFilter: LinearFilter, needsUpdate: true });
    this.cap = new Mesh(new PlaneGeometry(4 * this.reach, 4 * this.reach), capMaterial({
      density: { value: texture },
      origin_mm: { value: vector(origin_mm) },
      size_mm: { value: vector(dims).multiplyScalar(cell_mm) },
      stops: { value: colors.stops.map(vector) },
      top_grade: { value: bone.grade_per_g_cm3 * colors.max },
    }));
    this.cap.renderOrder = 2;
    this.cap.visible = false;
    this.scene.add(this.cap);
  }

  addTool(tool) {
    find("tool-looks").hidden = tool === null;
    if (tool === null) return;
    this.tool = new ToolModel(tool, this.cut);
    this.tool.look = tool.shown ? tool.look : "hidden";
    this.scene.add(this.tool.group);
    const looks = [["see-through", "See-through"], ["steel", "Steel"], ["hidden", "Hidden"]];
    choices("tool-looks", "tool", looks, (look) => { this.tool.look = look; this.draw(); })(tool.shown ? tool.look : "hidden");
  }

  // "before" or "after" the run, or "now": at the time of moveTo().
  show(state) {
    this.state = state;
    this.update();
  }

  // Tool and bone at a row of the log. `touched`: bone was removed before.
  moveTo(row, time, touched) {
    [this.time, this.touched] = [time, touched];
    this.tool?.moveTo(row);
    this.update();
    this.draw();
  }

  update() {
    const shown = this.state !== "now" ? this.state : this.touched ? "after" : "before";
    for (const [name, [back, front, bone]] of Object.entries(this.states)) {
      bone.visible = name === shown;
      back.visible = front.visible = bone.visible && this.cap.visible;
    }
    if (this.state !== "before") this.reaming?.moveTo(this.state === "now" ? this.time : undefined);
    if (this.tool) this.tool.uniforms.has_cut.value = this.cap.visible ? 1 : 0;
  }

  draw() {
    super.draw();
    if (this.tool) this.canvas.dataset.toolMm = this.tool.group.position.toArray().map((v) => v.toFixed(3)).join(" ");
  }

  // --- its controls

  addStates() {
    const { reaming } = this.bone;
    const redraw = () => { this.showLegends(); this.draw(); };
    const states = [["before", "Before"], ...(reaming === null ? [] : [["now", "During"]]), ["after", "After"]];
    const state = reaming === null ? "after" : "now";
    choices("bone-states", "state", states, (chosen) => { this.show(chosen); redraw(); })(state);
    choices("surfaces", "surface", [["depth", "Depth"], ["plain", "Bone"]], (surface) => {
      this.uniforms.shows_depth.value = surface === "depth" ? 1 : 0;
      redraw();
    })("depth");
    this.show(state);
  }

  addCuts() {
    const select = find("cut-plane");
    select.append(new Option("off", ""));
    this.planes.forEach((plane, i) => select.append(new Option(plane.name, i)));
    select.addEventListener("change", () => { this.choosePlane(); this.faceCut(); });
    find("cut-offset").addEventListener("input", () => this.moveCut());
    find("cut-flip").addEventListener("change", () => { this.moveCut(); this.faceCut(); });
    this.choosePlane();
  }

  // Out of the bone that a section keeps; null without a section.
  cutNormal() {
    const plane = this.planes[find("cut-plane").value];
    if (plane === undefined) return null;
    return find("cut-flip").checked ? plane.normal.clone().negate() : plane.normal;
  }

  // A section is seen from the side that its name says.
  faceCut() {
    const normal = this.cutNormal();
    if (normal !== null) this.look(normal);
  }

  // The extent of the bone along the normal limits the slider.
  choosePlane() {
    const plane = this.planes[find("cut-plane").value];
    const slider = find("cut-offset");
    find("cut-settings").hidden = plane === undefined;
    if (plane !== undefined) {
      const { box_mm, look: { axis_point_mm } } = this.bone;
      const reach = (farther) => plane.normal.toArray().reduce((sum, n, axis) =>
        sum + farther(...box_mm.map((corner) => n * (corner[axis] - axis_point_mm[axis]))), 0);
      const most = Math.min(30, reach(Math.max)), least = Math.max(-30, reach(Math.min));
      Object.assign(slider, { min: least.toFixed(1), max: most.toFixed(1), value: 0 });
    }
    this.moveCut();
    this.showLegends();
  }

  // Cuts away what lies in front of the section.
  moveCut() {
    const plane = this.planes[find("cut-plane").value], normal = this.cutNormal();
    const offset = Number(find("cut-offset").value);
    find("cut-value").textContent = `${offset.toFixed(1).replace("-", "−")} mm`;
    find("cut-offset").setAttribute("aria-valuetext", `${offset.toFixed(1)} mm from the tool axis`);
    this.cap.visible = normal !== null;
    if (normal === null) {
      this.cut.set(0, 0, 0, 1);
    } else {
      const point = vector(this.bone.look.axis_point_mm).addScaledVector(plane.normal, offset);
      this.cut.set(-normal.x, -normal.y, -normal.z, normal.dot(point));
      this.cap.position.copy(point);
      this.cap.lookAt(point.clone().add(normal));
    }
    this.update();
    this.draw();
  }

  showLegends() {
    const legends = [];
    if (this.state !== "before" && this.uniforms.shows_depth.value === 1) legends.push(legend("Reamed depth, mm", this.bone.depth_colors));
    if (find("cut-plane").value !== "") legends.push(legend("Bone density, g/cm³", this.bone.density_colors));
    find("bone-legends").replaceChildren(...legends);
  }
}

// Without WebGL the first picture remains.
export function showBone(bone, tool) {
  find("bone-interactive").hidden = false;
  try {
    const view = new BoneView(bone, tool);
    find("bone-still")?.classList.add("print-only");
    return view;
  } catch (error) {
    find("bone-interactive").replaceChildren(viewMissing(error, "The pictures show the bone."));
    return undefined;
  }
}
