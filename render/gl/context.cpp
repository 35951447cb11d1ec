// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/core.h>
#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

namespace reamsim {
namespace {

constexpr int kSamples = 4;
constexpr GLsizei kMaxLog = 4096;

/// The log of a shader or program, on one line.
std::string log_of(decltype(Gl::GetShaderInfoLog) get, GLuint id) {
  std::string log(kMaxLog, '\0');
  GLsizei length = 0;
  get(id, kMaxLog, &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  std::ranges::replace(log, '\n', ' ');
  return log.substr(0, log.find_last_not_of(' ') + 1);
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
  throw RunError(fmt::format("OpenGL failed while {}: {}", doing,
                             code == GL_OUT_OF_MEMORY ? "out of memory" : fmt::format("error {:#06x}", code)));
}

GlProgram::GlProgram(const Gl& gl, const std::string& name, const std::vector<const char*>& vertex,
                     const std::vector<const char*>& fragment)
    : gl_(gl), id_(gl.CreateProgram()) {
  std::string log;
  for (const auto& [type, texts] : {std::pair(GL_VERTEX_SHADER, &vertex), {GL_FRAGMENT_SHADER, &fragment}}) {
    const GLuint shader = gl.CreateShader(static_cast<GLenum>(type));
    gl.ShaderSource(shader, static_cast<GLsizei>(texts->size()), texts->data(), nullptr);
    gl.CompileShader(shader);
    log += log_of(gl.GetShaderInfoLog, shader);
    gl.AttachShader(id_, shader);
    gl.DeleteShader(shader);  // with the program
  }
  gl.LinkProgram(id_);  // fails for a shader that does not compile
  GLint done = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &done);
  if (done == GL_TRUE) return;
  log += log_of(gl.GetProgramInfoLog, id_);
  gl.DeleteProgram(id_);
  throw RunError("the shader '" + name + "' does not compile: " + log);
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
  const int stride = std::accumulate(attribute_sizes.begin(), attribute_sizes.end(), 0);
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
    throw RunError(fmt::format("a picture of {} x {} pixels are not supported; this OpenGL supports 1 to {} on a side",
                               width, height, largest));
  }
  samples = multisample ? std::min(samples, kSamples) : 0;
  attach(framebuffers_[0], buffers_[0], GL_COLOR_ATTACHMENT0, GL_RGBA8, samples);
  attach(framebuffers_[0], buffers_[1], GL_DEPTH_STENCIL_ATTACHMENT, GL_DEPTH24_STENCIL8, samples);
  attach(framebuffers_[1], buffers_[2], GL_COLOR_ATTACHMENT0, GL_RGBA8, 0);
  for (const std::size_t i : {0U, 1U}) {
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[i]);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE || gl.GetError() != GL_NO_ERROR) {
      throw RunError(fmt::format("OpenGL cannot create a picture of {} x {} pixels", width, height));
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

namespace {

/// Mesa's software rasteriser, so that pictures do not depend on the machine's GPU; null where EGL does not list it.
EGLDeviceEXT software_device(const DynamicLibrary& egl) {
  const auto address = egl.function<decltype(&eglGetProcAddress)>("eglGetProcAddress");
  const auto query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(address("eglQueryDevicesEXT"));
  const auto query_string = reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(address("eglQueryDeviceStringEXT"));
  if (query_devices == nullptr || query_string == nullptr) return nullptr;
  std::array<EGLDeviceEXT, 32> devices{};
  EGLint count = 0;
  if (query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count) != EGL_TRUE) return nullptr;
  for (const EGLDeviceEXT device : std::span(devices).first(static_cast<std::size_t>(count))) {
    const char* const extensions = query_string(device, EGL_EXTENSIONS);
    if (extensions != nullptr && std::strstr(extensions, "EGL_MESA_device_software") != nullptr) return device;
  }
  return nullptr;
}

EGLDisplay open_display(const DynamicLibrary& egl) {
  const auto get_display = egl.function<decltype(&eglGetPlatformDisplay)>("eglGetPlatformDisplay");
  const auto initialize = egl.function<decltype(&eglInitialize)>("eglInitialize");
  const EGLDeviceEXT software = software_device(egl);
  const EGLDisplay display = software != nullptr ? get_display(EGL_PLATFORM_DEVICE_EXT, software, nullptr)
                                                 : get_display(EGL_PLATFORM_SURFACELESS_MESA,
                                                               reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY), nullptr);
  if (display == EGL_NO_DISPLAY) throw RunError("EGL has no platform without a display (Mesa's)");
  if (initialize(display, nullptr, nullptr) != EGL_TRUE) {
    throw RunError("EGL cannot initialize its platform without a display");
  }
  return display;
}

/// The bound API is per thread, and OpenGL ES is the default.
void bind_opengl(const DynamicLibrary& egl) {
  if (egl.function<decltype(&eglBindAPI)>("eglBindAPI")(EGL_OPENGL_API) != EGL_TRUE)
    throw RunError("EGL has no OpenGL");
}

EGLContext create_context(const DynamicLibrary& egl, EGLDisplay display) {
  const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
  const auto choose = egl.function<decltype(&eglChooseConfig)>("eglChooseConfig");
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (choose(display, wanted.data(), &config, 1, &count) != EGL_TRUE || count == 0) {
    throw RunError("EGL has no configuration for OpenGL");
  }
  const std::array<EGLint, 7> attributes{
      EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  const auto create = egl.function<decltype(&eglCreateContext)>("eglCreateContext");
  const EGLContext context = create(display, config, EGL_NO_CONTEXT, attributes.data());
  if (context == EGL_NO_CONTEXT) throw RunError("EGL cannot create an OpenGL 4.5 core context");
  return context;
}

// The used part of GL/osmesa.h, which conflicts with GL/glcorearb.h and was removed in Mesa 25.1.
using OSMesaContext = struct osmesa_context*;
using CreateContextAttribs = OSMesaContext (*)(const int* attributes, OSMesaContext shared);
using MakeCurrent = GLboolean (*)(OSMesaContext context, void* buffer, GLenum type, GLsizei width, GLsizei height);
using DestroyContext = void (*)(OSMesaContext context);
using GetProcAddress = void (*(*)(const char* name))();
constexpr int kOsmesaFormat = 0x22, kOsmesaProfile = 0x33, kOsmesaCoreProfile = 0x34;
constexpr int kOsmesaMajorVersion = 0x36, kOsmesaMinorVersion = 0x37;

}  // namespace

OffscreenContext::OffscreenContext(RenderContext kind, std::function<void()> make_current,
                                   std::function<void()> release, const std::function<void*(const char*)>& address)
    : kind_(kind), make_current_(std::move(make_current)), release_(std::move(release)) {
  try {
    make_current_();
    gl_.load(address);
  } catch (...) {
    release_();
    throw;
  }
}

std::string OffscreenContext::description() const {
  const auto text = [this](GLenum name) {
    const GLubyte* const found = gl_.GetString(name);
    return std::string(found == nullptr ? "unknown" : reinterpret_cast<const char*>(found));
  };
  return std::string(name_of(kind_)) + ": " + text(GL_RENDERER) + ", " + text(GL_VERSION);
}

std::unique_ptr<OffscreenContext> make_egl_context() {
  const DynamicLibrary egl({"libEGL.so.1", "libEGL.so"}, "EGL");
  const auto set_current = egl.function<decltype(&eglMakeCurrent)>("eglMakeCurrent");
  const auto destroy = egl.function<decltype(&eglDestroyContext)>("eglDestroyContext");
  const auto address = egl.function<decltype(&eglGetProcAddress)>("eglGetProcAddress");
  const EGLDisplay display = open_display(egl);
  bind_opengl(egl);
  const EGLContext context = create_context(egl, display);
  const auto make_current = [=] {
    bind_opengl(egl);
    if (set_current(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) != EGL_TRUE) {
      throw RunError("EGL cannot make its context current without a surface");
    }
  };
  // The display stays open: every user of the default display in this process shares it.
  const auto release = [=] {
    set_current(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    destroy(display, context);
  };
  return std::make_unique<OffscreenContext>(RenderContext::egl, make_current, release,
                                            [=](const char* name) { return reinterpret_cast<void*>(address(name)); });
}

std::unique_ptr<OffscreenContext> make_osmesa_context() {
  const DynamicLibrary osmesa({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}, "OSMesa");
  const auto set_current = osmesa.function<MakeCurrent>("OSMesaMakeCurrent");
  const auto destroy = osmesa.function<DestroyContext>("OSMesaDestroyContext");
  const auto address = osmesa.function<GetProcAddress>("OSMesaGetProcAddress");
  const int attributes[] = {
      kOsmesaFormat, GL_RGBA, kOsmesaProfile, kOsmesaCoreProfile, kOsmesaMajorVersion, 4, kOsmesaMinorVersion, 5, 0};
  const auto create = osmesa.function<CreateContextAttribs>("OSMesaCreateContextAttribs");
  const OSMesaContext context = create(attributes, nullptr);
  if (context == nullptr) throw RunError("OSMesa cannot create an OpenGL 4.5 core context");
  // OSMesa requires a colour buffer; nothing is rendered into it.
  constexpr int kSide = 16;
  const auto backing = std::make_shared<std::array<unsigned char, std::size_t{4} * kSide * kSide>>();
  const auto make_current = [=] {
    if (set_current(context, backing->data(), GL_UNSIGNED_BYTE, kSide, kSide) == 0) {
      throw RunError("OSMesa cannot make its context current");
    }
  };
  const auto release = [=] {
    set_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
    destroy(context);
  };
  return std::make_unique<OffscreenContext>(RenderContext::osmesa, make_current, release,
                                            [=](const char* name) { return reinterpret_cast<void*>(address(name)); });
}

std::unique_ptr<OffscreenContext> make_context(RenderContext wanted, std::string& fallback) {
  fallback.clear();
  const bool osmesa_first = wanted != RenderContext::egl;
  std::string reasons;
  for (const bool osmesa : {osmesa_first, !osmesa_first}) {
    try {
      auto context = osmesa ? make_osmesa_context() : make_egl_context();
      if (osmesa != osmesa_first && wanted != RenderContext::automatic) {
        fallback = reasons + "; rendering with " + (osmesa ? "osmesa" : "egl") + " instead";
      }
      return context;
    } catch (const RunError& error) {
      reasons += (reasons.empty() ? "" : "; ") + std::string(error.what());
    }
  }
  throw RunError("no off-screen OpenGL context: " + reasons);
}

}  // namespace reamsim
