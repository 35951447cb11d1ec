// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <span>
#include <string_view>
#include <utility>

namespace reamsim {
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
    if (extensions != nullptr &&
        std::string_view(extensions).find("EGL_MESA_device_software") != std::string_view::npos)
      return device;
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
  const auto bind = egl.function<decltype(&eglBindAPI)>("eglBindAPI");
  if (bind(EGL_OPENGL_API) != EGL_TRUE) throw RunError("EGL has no OpenGL");
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
constexpr int OSMESA_RGBA = GL_RGBA;
constexpr int OSMESA_FORMAT = 0x22;
constexpr int OSMESA_PROFILE = 0x33;
constexpr int OSMESA_CORE_PROFILE = 0x34;
constexpr int OSMESA_CONTEXT_MAJOR_VERSION = 0x36;
constexpr int OSMESA_CONTEXT_MINOR_VERSION = 0x37;

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
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            4,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            5,
                            0};
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
