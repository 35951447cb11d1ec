#include "render/gl/gl.h"

#include <string>

#include "sim/base/error.h"

namespace reamsim {
namespace {

const char* error_name(GLenum code) {
  switch (code) {
    case GL_INVALID_ENUM:
      return "invalid enum";
    case GL_INVALID_VALUE:
      return "invalid value";
    case GL_INVALID_OPERATION:
      return "invalid operation";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "invalid framebuffer operation";
    case GL_OUT_OF_MEMORY:
      return "out of memory";
    default:
      return "unknown error";
  }
}

}  // namespace

void Gl::load(const std::function<void*(const char*)>& address) {
#define REAMSIM_GL_LOAD(name, type)                   \
  name = reinterpret_cast<type>(address("gl" #name)); \
  if (name == nullptr) throw RunError("this OpenGL has no function gl" #name);
  REAMSIM_GL_FUNCTIONS(REAMSIM_GL_LOAD)
#undef REAMSIM_GL_LOAD
}

void Gl::check(const char* doing) const {
  const GLenum code = GetError();
  if (code == GL_NO_ERROR) return;
  // A lost context would answer with errors for ever, so no more than a handful is drained.
  for (int i = 0; i < 16 && GetError() != GL_NO_ERROR; ++i) {
  }
  throw RunError(std::string("OpenGL failed while ") + doing + ": " + error_name(code));
}

}  // namespace reamsim
