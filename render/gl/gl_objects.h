#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/gl.h"

namespace reamsim {

/// A linked shader program. The context must be current whenever one is made, used or destroyed; so for all below.
class GlProgram {
 public:
  /// Each shader is the given texts, one after the other. Throws RunError with the compiler's log.
  GlProgram(const Gl& gl, const std::string& name, const std::vector<const char*>& vertex,
            const std::vector<const char*>& fragment);
  ~GlProgram();
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  void use() const { gl_.UseProgram(id_); }
  // Uniforms of the program in use; a name that the shader does not have is ignored, as OpenGL does.
  void set(const char* name, int value) const { gl_.Uniform1i(location(name), value); }
  void set(const char* name, float value) const { gl_.Uniform1f(location(name), value); }
  void set(const char* name, const Eigen::Vector3f& value) const { gl_.Uniform3fv(location(name), 1, value.data()); }
  void set(const char* name, const Eigen::Vector4f& value) const { gl_.Uniform4fv(location(name), 1, value.data()); }
  void set(const char* name, const Eigen::Matrix4f& value) const {
    gl_.UniformMatrix4fv(location(name), 1, GL_FALSE, value.data());
  }

 private:
  [[nodiscard]] GLint location(const char* name) const { return gl_.GetUniformLocation(id_, name); }

  const Gl& gl_;
  GLuint id_ = 0;
};

/// Triangles on the device: floats per vertex in groups (attribute 0, 1, …), and 32-bit indices.
class GlMesh {
 public:
  GlMesh(const Gl& gl, std::span<const float> vertices, std::span<const int> group_sizes,
         std::span<const std::uint32_t> indices);
  ~GlMesh();
  GlMesh(const GlMesh&) = delete;
  GlMesh& operator=(const GlMesh&) = delete;

  void draw() const;

 private:
  const Gl& gl_;
  GLuint array_ = 0;
  GLuint vertices_ = 0;
  GLuint indices_ = 0;
  GLsizei count_ = 0;
};

/// A two-dimensional float texture with linear filtering, clamped at its edges.
class GlTexture {
 public:
  /// `channels` is 2 or 3; `texels` has width·height·channels numbers, lowest row first.
  GlTexture(const Gl& gl, int width, int height, int channels, std::span<const float> texels);
  ~GlTexture();
  GlTexture(const GlTexture&) = delete;
  GlTexture& operator=(const GlTexture&) = delete;

  void bind(int unit) const;

 private:
  const Gl& gl_;
  GLuint id_ = 0;
};

/// What pictures are drawn into: colour and depth, and a plain copy to read from.
class GlTarget {
 public:
  /// `multisample`: several samples per pixel. Throws RunError when OpenGL cannot make a picture of this size.
  GlTarget(const Gl& gl, int width, int height, bool multisample);
  ~GlTarget();
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;

  /// Draws go here from now on.
  void bind() const;
  /// The finished picture, BGRA (as Cairo wants it), top row first.
  [[nodiscard]] std::vector<std::uint32_t> read() const;

 private:
  void attach(GLuint framebuffer, GLuint buffer, GLenum attachment, GLenum format, int samples) const;

  const Gl& gl_;
  int width_;
  int height_;
  GLuint framebuffers_[2] = {0, 0};
  GLuint buffers_[3] = {0, 0, 0};
};

}  // namespace reamsim
