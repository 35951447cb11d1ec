// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/gl.h"

#include <array>
#include <string>

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

}  // namespace reamsim
