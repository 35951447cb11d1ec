// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#define GL_GLEXT_PROTOTYPES  // for the types of the functions
#include <GL/glcorearb.h>

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/choices.h"

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
  X(GetString) X(GetUniformLocation) X(LinkProgram) X(PixelStorei) X(ReadPixels) \
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

/// A linked shader program. This and the classes below need a current context from construction to destruction.
class GlProgram {
 public:
  /// Each shader is the concatenation of its texts. Throws RunError with the logs of compiler and linker.
  GlProgram(const Gl& gl, const std::string& name, const std::vector<const char*>& vertex,
            const std::vector<const char*>& fragment);
  ~GlProgram();
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  void use() const { gl_.UseProgram(id_); }
  // Uniforms of the program in use. OpenGL ignores unknown names.
  void set(const char* name, int value) const { gl_.Uniform1i(location(name), value); }
  void set(const char* name, double value) const { gl_.Uniform1f(location(name), static_cast<float>(value)); }
  void set(const char* name, const Eigen::Vector3d& value) const {
    gl_.Uniform3fv(location(name), 1, Eigen::Vector3f(value.cast<float>()).data());
  }
  void set(const char* name, const Eigen::Vector4d& value) const {
    gl_.Uniform4fv(location(name), 1, Eigen::Vector4f(value.cast<float>()).data());
  }
  void set(const char* name, const Eigen::Matrix4d& value) const {
    gl_.UniformMatrix4fv(location(name), 1, GL_FALSE, Eigen::Matrix4f(value.cast<float>()).data());
  }

 private:
  [[nodiscard]] GLint location(const char* name) const { return gl_.GetUniformLocation(id_, name); }

  const Gl& gl_;
  GLuint id_ = 0;
};

/// The names of N OpenGL objects of one kind, deleted with this.
template <int N>
class GlNames {
 public:
  GlNames(decltype(Gl::GenBuffers) generate, decltype(Gl::DeleteBuffers) destroy) : destroy_(destroy) {
    generate(N, ids_.data());
  }
  ~GlNames() { destroy_(N, ids_.data()); }
  GlNames(const GlNames&) = delete;
  GlNames& operator=(const GlNames&) = delete;

  [[nodiscard]] GLuint operator[](std::size_t i) const { return ids_[i]; }

 private:
  decltype(Gl::DeleteBuffers) destroy_;
  std::array<GLuint, N> ids_{};
};

/// Triangles on the device: floats per vertex in attributes 0, 1, …, and 32-bit indices.
class GlMesh {
 public:
  GlMesh(const Gl& gl, std::span<const float> vertices, std::span<const int> attribute_sizes,
         std::span<const std::uint32_t> indices);

  void draw() const;

 private:
  const Gl& gl_;
  GlNames<1> array_;
  GlNames<2> buffers_;  ///< vertices, indices
  GLsizei count_ = 0;
};

/// A two-dimensional float texture with linear filtering, clamped at its edges.
class GlTexture {
 public:
  /// `channels` is 2 or 3; `texels` has width·height·channels numbers, lowest row first.
  GlTexture(const Gl& gl, int width, int height, int channels, std::span<const float> texels);

  void bind(int unit) const;

 private:
  const Gl& gl_;
  GlNames<1> id_;
};

/// A render target: colour and depth, and a single-sampled copy to read from.
class GlTarget {
 public:
  /// `multisample`: several samples per pixel. Throws RunError when OpenGL cannot make a picture of this size.
  GlTarget(const Gl& gl, int width, int height, bool multisample);

  void bind() const;
  /// The picture, BGRA as in Cairo, top row first.
  [[nodiscard]] std::vector<std::uint32_t> read() const;

 private:
  void attach(GLuint framebuffer, GLuint buffer, GLenum attachment, GLenum format, int samples) const;

  const Gl& gl_;
  int width_;
  int height_;
  GlNames<2> framebuffers_;
  GlNames<3> buffers_;
};

/// A shared library opened at run time, so that the program runs without it. It stays loaded until the process ends:
/// Mesa has thread-local state and exit handlers that do not survive dlclose.
class DynamicLibrary {
 public:
  /// Opens the first of `names` that can be loaded. Throws RunError, naming the `purpose`, when none can.
  DynamicLibrary(std::initializer_list<const char*> names, const std::string& purpose) {
    for (const char* name : names) {
      name_ = name;
      handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
      if (handle_ != nullptr) return;
    }
    throw RunError(fmt::format("{} cannot be used: none of {} can be loaded", purpose, fmt::join(names, ", ")));
  }

  /// The function `name` as a pointer of type F. Throws RunError when it is missing.
  template <typename F>
  [[nodiscard]] F function(const char* name) const {
    void* found = dlsym(handle_, name);
    if (found == nullptr) throw RunError(name_ + " has no function " + name);
    return reinterpret_cast<F>(found);
  }

 private:
  void* handle_ = nullptr;
  std::string name_;
};

/// An OpenGL 4.5 core context without a window or a size, current on the thread that made it as long as it lives.
class OffscreenContext {
 public:
  /// Makes the context current and loads its functions by `address`. `release` destroys it. Throws RunError.
  OffscreenContext(RenderContext kind, std::function<void()> make_current, std::function<void()> release,
                   const std::function<void*(const char*)>& address);
  ~OffscreenContext() { release_(); }
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  /// What renders: "egl: llvmpipe (LLVM 19.1.7, 256 bits), 4.5 (Core Profile) Mesa 25.0.7".
  [[nodiscard]] std::string description() const;
  [[nodiscard]] const Gl& gl() const { return gl_; }
  void make_current() const { make_current_(); }

 private:
  RenderContext kind_;
  std::function<void()> make_current_, release_;
  Gl gl_;
};

/// Mesa's software rasteriser through libOSMesa. Throws RunError: no library, no OpenGL 4.5.
std::unique_ptr<OffscreenContext> make_osmesa_context();

/// EGL without a window: Mesa's software rasteriser where EGL lists it, otherwise what Mesa's surfaceless platform
/// chooses. Throws RunError: no library, no such platform, no OpenGL 4.5.
std::unique_ptr<OffscreenContext> make_egl_context();

/// The `wanted` context (`automatic`: OSMesa), or the other one where it is not available; `fallback` then says so if
/// it was asked for by name (else empty). Both give the same pictures on Mesa. Throws RunError with both reasons.
std::unique_ptr<OffscreenContext> make_context(RenderContext wanted, std::string& fallback);

}  // namespace reamsim
