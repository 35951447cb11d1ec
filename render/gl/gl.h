// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#define GL_GLEXT_PROTOTYPES  // for the types of the functions
#include <GL/glcorearb.h>

#include <functional>

namespace reamsim {

/// Every OpenGL function that the renderer calls: X(name without gl).
// clang-format off
#define REAMSIM_GL_FUNCTIONS(X) \
  X(ActiveTexture) X(AttachShader) X(BindBuffer) X(BindFramebuffer) X(BindTexture) X(BindVertexArray) \
  X(BlendFuncSeparate) X(BlitFramebuffer) X(BufferData) X(CheckFramebufferStatus) X(Clear) X(ClearColor) \
  X(ColorMask) X(CompileShader) X(CreateProgram) X(CreateShader) X(CullFace) X(DeleteBuffers) X(DeleteFramebuffers) \
  X(DeleteProgram) X(DeleteRenderbuffers) X(DeleteShader) X(DeleteTextures) X(DeleteVertexArrays) X(DepthFunc) \
  X(DepthMask) X(Disable) X(DrawArrays) X(DrawElements) X(Enable) X(EnableVertexAttribArray) \
  X(FramebufferRenderbuffer) X(GenBuffers) X(GenFramebuffers) X(GenRenderbuffers) X(GenTextures) X(GenVertexArrays) \
  X(BindRenderbuffer) X(GetError) X(GetIntegerv) X(GetProgramInfoLog) X(GetProgramiv) X(GetShaderInfoLog) \
  X(GetShaderiv) X(GetString) X(GetUniformLocation) X(LinkProgram) X(PixelStorei) X(ReadPixels) \
  X(RenderbufferStorageMultisample) X(ShaderSource) X(StencilFunc) X(StencilOpSeparate) X(TexImage2D) X(TexParameteri) X(Uniform1f) X(Uniform1i) \
  X(Uniform3fv) X(Uniform4fv) X(UniformMatrix4fv) X(UseProgram) X(VertexAttribPointer) X(Viewport)
// clang-format on

/// The functions of one OpenGL context, by their names without the prefix gl.
struct Gl {
#define REAMSIM_GL_MEMBER(name) \
  decltype(&::gl##name) name = nullptr;  // NOLINT(bugprone-macro-parentheses): a member's name
  REAMSIM_GL_FUNCTIONS(REAMSIM_GL_MEMBER)
#undef REAMSIM_GL_MEMBER

  /// Loads every function. Throws RunError when one is missing.
  void load(const std::function<void*(const char*)>& address);
  /// Throws RunError, naming `doing`, when OpenGL has recorded an error since the last call.
  void check(const char* doing) const;
};

}  // namespace reamsim
