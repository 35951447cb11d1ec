// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What report and preview share; dist/scene.js has it once for both.
export {
  ArrowHelper, BackSide, Box3, BufferAttribute, BufferGeometry, Color, Data3DTexture, DecrementWrapStencilOp, FrontSide, Group,
  IncrementWrapStencilOp, LatheGeometry, LinearFilter, Matrix4, Mesh, MeshBasicMaterial, PlaneGeometry, Quaternion, RedFormat,
  SphereGeometry, Vector2, Vector3, Vector4,
} from "three";
export * from "./decode.js";
export * from "./elements.js";
export * from "./materials.js";
export * from "./numbers.js";
export * from "./view.js";
