#include "render/gl/context.h"

#include <dlfcn.h>

#include "sim/base/error.h"

namespace reamsim {

DynamicLibrary::DynamicLibrary(std::initializer_list<const char*> names, const std::string& purpose) {
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

void* DynamicLibrary::symbol(const char* name) const {
  void* found = dlsym(handle_, name);
  if (found == nullptr) throw RunError(name_ + " has no function " + name);
  return found;
}

std::unique_ptr<OffscreenContext> make_context(RenderContext wanted, std::string& fallback) {
  fallback.clear();
  const bool osmesa_first = wanted == RenderContext::osmesa;
  std::string first_reason;
  try {
    return osmesa_first ? make_osmesa_context() : make_egl_context();
  } catch (const RunError& error) {
    first_reason = error.what();
  }
  try {
    auto other = osmesa_first ? make_egl_context() : make_osmesa_context();
    fallback = first_reason + "; rendering with " + (osmesa_first ? "egl" : "osmesa") + " instead";
    return other;
  } catch (const RunError& error) {
    throw RunError("no off-screen OpenGL context: " + first_reason + "; " + error.what());
  }
}

}  // namespace reamsim
