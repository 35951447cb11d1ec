#include <array>

#include "render/gl/context.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

// What is needed of GL/osmesa.h, which cannot stand beside GL/glcorearb.h and is gone from Mesa 25.1 on.
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
      : library_({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}, "OSMesa"),
        make_current_(library_.function<MakeCurrent>("OSMesaMakeCurrent")),
        destroy_(library_.function<DestroyContext>("OSMesaDestroyContext")) {
    const std::array attributes{OSMESA_FORMAT,
                                OSMESA_RGBA,
                                OSMESA_PROFILE,
                                OSMESA_CORE_PROFILE,
                                OSMESA_CONTEXT_MAJOR_VERSION,
                                4,
                                OSMESA_CONTEXT_MINOR_VERSION,
                                5,
                                0,
                                0};
    const auto create = library_.function<CreateContextAttribs>("OSMesaCreateContextAttribs");
    context_ = create(attributes.data(), nullptr);
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
  // OSMesa insists on a buffer of its own; nothing is drawn into it.
  static constexpr int kBackingSide = 16;

  DynamicLibrary library_;
  MakeCurrent make_current_;
  DestroyContext destroy_;
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, 4 * kBackingSide * kBackingSide> backing_{};
};

}  // namespace

std::unique_ptr<OffscreenContext> make_osmesa_context() {
  return std::make_unique<OsmesaContext>();
}

}  // namespace reamsim
