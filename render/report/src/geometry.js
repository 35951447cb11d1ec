// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Meshes of the page's data for three.js.
import { BufferAttribute, BufferGeometry } from "three";
import { meshOf } from "./decode.js";

export function geometryOf(packed, box) {
  const mesh = meshOf(packed, box);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(mesh.positions, 3));
  geometry.setAttribute("normal", new BufferAttribute(mesh.normals, 3, true));
  geometry.setAttribute("vertex_attributes", new BufferAttribute(mesh.attributes, 3, true));
  geometry.setAttribute("depth", new BufferAttribute(mesh.depths, 1, true));
  geometry.setIndex(new BufferAttribute(mesh.indices, 1));
  return geometry;
}
