#pragma once

#include <initializer_list>
#include <string>

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

}  // namespace reamsim
