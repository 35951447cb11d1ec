// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <dlfcn.h>

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>

#include "render/gl/gl_objects.h"
#include "sim/base/error.h"
#include "sim/scenario/choices.h"

namespace reamsim {

/// A shared library opened at run time, so that the program runs without it. It stays loaded until the process ends:
/// Mesa has thread-local state and exit handlers that do not survive dlclose.
class DynamicLibrary {
 public:
  /// Opens the first of `names` that can be loaded. Throws RunError, naming the `purpose`, when none can.
  DynamicLibrary(std::initializer_list<const char*> names, const std::string& purpose) {
    std::string tried;
    for (const char* name : names) {
      handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
      if (handle_ != nullptr) {
        name_ = name;
        return;
      }
      tried += (tried.empty() ? "" : ", ") + std::string(name);
    }
    throw RunError(purpose + " cannot be used: none of " + tried + " can be loaded");
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
