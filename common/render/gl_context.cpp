#include "common/render/gl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <cstdlib>
#include <vector>

#include "common/core/error.h"

namespace periplus::render {
namespace {

// Both libraries are opened at run time, only the one that is used: MuJoCo takes its OpenGL functions from whichever it
// finds in the process. These are of EGL/egl.h and GL/osmesa.h.
struct Egl {
  decltype(&eglGetProcAddress) get_proc_address;
  decltype(&eglInitialize) initialize;
  decltype(&eglChooseConfig) choose_config;
  decltype(&eglBindAPI) bind_api;
  decltype(&eglCreateContext) create_context;
  decltype(&eglDestroyContext) destroy_context;
  decltype(&eglMakeCurrent) make_current;
};
using OsMesaCreate = void* (*)(unsigned format, int depth, int stencil, int accumulation, void* share);
using OsMesaMake = unsigned char (*)(void* context, void* buffer, unsigned type, int width, int height);
using OsMesaDestroy = void (*)(void* context);
constexpr unsigned kGlRgba = 0x1908, kGlUnsignedByte = 0x1401;
constexpr int kOsMesaSide = 16;  // MuJoCo draws into a frame buffer of its own

}  // namespace

struct GlContext::Impl {
  std::string backend;
  Egl f{};
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext egl = EGL_NO_CONTEXT;
  void* osmesa = nullptr;
  OsMesaMake osmesa_make = nullptr;
  OsMesaDestroy osmesa_destroy = nullptr;
  std::vector<unsigned char> buffer;

  template <class Function>
  static bool find(void* library, const char* name, Function& function) {
    function = reinterpret_cast<Function>(dlsym(library, name));
    return function != nullptr;
  }

  // Each returns why it failed, or nothing.
  std::string open_egl() {
    void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_GLOBAL);
    if (!library) return "libEGL is not installed (package libegl1)";
    if (!find(library, "eglGetProcAddress", f.get_proc_address) || !find(library, "eglInitialize", f.initialize) ||
        !find(library, "eglChooseConfig", f.choose_config) || !find(library, "eglBindAPI", f.bind_api) ||
        !find(library, "eglCreateContext", f.create_context) || !find(library, "eglDestroyContext", f.destroy_context) ||
        !find(library, "eglMakeCurrent", f.make_current))
      return "libEGL lacks its functions";
    const auto get_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(f.get_proc_address("eglGetPlatformDisplayEXT"));
    if (get_display) display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display == EGL_NO_DISPLAY) return "EGL knows no surfaceless platform";
    if (!f.initialize(display, nullptr, nullptr)) return "eglInitialize failed";
    const EGLint attributes[] = {EGL_RED_SIZE, 8, EGL_GREEN_SIZE, 8, EGL_BLUE_SIZE, 8, EGL_DEPTH_SIZE, 24, EGL_SURFACE_TYPE, EGL_PBUFFER_BIT,
                                 EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (!f.choose_config(display, attributes, &config, 1, &count) || count < 1) return "EGL has no configuration with OpenGL";
    if (!f.bind_api(EGL_OPENGL_API)) return "EGL has no OpenGL";
    egl = f.create_context(display, config, EGL_NO_CONTEXT, nullptr);
    if (egl == EGL_NO_CONTEXT) return "eglCreateContext failed";
    if (!f.make_current(display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl)) return "eglMakeCurrent failed";
    f.make_current(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    return "";
  }

  std::string open_osmesa() {
    void* library = nullptr;
    for (const char* name : {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"})
      if ((library = dlopen(name, RTLD_NOW | RTLD_GLOBAL))) break;
    if (!library) return "libOSMesa is not installed (package libosmesa6)";
    OsMesaCreate create = nullptr;
    if (!find(library, "OSMesaCreateContextExt", create) || !find(library, "OSMesaMakeCurrent", osmesa_make) ||
        !find(library, "OSMesaDestroyContext", osmesa_destroy))
      return "libOSMesa lacks its functions";
    osmesa = create(kGlRgba, 24, 8, 8, nullptr);
    if (!osmesa) return "OSMesaCreateContextExt failed";
    buffer.resize(std::size_t{4} * kOsMesaSide * kOsMesaSide);
    if (!osmesa_make(osmesa, buffer.data(), kGlUnsignedByte, kOsMesaSide, kOsMesaSide)) return "OSMesaMakeCurrent failed";
    osmesa_make(nullptr, nullptr, 0, 0, 0);
    return "";
  }

  ~Impl() {
    if (osmesa) osmesa_destroy(osmesa);
    if (egl != EGL_NO_CONTEXT) f.destroy_context(display, egl);
    // The display is shared by the whole process; it goes with it.
  }
};

GlContext::GlContext(const std::string& backend, int threads) : impl_(std::make_unique<Impl>()) {
  require(backend == "auto" || backend == "egl" || backend == "osmesa", ErrorCode::bad_input,
          "render backend \"" + backend + "\": auto, egl or osmesa is expected");
  setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 0);
  std::string reasons;
  if (backend != "osmesa") {
    const std::string why = impl_->open_egl();
    if (why.empty()) {
      impl_->backend = "egl";
      return;
    }
    reasons = why;
  }
  if (backend != "egl") {
    const std::string why = impl_->open_osmesa();
    if (why.empty()) {
      impl_->backend = "osmesa";
      return;
    }
    reasons += (reasons.empty() ? "" : "; ") + why;
  }
  throw_error(ErrorCode::sim_render_failed, "no way to draw without a display: " + reasons + ". Install libegl1 and libgl1-mesa-dri");
}

GlContext::~GlContext() = default;

const std::string& GlContext::backend() const { return impl_->backend; }

GlContext::Current::Current(const GlContext& context) : context_(context) {
  Impl& c = *context.impl_;
  const bool done = c.osmesa ? c.osmesa_make(c.osmesa, c.buffer.data(), kGlUnsignedByte, kOsMesaSide, kOsMesaSide) != 0
                             : c.f.make_current(c.display, EGL_NO_SURFACE, EGL_NO_SURFACE, c.egl) == EGL_TRUE;
  require(done, ErrorCode::sim_render_failed, "the drawing context cannot be used by this thread; another one holds it");
}

GlContext::Current::~Current() {
  Impl& c = *context_.impl_;
  if (c.osmesa)
    c.osmesa_make(nullptr, nullptr, 0, 0, 0);
  else
    c.f.make_current(c.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

}  // namespace periplus::render
