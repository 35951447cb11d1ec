#include "render/gl/context.h"

#include "sim/base/error.h"

namespace reamsim {

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
    fallback = first_reason + "; pictures are drawn with " + (osmesa_first ? "egl" : "osmesa") + " instead";
    return other;
  } catch (const RunError& error) {
    throw RunError("no off-screen OpenGL context: " + first_reason + "; " + error.what());
  }
}

}  // namespace reamsim
