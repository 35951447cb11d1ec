#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>

#include "render/gl/context.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

class EglContext final : public OffscreenContext {
 public:
  EglContext()
      : library_({"libEGL.so.1", "libEGL.so"}, "EGL"),
        make_current_(library_.function<decltype(&eglMakeCurrent)>("eglMakeCurrent")),
        destroy_(library_.function<decltype(&eglDestroyContext)>("eglDestroyContext")) {
    open_display();
    create_context();
    try {
      make_current();
      const auto address = library_.function<decltype(&eglGetProcAddress)>("eglGetProcAddress");
      gl_.load([address](const char* name) { return reinterpret_cast<void*>(address(name)); });
    } catch (...) {
      release();
      throw;
    }
  }

  ~EglContext() override { release(); }

  void make_current() override {
    // The bound API belongs to the thread, and OpenGL ES is its default.
    bind_opengl();
    if (make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
      throw RunError("EGL cannot make its context current without a surface");
    }
  }

 private:
  void open_display() {
    const auto get_display = library_.function<decltype(&eglGetPlatformDisplay)>("eglGetPlatformDisplay");
    const auto initialize = library_.function<decltype(&eglInitialize)>("eglInitialize");
    display_ = get_display(EGL_PLATFORM_SURFACELESS_MESA, reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY), nullptr);
    if (display_ == EGL_NO_DISPLAY) throw RunError("EGL has no surfaceless platform (Mesa's)");
    EGLint major = 0;
    EGLint minor = 0;
    if (initialize(display_, &major, &minor) != EGL_TRUE) {
      throw RunError("EGL cannot initialize its surfaceless platform");
    }
  }

  void create_context() {
    bind_opengl();
    const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
    const auto choose = library_.function<decltype(&eglChooseConfig)>("eglChooseConfig");
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (choose(display_, wanted.data(), &config, 1, &count) != EGL_TRUE || count == 0) {
      throw RunError("EGL has no configuration for OpenGL");
    }
    const std::array<EGLint, 7> attributes{
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    const auto create = library_.function<decltype(&eglCreateContext)>("eglCreateContext");
    context_ = create(display_, config, EGL_NO_CONTEXT, attributes.data());
    if (context_ == EGL_NO_CONTEXT) throw RunError("EGL cannot create an OpenGL 4.5 core context");
  }

  void bind_opengl() {
    const auto bind = library_.function<decltype(&eglBindAPI)>("eglBindAPI");
    if (bind(EGL_OPENGL_API) != EGL_TRUE) throw RunError("EGL has no OpenGL");
  }

  // The display is left open: it is shared by every user of the default display in this process.
  void release() {
    make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    destroy_(display_, context_);
  }

  DynamicLibrary library_;
  decltype(&eglMakeCurrent) make_current_;
  decltype(&eglDestroyContext) destroy_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::unique_ptr<OffscreenContext> make_egl_context() {
  return std::make_unique<EglContext>();
}

}  // namespace reamsim
