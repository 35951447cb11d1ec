// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/gl_objects.h"

#include <algorithm>

#include "sim/base/error.h"

namespace reamsim {
namespace {

std::string error_name(GLenum code) {
  constexpr std::array<const char*, 7> kNames{"invalid enum",
                                              "invalid value",
                                              "invalid operation",
                                              nullptr,
                                              nullptr,
                                              "out of memory",
                                              "invalid framebuffer operation"};
  const std::size_t i = code - GL_INVALID_ENUM;  // the codes are consecutive
  return i < kNames.size() && kNames[i] != nullptr ? kNames[i] : "unknown error";
}

constexpr int kSamples = 4;
constexpr GLsizei kMaxLog = 4096;

std::string trimmed_log(std::string log) {
  std::replace(log.begin(), log.end(), '\n', ' ');
  return log.substr(0, log.find_last_not_of(' ') + 1);
}

GLuint compile(const Gl& gl, const std::string& name, GLenum type, const std::vector<const char*>& texts) {
  const GLuint shader = gl.CreateShader(type);
  gl.ShaderSource(shader, static_cast<GLsizei>(texts.size()), texts.data(), nullptr);
  gl.CompileShader(shader);
  GLint done = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done == GL_TRUE) return shader;
  std::string log(kMaxLog, '\0');
  gl.GetShaderInfoLog(shader, kMaxLog, nullptr, log.data());
  gl.DeleteShader(shader);
  throw RunError("the shader '" + name + "' does not compile: " + trimmed_log(log.c_str()));
}

}  // namespace

void Gl::load(const std::function<void*(const char*)>& address) {
// NOLINTBEGIN(bugprone-macro-parentheses): a member's name
#define REAMSIM_GL_LOAD(name)                                   \
  name = reinterpret_cast<decltype(name)>(address("gl" #name)); \
  if (name == nullptr) throw RunError("this OpenGL has no function gl" #name);
  REAMSIM_GL_FUNCTIONS(REAMSIM_GL_LOAD)
#undef REAMSIM_GL_LOAD
  // NOLINTEND(bugprone-macro-parentheses)
}

void Gl::check(const char* doing) const {
  const GLenum code = GetError();
  if (code == GL_NO_ERROR) return;
  // A lost context reports errors forever, so only a few are drained.
  for (int i = 0; i < 16 && GetError() != GL_NO_ERROR; ++i) {
  }
  throw RunError(std::string("OpenGL failed while ") + doing + ": " + error_name(code));
}

GlProgram::GlProgram(const Gl& gl, const std::string& name, const std::vector<const char*>& vertex,
                     const std::vector<const char*>& fragment)
    : gl_(gl) {
  const GLuint vertex_id = compile(gl, name, GL_VERTEX_SHADER, vertex);
  const GLuint fragment_id = compile(gl, name, GL_FRAGMENT_SHADER, fragment);
  id_ = gl.CreateProgram();
  gl.AttachShader(id_, vertex_id);
  gl.AttachShader(id_, fragment_id);
  gl.LinkProgram(id_);
  gl.DeleteShader(vertex_id);
  gl.DeleteShader(fragment_id);
  GLint done = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return;
  std::string log(kMaxLog, '\0');
  gl.GetProgramInfoLog(id_, kMaxLog, nullptr, log.data());
  gl.DeleteProgram(id_);
  throw RunError("the shader '" + name + "' does not link: " + trimmed_log(log.c_str()));
}

GlProgram::~GlProgram() {
  gl_.DeleteProgram(id_);
}

GlMesh::GlMesh(const Gl& gl, std::span<const float> vertices, std::span<const int> attribute_sizes,
               std::span<const std::uint32_t> indices)
    : gl_(gl),
      array_(gl.GenVertexArrays, gl.DeleteVertexArrays),
      buffers_(gl.GenBuffers, gl.DeleteBuffers),
      count_(static_cast<GLsizei>(indices.size())) {
  gl.BindVertexArray(array_[0]);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
  gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size_bytes()), vertices.data(), GL_STATIC_DRAW);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[1]);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size_bytes()), indices.data(), GL_STATIC_DRAW);
  int stride = 0;
  for (const int size : attribute_sizes) stride += size;
  std::size_t offset = 0;
  GLuint attribute = 0;
  for (const int size : attribute_sizes) {
    gl.VertexAttribPointer(attribute, size, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride * sizeof(float)),
                           reinterpret_cast<const void*>(offset));
    gl.EnableVertexAttribArray(attribute++);
    offset += static_cast<std::size_t>(size) * sizeof(float);
  }
  gl.check("copying a mesh to the device");
}

void GlMesh::draw() const {
  gl_.BindVertexArray(array_[0]);
  gl_.DrawElements(GL_TRIANGLES, count_, GL_UNSIGNED_INT, nullptr);
}

GlTexture::GlTexture(const Gl& gl, int width, int height, int channels, std::span<const float> texels)
    : gl_(gl), id_(gl.GenTextures, gl.DeleteTextures) {
  gl.BindTexture(GL_TEXTURE_2D, id_[0]);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TexImage2D(GL_TEXTURE_2D, 0, channels == 2 ? GL_RG32F : GL_RGB32F, width, height, 0,
                channels == 2 ? GL_RG : GL_RGB, GL_FLOAT, texels.data());
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.check("copying a texture to the device");
}

void GlTexture::bind(int unit) const {
  gl_.ActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  gl_.BindTexture(GL_TEXTURE_2D, id_[0]);
}

GlTarget::GlTarget(const Gl& gl, int width, int height, bool multisample)
    : gl_(gl),
      width_(width),
      height_(height),
      framebuffers_(gl.GenFramebuffers, gl.DeleteFramebuffers),
      buffers_(gl.GenRenderbuffers, gl.DeleteRenderbuffers) {
  GLint largest = 0, samples = 0;
  gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
  gl.GetIntegerv(GL_MAX_SAMPLES, &samples);
  if (width < 1 || height < 1 || width > largest || height > largest) {
    throw RunError("a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                   " pixels are not supported; this OpenGL supports 1 to " + std::to_string(largest) + " on a side");
  }
  samples = multisample ? std::min(samples, kSamples) : 0;
  attach(framebuffers_[0], buffers_[0], GL_COLOR_ATTACHMENT0, GL_RGBA8, samples);
  attach(framebuffers_[0], buffers_[1], GL_DEPTH_STENCIL_ATTACHMENT, GL_DEPTH24_STENCIL8, samples);
  attach(framebuffers_[1], buffers_[2], GL_COLOR_ATTACHMENT0, GL_RGBA8, 0);
  for (const std::size_t i : {0U, 1U}) {
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[i]);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE || gl.GetError() != GL_NO_ERROR) {
      throw RunError("OpenGL cannot create a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                     " pixels");
    }
  }
}

void GlTarget::attach(GLuint framebuffer, GLuint buffer, GLenum attachment, GLenum format, int samples) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl_.BindRenderbuffer(GL_RENDERBUFFER, buffer);
  gl_.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width_, height_);
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
}

void GlTarget::bind() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[0]);
  gl_.Viewport(0, 0, width_, height_);
}

std::vector<std::uint32_t> GlTarget::read() const {
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[0]);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers_[1]);
  gl_.BlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[1]);
  std::vector<std::uint32_t> pixels(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.ReadPixels(0, 0, width_, height_, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV, pixels.data());
  gl_.check("reading a picture back");
  for (int row = 0; row < height_ / 2; ++row) {
    const auto lower = pixels.begin() + std::ptrdiff_t{width_} * row;
    std::swap_ranges(lower, lower + width_, pixels.begin() + std::ptrdiff_t{width_} * (height_ - 1 - row));
  }
  return pixels;
}

}  // namespace reamsim
