// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The reamer of the 3D view: see-through as in the pictures, or of steel.
import { DoubleSide, GLSL3, Group, LessEqualDepth, Mesh, Quaternion, ShaderMaterial, Vector3 } from "three";
import { toolFragment, toolVertex } from "./shaders.js";
import { posesOf } from "./decode.js";
import { geometryOf } from "./geometry.js";

const spinAxis = new Vector3(0, 0, -1);  // of a positive spin, in the tool frame

// The reamer of a pass.
function modelOf(pass, materials) {
  const geometry = geometryOf(pass.mesh, pass.box_mm);
  const model = new Group();
  materials.forEach((material, i) => {
    const mesh = new Mesh(geometry, material);
    mesh.renderOrder = 10 + i;
    mesh.frustumCulled = false;
    model.add(mesh);
  });
  return model;
}

export class ToolModel {
  constructor(tool, cut) {
    this.poses = posesOf(tool.poses);
    this.uniforms = {
      cut: { value: cut }, has_cut: { value: 0 }, opaque: { value: 0 },
      towards_viewer: { value: new Vector3(0, 0, 1) }, depth_per_mm: { value: 0 },
    };
    const material = (more) => new ShaderMaterial({
      glslVersion: GLSL3, vertexShader: toolVertex, fragmentShader: toolFragment, uniforms: this.uniforms,
      side: DoubleSide, depthFunc: LessEqualDepth, transparent: true, ...more,
    });
    // Its nearest faces alone are drawn, so that its walls do not add up.
    const materials = [material({ colorWrite: false }), material({ depthWrite: false })];
    this.group = new Group();
    this.passes = tool.passes.map((pass) => ({ row: pass.row, model: modelOf(pass, materials) }));
    for (const pass of this.passes) this.group.add(pass.model);
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

  prepare(camera) {
    camera.getWorldDirection(this.uniforms.towards_viewer.value).negate();
    this.uniforms.depth_per_mm.value = 1 / (camera.far - camera.near);
  }
}
