#pragma once

#include <initializer_list>
#include <memory>
#include <string>

#include "render/gl/gl.h"
#include "sim/scenario/choices.h"

namespace reamsim {

/// A shared library opened at run time, so that a machine without it can still run the rest of the program.
/// It stays loaded until the process ends: Mesa keeps thread-local state and exit handlers that do not survive dlclose.
class DynamicLibrary {
 public:
  /// Opens the first of `names` that can be loaded. Throws RunError, saying what `purpose` is, when none can.
  DynamicLibrary(std::initializer_list<const char*> names, const std::string& purpose);

  /// The function called `name`, as a pointer of type F. Throws RunError when the library has none.
  template <typename F>
  [[nodiscard]] F function(const char* name) const {
    return reinterpret_cast<F>(symbol(name));
  }

 private:
  [[nodiscard]] void* symbol(const char* name) const;

  void* handle_ = nullptr;
  std::string name_;
};

/// An OpenGL 4.5 core context without a window, current on the thread that made it for as long as it lives.
/// Pictures are drawn into framebuffer objects, so the context itself has no size.
class OffscreenContext {
 public:
  virtual ~OffscreenContext() = default;
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  /// The OpenGL functions of this context.
  [[nodiscard]] const Gl& gl() const { return gl_; }
  /// Makes this context current on the calling thread, after another one was.
  virtual void make_current() = 0;

 protected:
  OffscreenContext() = default;
  Gl gl_;
};

/// Mesa's software rasteriser through libOSMesa. Throws RunError: no library, no OpenGL 4.5.
std::unique_ptr<OffscreenContext> make_osmesa_context();

/// EGL on Mesa's surfaceless platform. Throws RunError: no library, no such platform, no OpenGL 4.5.
std::unique_ptr<OffscreenContext> make_egl_context();

/// The context that is `wanted`. When the machine has no such context and the other one works, that one
/// is made, and `fallback` says so (empty otherwise); the two give the same pictures on Mesa.
/// Throws RunError (naming both reasons) when neither works.
std::unique_ptr<OffscreenContext> make_context(RenderContext wanted, std::string& fallback);

}  // namespace reamsim
