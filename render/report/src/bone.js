// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The 3D view's controls.
import { Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { BoneScene } from "./scene.js";
import { drawAxes, drawScale, legend } from "./marks.js";

const vector = (v) => new Vector3(...v);
const byId = (id) => document.getElementById(id);

// The section planes: `normal` points towards the viewer of the cut.
function planesOf(look) {
  const axis = vector(look.axis);
  const front = vector(look.front);
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

class BoneView {
  constructor(bone, tool) {
    this.bone = bone;
    this.canvas = byId("bone-canvas");
    this.scene = new BoneScene(this.canvas, bone, tool);
    this.controls = new OrbitControls(this.scene.camera, this.canvas);
    this.controls.target.copy(this.scene.focus);
    this.controls.enableZoom = false;  // without focus the wheel scrolls the page
    this.controls.addEventListener("change", () => this.draw());
    this.planes = planesOf(bone.look);
    this.addViews();
    this.addStates();
    this.addToolLooks(tool);
    this.addCuts();
    this.addKeys();
    this.showLegends();
    this.lookFrom(vector(bone.look.towards_viewer));  // OrbitControls has set the target to the origin
    new ResizeObserver(() => { this.scene.resize(); this.draw(); }).observe(this.canvas);
  }

  // The bone at most once per picture of the screen, because it takes long without a GPU.
  draw() {
    this.drawing ??= requestAnimationFrame(() => {
      this.drawing = undefined;
      this.scene.draw();
    });
    this.scene.camera.updateMatrixWorld();
    // For tests: what the picture alone does not tell.
    const away = this.scene.camera.position.clone().sub(this.controls.target).normalize();
    this.canvas.dataset.towardsViewer = away.toArray().map((v) => v.toFixed(4)).join(" ");
    if (this.scene.tool) this.canvas.dataset.toolMm = this.scene.tool.group.position.toArray().map((v) => v.toFixed(3)).join(" ");
    drawAxes(byId("bone-axes"), this.bone.look, this.scene.camera);
    drawScale(byId("bone-scale"), this.scene.mmPerPixel());
  }

  lookFrom(direction) {
    // A view direction parallel to "up" leaves the rotation of the camera undefined.
    const up = this.scene.camera.up;
    const tilted = Math.abs(direction.dot(up)) > 0.999 ? direction.clone().addScaledVector(vector(this.bone.look.outward), 0.002) : direction;
    this.scene.look(tilted.clone().normalize());
    this.controls.target.copy(this.scene.focus);
    this.controls.update();
    this.draw();
  }

  addViews() {
    for (const [name, direction] of viewsOf(this.bone.look)) {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
      button.addEventListener("click", () => this.lookFrom(direction));
      byId("bone-views").append(button);
    }
  }

  addStates() {
    const now = document.querySelector("input[name=state][value=now]");
    now.closest("label").hidden = this.bone.reaming === null;
    now.checked = this.bone.reaming !== null;
    if (now.checked) this.scene.show("now");
    for (const input of document.querySelectorAll("input[name=state]")) {
      input.addEventListener("change", () => { this.scene.show(input.value); this.showLegends(); this.draw(); });
    }
    for (const input of document.querySelectorAll("input[name=surface]")) {
      input.addEventListener("change", () => {
        this.scene.uniforms.shows_depth.value = input.value === "depth" ? 1 : 0;
        this.showLegends();
        this.draw();
      });
    }
  }

  addToolLooks(tool) {
    byId("tool-looks").hidden = tool === null;
    if (tool === null) return;
    for (const input of document.querySelectorAll("input[name=tool]")) {
      input.checked = input.value === (tool.shown ? tool.look : "hidden");
      input.addEventListener("change", () => { this.scene.tool.look = input.value; this.draw(); });
    }
  }

  moveTo(row, time, touched) {
    this.scene.moveTo(row, time, touched);
    this.draw();
  }

  addCuts() {
    const select = byId("cut-plane");
    select.append(new Option("off", ""));
    this.planes.forEach((plane, i) => select.append(new Option(plane.name, i)));
    select.addEventListener("change", () => { this.choosePlane(); this.faceCut(); });
    byId("cut-offset").addEventListener("input", () => this.moveCut());
    byId("cut-flip").addEventListener("change", () => { this.moveCut(); this.faceCut(); });
    this.choosePlane();
  }

  // Out of the bone that a section keeps; null without a section.
  cutNormal() {
    const plane = this.planes[byId("cut-plane").value];
    if (plane === undefined) return null;
    return byId("cut-flip").checked ? plane.normal.clone().negate() : plane.normal;
  }

  // A section is seen from the side that its name says.
  faceCut() {
    const normal = this.cutNormal();
    if (normal !== null) this.lookFrom(normal);
  }

  // The extent of the bone along the normal limits the slider.
  choosePlane() {
    const plane = this.planes[byId("cut-plane").value];
    const slider = byId("cut-offset");
    byId("cut-settings").hidden = plane === undefined;
    if (plane !== undefined) {
      const [low, high] = this.bone.box_mm;
      const reaches = [];
      for (let i = 0; i < 8; ++i) {
        const corner = new Vector3(i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]);
        reaches.push(corner.sub(vector(this.bone.look.axis_point_mm)).dot(plane.normal));
      }
      const most = Math.min(30, Math.max(...reaches)), least = Math.max(-30, Math.min(...reaches));
      Object.assign(slider, { min: least.toFixed(1), max: most.toFixed(1), value: 0 });
    }
    this.moveCut();
    this.showLegends();
  }

  moveCut() {
    const plane = this.planes[byId("cut-plane").value];
    const offset = Number(byId("cut-offset").value);
    byId("cut-value").textContent = `${offset.toFixed(1).replace("-", "−")} mm`;
    byId("cut-offset").setAttribute("aria-valuetext", `${offset.toFixed(1)} mm from the tool axis`);
    if (plane === undefined) {
      this.scene.cutAlong(null);
    } else {
      const point = vector(this.bone.look.axis_point_mm).addScaledVector(plane.normal, offset);
      this.scene.cutAlong(this.cutNormal(), point);
    }
    this.draw();
  }

  addKeys() {
    this.canvas.addEventListener("focus", () => { this.controls.enableZoom = true; });
    this.canvas.addEventListener("blur", () => { this.controls.enableZoom = false; });
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    this.canvas.addEventListener("keydown", (event) => {
      const zoom = { "+": 1.15, "=": 1.15, "-": 1 / 1.15 }[event.key];
      if (zoom !== undefined) this.zoomBy(zoom);
      else if (event.key in turns && event.shiftKey) this.pan(...turns[event.key]);
      else if (event.key in turns) this.turn(...turns[event.key]);
      else return;
      event.preventDefault();
    });
  }

  zoomBy(factor) {
    this.scene.camera.zoom *= factor;
    this.scene.camera.updateProjectionMatrix();
    this.draw();
  }

  // Steps of 5° to the right and down.
  turn(right, down) {
    const camera = this.scene.camera;
    const step = Math.PI / 36;
    const away = camera.position.clone().sub(this.controls.target);
    away.applyAxisAngle(camera.up, -right * step);
    const across = new Vector3().crossVectors(camera.up, away).normalize();
    const tipped = away.clone().applyAxisAngle(across, down * step);
    if (Math.abs(tipped.clone().normalize().dot(camera.up)) < 0.999) away.copy(tipped);
    camera.position.copy(this.controls.target).add(away);
    this.controls.update();
    this.draw();
  }

  // Steps of a twentieth of the view's height to the right and down.
  pan(right, down) {
    const camera = this.scene.camera;
    const step = 0.05 * this.scene.mmPerPixel() * this.canvas.clientHeight;
    const shift = new Vector3(-right * step, down * step, 0).transformDirection(camera.matrixWorld).multiplyScalar(step);
    camera.position.add(shift);
    this.controls.target.add(shift);
    this.controls.update();
    this.draw();
  }

  showLegends() {
    const legends = [];
    if (this.scene.state !== "before" && this.scene.uniforms.shows_depth.value === 1) legends.push(legend("Reamed depth, mm", this.bone.depth_colors));
    if (byId("cut-plane").value !== "") legends.push(legend("Bone density, g/cm³", this.bone.density_colors));
    byId("bone-legends").replaceChildren(...legends);
  }
}

// Without WebGL the first picture remains.
export function showBone(bone, tool) {
  byId("bone-interactive").hidden = false;
  try {
    const view = new BoneView(bone, tool);
    byId("bone-still")?.classList.add("print-only");
    return view;
  } catch (error) {
    const note = Object.assign(document.createElement("p"), { className: "note" });
    note.textContent = `This browser cannot show the 3D view (${error.message}). The pictures show the bone.`;
    byId("bone-interactive").replaceChildren(note);
    return undefined;
  }
}
