// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <span>
#include <string_view>

#include "sim/base/error.h"

namespace reamsim {
namespace {

class EglContext final : public OffscreenContext {
 public:
  EglContext()
      : OffscreenContext(RenderContext::egl),
        library_({"libEGL.so.1", "libEGL.so"}, "EGL"),
        make_current_(library_.function<decltype(&eglMakeCurrent)>("eglMakeCurrent")),
        destroy_(library_.function<decltype(&eglDestroyContext)>("eglDestroyContext")) {
    create();
    try {
      make_current();
      const auto address = library_.function<decltype(&eglGetProcAddress)>("eglGetProcAddress");
      gl_.load([address](const char* name) { return reinterpret_cast<void*>(address(name)); });
    } catch (...) {
      release();
      throw;
    }
  }

  ~EglContext() override { release(); }
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  void make_current() override {
    // The bound API is per thread, and OpenGL ES is the default.
    bind_opengl();
    if (make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
      throw RunError("EGL cannot make its context current without a surface");
    }
  }

 private:
  void create() {
    const auto get_display = library_.function<decltype(&eglGetPlatformDisplay)>("eglGetPlatformDisplay");
    const auto initialize = library_.function<decltype(&eglInitialize)>("eglInitialize");
    const EGLDeviceEXT software = software_device();
    display_ = software != nullptr
                   ? get_display(EGL_PLATFORM_DEVICE_EXT, software, nullptr)
                   : get_display(EGL_PLATFORM_SURFACELESS_MESA, reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY), nullptr);
    if (display_ == EGL_NO_DISPLAY) throw RunError("EGL has no platform without a display (Mesa's)");
    if (initialize(display_, nullptr, nullptr) != EGL_TRUE) {
      throw RunError("EGL cannot initialize its platform without a display");
    }
    bind_opengl();
    const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
    const auto choose = library_.function<decltype(&eglChooseConfig)>("eglChooseConfig");
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (choose(display_, wanted.data(), &config, 1, &count) != EGL_TRUE || count == 0) {
      throw RunError("EGL has no configuration for OpenGL");
    }
    const std::array<EGLint, 7> attributes{
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    const auto create_context = library_.function<decltype(&eglCreateContext)>("eglCreateContext");
    context_ = create_context(display_, config, EGL_NO_CONTEXT, attributes.data());
    if (context_ == EGL_NO_CONTEXT) throw RunError("EGL cannot create an OpenGL 4.5 core context");
  }

  /// Mesa's software rasteriser among the devices of EGL, so that pictures do not depend on the machine's GPU; null
  /// where EGL does not list devices, or has no such one.
  [[nodiscard]] EGLDeviceEXT software_device() const {
    const auto address = library_.function<decltype(&eglGetProcAddress)>("eglGetProcAddress");
    const auto query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(address("eglQueryDevicesEXT"));
    const auto query_string = reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(address("eglQueryDeviceStringEXT"));
    if (query_devices == nullptr || query_string == nullptr) return nullptr;
    std::array<EGLDeviceEXT, 32> devices{};
    EGLint count = 0;
    if (query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count) != EGL_TRUE) return nullptr;
    for (const EGLDeviceEXT device : std::span(devices).first(static_cast<std::size_t>(count))) {
      const char* const extensions = query_string(device, EGL_EXTENSIONS);
      if (extensions != nullptr &&
          std::string_view(extensions).find("EGL_MESA_device_software") != std::string_view::npos)
        return device;
    }
    return nullptr;
  }

  void bind_opengl() {
    const auto bind = library_.function<decltype(&eglBindAPI)>("eglBindAPI");
    if (bind(EGL_OPENGL_API) != EGL_TRUE) throw RunError("EGL has no OpenGL");
  }

  // The display stays open: every user of the default display in this process shares it.
  void release() {
    make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    destroy_(display_, context_);
  }

  DynamicLibrary library_;
  decltype(&eglMakeCurrent) make_current_;
  decltype(&eglDestroyContext) destroy_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

// The used part of GL/osmesa.h, which conflicts with GL/glcorearb.h and was removed in Mesa 25.1.
using OSMesaContext = struct osmesa_context*;
using CreateContextAttribs = OSMesaContext (*)(const int* attributes, OSMesaContext shared);
using MakeCurrent = GLboolean (*)(OSMesaContext context, void* buffer, GLenum type, GLsizei width, GLsizei height);
using DestroyContext = void (*)(OSMesaContext context);
using GetProcAddress = void (*(*)(const char* name))();
constexpr int OSMESA_RGBA = GL_RGBA;
constexpr int OSMESA_FORMAT = 0x22;
constexpr int OSMESA_PROFILE = 0x33;
constexpr int OSMESA_CORE_PROFILE = 0x34;
constexpr int OSMESA_CONTEXT_MAJOR_VERSION = 0x36;
constexpr int OSMESA_CONTEXT_MINOR_VERSION = 0x37;

class OsmesaContext final : public OffscreenContext {
 public:
  OsmesaContext()
      : OffscreenContext(RenderContext::osmesa),
        library_({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}, "OSMesa"),
        make_current_(library_.function<MakeCurrent>("OSMesaMakeCurrent")),
        destroy_(library_.function<DestroyContext>("OSMesaDestroyContext")) {
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              4,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              5,
                              0};
    const auto create = library_.function<CreateContextAttribs>("OSMesaCreateContextAttribs");
    context_ = create(attributes, nullptr);
    if (context_ == nullptr) throw RunError("OSMesa cannot create an OpenGL 4.5 core context");
    try {
      make_current();
      const auto address = library_.function<GetProcAddress>("OSMesaGetProcAddress");
      gl_.load([address](const char* name) { return reinterpret_cast<void*>(address(name)); });
    } catch (...) {
      destroy_(context_);
      throw;
    }
  }

  OsmesaContext(const OsmesaContext&) = delete;
  OsmesaContext& operator=(const OsmesaContext&) = delete;
  ~OsmesaContext() override {
    make_current_(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
    destroy_(context_);
  }

  void make_current() override {
    if (make_current_(context_, backing_.data(), GL_UNSIGNED_BYTE, kBackingSide, kBackingSide) == 0) {
      throw RunError("OSMesa cannot make its context current");
    }
  }

 private:
  // OSMesa requires a colour buffer; nothing is rendered into it.
  static constexpr int kBackingSide = 16;

  DynamicLibrary library_;
  MakeCurrent make_current_;
  DestroyContext destroy_;
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, std::size_t{4} * kBackingSide * kBackingSide> backing_{};
};

}  // namespace

std::string OffscreenContext::description() const {
  const auto text = [this](GLenum name) {
    const GLubyte* const found = gl_.GetString(name);
    return std::string(found == nullptr ? "unknown" : reinterpret_cast<const char*>(found));
  };
  return std::string(name_of(kind_)) + ": " + text(GL_RENDERER) + ", " + text(GL_VERSION);
}

std::unique_ptr<OffscreenContext> make_egl_context() {
  return std::make_unique<EglContext>();
}

std::unique_ptr<OffscreenContext> make_osmesa_context() {
  return std::make_unique<OsmesaContext>();
}

std::unique_ptr<OffscreenContext> make_context(RenderContext wanted, std::string& fallback) {
  fallback.clear();
  const bool osmesa_first = wanted != RenderContext::egl;
  std::string first_reason;
  try {
    return osmesa_first ? make_osmesa_context() : make_egl_context();
  } catch (const RunError& error) {
    first_reason = error.what();
  }
  try {
    auto other = osmesa_first ? make_egl_context() : make_osmesa_context();
    if (wanted != RenderContext::automatic) {
      fallback = first_reason + "; rendering with " + (osmesa_first ? "egl" : "osmesa") + " instead";
    }
    return other;
  } catch (const RunError& error) {
    throw RunError("no off-screen OpenGL context: " + first_reason + "; " + error.what());
  }
}

}  // namespace reamsim
