// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The bone before, during and after reaming and the reamer, with an optional section. Draws on request only.
import {
  AlwaysStencilFunc, BackSide, Data3DTexture, DecrementWrapStencilOp, DoubleSide, FrontSide, GLSL3, IncrementWrapStencilOp,
  KeepStencilOp, LinearFilter, Mesh, NotEqualStencilFunc, PlaneGeometry, RedFormat, ShaderMaterial, Vector4, View, boneMaterial,
  capFragment, capVertex, unpacked, vector,
} from "../shared/scene.js";
import { Reaming, ToolModel, geometryOf } from "./models.js";

function densityTexture(volume) {
  const texture = new Data3DTexture(unpacked(volume.bytes), ...volume.dims);
  texture.format = RedFormat;
  texture.minFilter = LinearFilter;
  texture.magFilter = LinearFilter;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

export class BoneScene extends View {
  constructor(canvas, bone, tool) {
    const { look } = bone;
    super(canvas, {
      focus: vector(look.focus_mm), reach: look.reach_mm, half: 0.5 * look.height_mm, up: look.superior, aside: vector(look.outward),
      directions: () => look,
    }, { stencil: true });
    this.cut = new Vector4(0, 0, 0, 1);
    this.addBone(bone);
    this.addCap(bone);
    this.addTool(tool);
    this.show("after");
  }

  addBone(bone) {
    const depth = bone.depth_colors;
    this.uniforms = {
      cut: { value: this.cut },
      depth_stops: { value: depth.stops.map(vector) },
      depth_max_mm: { value: depth.max },
      contour_mm: { value: depth.step },
      shows_depth: { value: 1 },
      lift_axis: { value: vector(bone.look.axis) },
    };
    // Behind the cut, more back faces than front faces on a ray mean that the cut plane lies in bone there.
    const counting = (side, operation) => boneMaterial(this.uniforms, depth.stops.length, {
      side, depthWrite: false, depthTest: false, colorWrite: false, stencilWrite: true, stencilFunc: AlwaysStencilFunc,
      stencilFail: operation, stencilZFail: operation, stencilZPass: operation,
    });
    const materials = [counting(BackSide, IncrementWrapStencilOp), counting(FrontSide, DecrementWrapStencilOp), boneMaterial(this.uniforms, depth.stops.length)];
    this.states = {};
    for (const state of ["before", "after"]) {
      const geometry = geometryOf(bone[state], bone.box_mm);
      if (state === "after" && bone.reaming !== null) this.reaming = new Reaming(geometry, bone.reaming, bone.look.axis);
      this.states[state] = materials.map((made, i) => {
        const mesh = new Mesh(geometry, made);
        mesh.renderOrder = i < 2 ? 1 : 3;
        mesh.frustumCulled = false;
        this.scene.add(mesh);
        return mesh;
      });
    }
  }

  addCap(bone) {
    const { dims, cell_mm, origin_mm } = bone.density;
    const colors = bone.density_colors;
    this.cap = new Mesh(
      new PlaneGeometry(4 * this.reach, 4 * this.reach),
      new ShaderMaterial({
        glslVersion: GLSL3, vertexShader: capVertex, fragmentShader: capFragment, side: DoubleSide,
        defines: { DENSITY_STOPS: colors.stops.length },
        uniforms: {
          density: { value: densityTexture(bone.density) },
          origin_mm: { value: vector(origin_mm) },
          size_mm: { value: vector(dims).multiplyScalar(cell_mm) },
          density_stops: { value: colors.stops.map(vector) },
          top_grade: { value: bone.grade_per_g_cm3 * colors.max },
        },
        stencilWrite: true, stencilRef: 0, stencilFunc: NotEqualStencilFunc, stencilFail: KeepStencilOp,
        stencilZFail: KeepStencilOp, stencilZPass: KeepStencilOp,
      }),
    );
    this.cap.renderOrder = 2;
    this.cap.visible = false;
    this.scene.add(this.cap);
  }

  addTool(tool) {
    if (tool === null) return;
    this.tool = new ToolModel(tool, this.cut);
    this.tool.look = tool.shown ? tool.look : "hidden";
    this.scene.add(this.tool.group);
  }

  // "before" or "after" the run, or "now": at the time of moveTo().
  show(state) {
    this.state = state;
    this.update();
  }

  // Tool and bone at a row of the log.
  // `touched`: bone was removed before.
  moveTo(row, time, touched) {
    [this.time, this.touched] = [time, touched];
    this.tool?.moveTo(row);
    this.update();
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

  // Cuts away what lies in front of the plane: `normal` (unit length) points to the removed side. null: no section.
  cutAlong(normal, point) {
    this.cap.visible = normal !== null;
    if (normal === null) {
      this.cut.set(0, 0, 0, 1);
    } else {
      this.cut.set(-normal.x, -normal.y, -normal.z, normal.dot(point));
      this.cap.position.copy(point);
      this.cap.lookAt(point.clone().add(normal));
    }
    this.update();
  }

  draw() {
    super.draw();
    if (this.tool) this.canvas.dataset.toolMm = this.tool.group.position.toArray().map((v) => v.toFixed(3)).join(" ");
  }

  render() {
    this.tool?.prepare(this.camera);
    super.render();
  }
}
