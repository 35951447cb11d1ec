// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The controls beside the views.
import { choices, find, fixedText, part, sayValue } from "../shared/scene.js";
import { applyMarkups, markupsText } from "./markups.js";
import { colors } from "./model.js";
import { same } from "./volume.js";

const kTools = [
  ["look", "Nothing: move the cross"], ["center", "Glenoid centre"], ["superior", "Superior of the glenoid"], ["seed", "Seed in the bone"],
  ["trigonum", "Trigonum spinae"], ["inferior", "Inferior angle"], ["rim", "Rim of the face"],
];

// Downloads a text as a file.
export function saveText(text, name, type) {
  const url = URL.createObjectURL(new Blob([text], { type }));
  part("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

const pointText = (p, missing = "not placed") => (p === null ? missing : p.map((c) => fixedText(c, 1)).join(", "));

export class Controls {
  constructor(model, slices, window) {
    Object.assign(this, { model, slices, window });
    this.addTools();
    this.addPoint();
    this.addMarkups();
    this.addFrame();
    this.addSegmentation();
    this.addReamer();
    this.addWindow();
    this.addKey();
    this.show();
  }

  get tools() {
    const ct = this.model.data.ct !== null && !this.model.data.ct.label_map;
    const spheres = this.model.values.cut_spheres.map((_, i) => [`sphere-${i}`, `Centre of cut sphere ${i + 1}`]);
    return [...kTools.filter(([tool]) => ct || tool !== "seed"), ...spheres];
  }

  addTools() {
    find("tools").addEventListener("change", (event) => this.model.choose(event.target.value));
    find("place-here").addEventListener("click", () => this.model.place(this.model.tool, this.model.cross));
    find("go-there").addEventListener("click", () => {
      const point = this.model.pointOf(this.model.tool);
      if (point !== null) this.model.moveCross(point);
    });
    find("remove-point").addEventListener("click", () => this.model.remove(this.model.tool));
  }

  // Rebuilt only when the list changes, so that the focus stays.
  showTools() {
    const { model } = this, names = this.tools, key = names.map(([tool]) => tool).join();
    if (key !== this.toolKey) {
      this.toolKey = key;
      find("tools").replaceChildren(find("tools").querySelector("legend"), ...names.map(([tool, name]) => {
        const dot = part("span", { class: "dot", style: `background: ${colors[tool] ?? (tool === "look" ? "transparent" : colors.sphere)}` });
        return part("label", { class: "tool" }, part("input", { type: "radio", name: "tool", value: tool }), dot, part("span", {}, name), part("output", { id: `at-${tool}` }));
      }));
    }
    for (const [tool] of names) {
      find("tools").querySelector(`input[value=${tool}]`).checked = tool === model.tool;
      find(`at-${tool}`).textContent = tool === "look" ? "" : tool === "rim" ? `${model.values.rim.length} points`
        : tool === "superior" ? (model.values.superior === null ? "not placed" : "placed") : pointText(model.pointOf(tool));
    }
    const placed = model.tool !== "look" && model.pointOf(model.tool) !== null;
    find("place-here").disabled = model.tool === "look" || (model.tool === "superior" && model.values.center === null);
    find("go-there").disabled = find("remove-point").disabled = !placed;
  }

  // Inputs for x, y and z behind the legend of a fieldset; returns what shows values in them.
  numbers(id, step, apply) {
    const inputs = [0, 1, 2].map((axis) => part("input", { type: "number", step, "data-axis": `${axis}` }));
    find(id).querySelector("legend").after(...inputs.map((input, axis) => part("label", {}, `${"xyz"[axis]} `, input)));
    for (const input of inputs) {
      input.addEventListener("change", () => {
        const values = inputs.map((each) => Number(each.value));
        if (inputs.every((each) => each.value !== "") && values.every(Number.isFinite)) apply(values);
      });
    }
    return (values, digits) => inputs.forEach((input, i) => {
      const shown = values === null ? "" : String(Number(values[i].toFixed(digits)) + 0);
      if (input.value !== shown) input.value = shown;
    });
  }

  addPoint() {
    this.showPoint = this.numbers("point", 0.1, (point) => {
      if (this.model.tool === "look") return this.model.moveCross(point);
      const placed = this.model.pointOf(this.model.tool) !== null;
      this.model.place(this.model.tool, point, placed && this.model.tool !== "center");
      return this.model.moveCross(point);
    });
  }

  addMarkups() {
    const say = (text) => { find("markups-state").textContent = text; };
    find("read-markups").addEventListener("change", async ({ target }) => {
      const [file] = target.files;
      if (file === undefined) return;
      try {
        say(applyMarkups(this.model, await file.text()));
      } catch (error) {
        say(`${file.name} cannot be read: ${error.message}.`);
      }
      target.value = "";  // the same file can be read again
    });
    find("save-markups").addEventListener("click", () => {
      const name = this.model.data.file_name.replace(/\.ya?ml$/, "") + ".mrk.json";
      saveText(markupsText(this.model), name, "application/json");
      say(`Saved as ${name}.`);
    });
  }

  addFrame() {
    this.chooseSide = choices("side", "side", [["left", "Left"], ["right", "Right"]], (side) => this.model.set({ side }));
    this.chooseFrom = choices("from", "from", [["face", "Face"], ["landmarks", "Landmarks"]], (from) => this.model.set({ from }));
    this.showNormal = this.numbers("normal", 0.01, (normal) => { if (normal.some((n) => n !== 0)) this.model.set({ normal }); });
    find("fit-normal").addEventListener("click", () => this.model.fitNormal());
    find("flip-normal").addEventListener("click", () => this.model.set({ normal: this.model.values.normal.map((n) => -n + 0) }));
  }

  showFrame() {
    const { values } = this.model, face = values.from === "face";
    this.chooseSide(values.side);
    this.chooseFrom(values.from);
    this.showNormal(face ? values.normal : this.model.glenoid?.axes[2] ?? null, 4);
    for (const input of document.querySelectorAll("#normal input")) input.disabled = !face;
    find("fit-normal").disabled = !face || values.center === null;
    find("flip-normal").disabled = !face || values.normal === null;
  }

  addSegmentation() {
    const { ct } = this.model.data;
    if (ct === null || ct.label_map) return;
    find("segmentation").hidden = false;
    // Keys that the page uses and does not change.
    const rows = [["crop_min_mm", pointText(ct.crop_min_mm, "the scan's")], ["crop_max_mm", pointText(ct.crop_max_mm, "the scan's")], ["filter", ct.filter],
      ["closing_mm", fixedText(ct.closing_mm, 2)], ["fill_holes", ct.fill_holes ? "true" : "false"],
      ...ct.cut_planes.map((plane, i) => [`cut_planes ${i + 1}`, `through ${pointText(plane.point_mm)}; normal ${plane.normal.map((c) => fixedText(c, 3)).join(", ")}`]),
      ...ct.separated.map((sphere) => ["separate: humerus", `sphere of ${fixedText(sphere.radius_mm, 1)} mm about ${pointText(sphere.center_mm)}`])];
    find("fixed").replaceChildren(...rows.flatMap(([key, value]) => [part("dt", {}, key), part("dd", {}, value)]));
    const slider = find("threshold");
    Object.assign(slider, { min: Math.min(-200, ct.threshold_hu), max: Math.max(1000, ct.threshold_hu) });
    // A threshold between the slider's steps stays as it is until the slider moves.
    slider.step = ct.threshold_hu % 5 === 0 ? 5 : 1;
    slider.addEventListener("input", () => this.soon({ threshold_hu: Number(slider.value) }));
    find("add-sphere").addEventListener("click", () => {
      const { values: { cut_spheres }, cross } = this.model;
      this.model.set({ cut_spheres: [...cut_spheres, { center_mm: [...cross], radius_mm: 20 }] });
      this.model.choose(`sphere-${cut_spheres.length}`);
    });
  }

  // The mask of a slider's last place in a frame; it takes longer than a frame.
  soon(changes) {
    if (this.waiting === undefined) {
      setTimeout(() => {
        const all = this.waiting;
        this.waiting = undefined;
        this.model.set(all);
      }, 30);
    }
    this.waiting = { ...this.waiting, ...changes };
  }

  showSegmentation() {
    const { values, data, live, segmentationChanged } = this.model;
    if (find("segmentation").hidden) return;
    find("threshold").value = values.threshold_hu;
    sayValue("threshold", `${values.threshold_hu} HU`);
    this.showSpheres();
    find("mask-note").textContent = segmentationChanged || data.volume.bone === null
      ? (live === null ? "No bone remains." : "Blue: what these settings would segment, on a coarse copy of the scan. Orange: what the program has segmented.")
      : "Orange: the bone as the program has segmented it. Changes show their effect in blue.";
  }

  showSpheres() {
    const spheres = this.model.values.cut_spheres, place = find("spheres");
    if (place.children.length !== spheres.length) {
      place.replaceChildren(...spheres.map((_, i) => {
        const id = `radius-${i}`, slider = part("input", { type: "range", id, min: 1, max: 60, step: 0.1 });
        slider.addEventListener("input", () => this.soon({
          cut_spheres: this.model.values.cut_spheres.map((sphere, k) => (k === i ? { ...sphere, radius_mm: Number(slider.value) } : sphere)),
        }));
        const remove = part("button", { type: "button", "aria-label": `Remove cut sphere ${i + 1}`, onclick: () => this.model.remove(`sphere-${i}`) }, "Remove");
        return part("div", { class: "sphere" }, part("label", { for: id, class: "field" }, `Radius of cut sphere ${i + 1} `, part("output", {})), slider, remove);
      }));
    }
    spheres.forEach((sphere, i) => {
      find(`radius-${i}`).value = sphere.radius_mm;
      place.children[i].querySelector("output").textContent = `${sphere.radius_mm.toFixed(1)} mm`;
    });
  }

  addReamer() {
    const { reamer } = this.model;
    if (reamer === null) return;
    find("reamer").hidden = false;
    find("pose").max = reamer.motion.poses.length - 1;
    find("pose").addEventListener("input", () => this.model.setPose(Number(find("pose").value)));
    find("show-reamer").addEventListener("change", () => {
      this.model.showsReamer = find("show-reamer").checked;
      this.model.notify("pose");
    });
  }

  showPose() {
    const { reamer, pose, posed } = this.model;
    if (reamer === null) return;
    Object.assign(find("pose"), { value: pose, disabled: posed === null });
    sayValue("pose", posed === null ? "needs a glenoid frame" : `${reamer.motion.time_s[pose].toFixed(2)} s`);
  }

  addWindow() {
    const { window, model } = this, digits = model.volume.unit === "HU" ? 0 : 2;
    Object.assign(find("level"), { min: window.least, max: window.most, step: window.step, value: window.level });
    Object.assign(find("width"), { min: window.step, max: 2 * (window.most - window.least), step: window.step, value: window.width });
    const show = () => {
      for (const key of ["level", "width", "zoom"]) {
        window[key] = Number(find(key).value);
        sayValue(key, key === "zoom" ? `${window.zoom.toFixed(1)}×` : `${fixedText(window[key], digits)} ${model.volume.unit}`);
      }
      for (const slice of this.slices) slice.draw();
    };
    for (const key of ["level", "width", "zoom"]) find(key).addEventListener("input", show);
    show();
  }

  addKey() {
    const { model } = this, items = [["bone", "bone"]];
    if (model.data.ct !== null && !model.data.ct.label_map) items.push(["live", "bone with your changes"], ["sphere", "cut sphere"]);
    if (model.reamer !== null) items.push(["reamer", "reamer"]);
    items.push(["center", "normal"]);
    find("key").append(...items.map(([name, words]) =>
      part("li", {}, part("span", { class: "line", style: `background: ${colors[name]}` }), words)));
  }

  showFindings() {
    const names = { problem: "Problem", note: "Note", fine: "Fine" };
    const findings = this.model.findings;
    if (same(findings, this.shown)) return;
    this.shown = findings;
    find("warnings").replaceChildren(...findings.map((each) => part("li", { class: each.level }, part("strong", {}, `${names[each.level]}: `), each.text)));
  }

  show() {
    this.showTools();
    find("point-name").textContent = this.model.tool === "look" ? "Cross" : this.tools.find(([tool]) => tool === this.model.tool)[1];
    this.showPoint(this.model.pointOf(this.model.tool), 2);
    this.showFrame();
    this.showSegmentation();
    this.showPose();
    this.showFindings();
  }
}
