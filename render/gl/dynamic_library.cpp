#include "render/gl/dynamic_library.h"

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

}  // namespace reamsim
