// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The 3D view's controls.
import { Vector3, choices, find, legend, vector, viewMissing } from "../shared/scene.js";
import { BoneScene } from "./scene.js";

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

class BoneView {
  constructor(bone, tool) {
    this.bone = bone;
    this.scene = new BoneScene(find("bone-canvas"), bone, tool);
    this.planes = planesOf(bone.look);
    for (const [name, direction] of viewsOf(bone.look)) this.scene.addButton(name, () => this.scene.look(direction));
    this.addStates();
    this.addToolLooks(tool);
    this.addCuts();
    this.showLegends();
    this.scene.look(vector(bone.look.towards_viewer));
  }

  addStates() {
    const { scene, bone: { reaming } } = this;
    const redraw = () => { this.showLegends(); scene.draw(); };
    const choose = choices("state", (state) => { scene.show(state); redraw(); });
    choices("surface", (surface) => { scene.uniforms.shows_depth.value = surface === "depth" ? 1 : 0; redraw(); });
    document.querySelector("input[name=state][value=now]").closest("label").hidden = reaming === null;
    if (reaming === null) return;
    choose("now");
    scene.show("now");
  }

  addToolLooks(tool) {
    find("tool-looks").hidden = tool === null;
    const choose = choices("tool", (look) => { this.scene.tool.look = look; this.scene.draw(); });
    if (tool !== null) choose(tool.shown ? tool.look : "hidden");
  }

  moveTo(row, time, touched) {
    this.scene.moveTo(row, time, touched);
    this.scene.draw();
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
    if (normal !== null) this.scene.look(normal);
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

  moveCut() {
    const plane = this.planes[find("cut-plane").value];
    const offset = Number(find("cut-offset").value);
    find("cut-value").textContent = `${offset.toFixed(1).replace("-", "−")} mm`;
    find("cut-offset").setAttribute("aria-valuetext", `${offset.toFixed(1)} mm from the tool axis`);
    const point = plane && vector(this.bone.look.axis_point_mm).addScaledVector(plane.normal, offset);
    this.scene.cutAlong(this.cutNormal(), point);
    this.scene.draw();
  }

  showLegends() {
    const legends = [];
    if (this.scene.state !== "before" && this.scene.uniforms.shows_depth.value === 1) legends.push(legend("Reamed depth, mm", this.bone.depth_colors));
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
