#include "common/render/testing/gl_visibility.h"

#define GL_GLEXT_PROTOTYPES 0
#include <GL/gl.h>
#include <GL/glext.h>
#include <dlfcn.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/core/error.h"

namespace periplus::render {
namespace {

// Functions of the library that the context lives in.
struct Gl {
  decltype(&glViewport) viewport;
  decltype(&glClearColor) clear_color;
  decltype(&glClear) clear;
  decltype(&glEnable) enable;
  decltype(&glDisable) disable;
  decltype(&glMatrixMode) matrix_mode;
  decltype(&glLoadMatrixf) load_matrix;
  decltype(&glLoadIdentity) load_identity;
  decltype(&glEnableClientState) enable_client_state;
  decltype(&glVertexPointer) vertex_pointer;
  decltype(&glColorPointer) color_pointer;
  decltype(&glDrawArrays) draw_arrays;
  decltype(&glReadPixels) read_pixels;
  decltype(&glShadeModel) shade_model;
  PFNGLGENFRAMEBUFFERSPROC gen_framebuffers;
  PFNGLBINDFRAMEBUFFERPROC bind_framebuffer;
  PFNGLGENRENDERBUFFERSPROC gen_renderbuffers;
  PFNGLBINDRENDERBUFFERPROC bind_renderbuffer;
  PFNGLRENDERBUFFERSTORAGEPROC renderbuffer_storage;
  PFNGLFRAMEBUFFERRENDERBUFFERPROC framebuffer_renderbuffer;
  PFNGLCHECKFRAMEBUFFERSTATUSPROC check_framebuffer_status;
  PFNGLDELETEFRAMEBUFFERSPROC delete_framebuffers;
  PFNGLDELETERENDERBUFFERSPROC delete_renderbuffers;

  explicit Gl(bool egl) {
    using Find = void* (*)(const char*);
    const auto find = reinterpret_cast<Find>(dlsym(RTLD_DEFAULT, egl ? "eglGetProcAddress" : "OSMesaGetProcAddress"));
    require(find != nullptr, ErrorCode::sim_render_failed, "no OpenGL functions are found; install libegl1 and libgl1-mesa-dri");
    const auto get = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(find(name));
      require(function != nullptr, ErrorCode::sim_render_failed, std::string("OpenGL lacks ") + name);
    };
    get(viewport, "glViewport");
    get(clear_color, "glClearColor");
    get(clear, "glClear");
    get(enable, "glEnable");
    get(disable, "glDisable");
    get(matrix_mode, "glMatrixMode");
    get(load_matrix, "glLoadMatrixf");
    get(load_identity, "glLoadIdentity");
    get(enable_client_state, "glEnableClientState");
    get(vertex_pointer, "glVertexPointer");
    get(color_pointer, "glColorPointer");
    get(draw_arrays, "glDrawArrays");
    get(read_pixels, "glReadPixels");
    get(shade_model, "glShadeModel");
    get(gen_framebuffers, "glGenFramebuffers");
    get(bind_framebuffer, "glBindFramebuffer");
    get(gen_renderbuffers, "glGenRenderbuffers");
    get(bind_renderbuffer, "glBindRenderbuffer");
    get(renderbuffer_storage, "glRenderbufferStorage");
    get(framebuffer_renderbuffer, "glFramebufferRenderbuffer");
    get(check_framebuffer_status, "glCheckFramebufferStatus");
    get(delete_framebuffers, "glDeleteFramebuffers");
    get(delete_renderbuffers, "glDeleteRenderbuffers");
  }
};

constexpr double kNear = 0.005, kFar = 100;  // [m]

}  // namespace

struct GlVisibility::Impl {
  const GlContext& context;
  voxel::GridGeometry geometry;
  const voxel::OccupancyGrid& grid;
  std::unique_ptr<Gl> gl;
  GLuint framebuffer = 0, buffers[2] = {0, 0};
  int width, height;
  std::vector<float> vertices;            // of quads, grid frame [voxels]
  std::vector<std::uint32_t> colors;      // voxel number + 1
  std::vector<std::uint32_t> picture, count;

  Impl(const GlContext& c, const voxel::OccupancyGrid& g) : context(c), geometry(g.geometry()), grid(g) {}
};

GlVisibility::GlVisibility(const GlContext& context, const voxel::OccupancyGrid& grid, int width, int height) : impl_(std::make_unique<Impl>(context, grid)) {
  Impl& m = *impl_;
  m.width = width;
  m.height = height;
  const Eigen::Vector3i n = m.geometry.size;
  const auto occupied = [&](const Eigen::Vector3i& v) { return m.geometry.contains(v) && grid.state(v) != voxel::VoxelState::empty; };
  for (int x = 0; x < n.x(); ++x) {
    for (int y = 0; y < n.y(); ++y) {
      for (int z = 0; z < n.z(); ++z) {
        const Eigen::Vector3i v(x, y, z);
        if (!occupied(v)) continue;
        for (int d = 0; d < 6; ++d) {
          const int axis = d / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
          Eigen::Vector3i neighbour = v;
          neighbour[axis] += d % 2 == 0 ? -1 : 1;
          if (occupied(neighbour)) continue;
          for (int corner : {0, 1, 3, 2}) {
            Eigen::Vector3i p = v;
            p[axis] += d % 2;
            p[a] += corner & 1;
            p[b] += corner >> 1;
            for (int i = 0; i < 3; ++i) m.vertices.push_back(static_cast<float>(p[i]));
            m.colors.push_back((static_cast<std::uint32_t>(x) * n.y() + y) * n.z() + z + 1);
          }
        }
      }
    }
  }
  m.picture.resize(static_cast<std::size_t>(width) * height);
  m.count.resize(static_cast<std::size_t>(n.x()) * n.y() * n.z() + 1);
  const GlContext::Current here(context);
  m.gl = std::make_unique<Gl>(context.backend() == "egl");
  m.gl->gen_framebuffers(1, &m.framebuffer);
  m.gl->bind_framebuffer(GL_FRAMEBUFFER, m.framebuffer);
  m.gl->gen_renderbuffers(2, m.buffers);
  const GLenum formats[2] = {GL_RGBA8, GL_DEPTH_COMPONENT32}, places[2] = {GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT};
  for (int i = 0; i < 2; ++i) {
    m.gl->bind_renderbuffer(GL_RENDERBUFFER, m.buffers[i]);
    m.gl->renderbuffer_storage(GL_RENDERBUFFER, formats[i], width, height);
    m.gl->framebuffer_renderbuffer(GL_FRAMEBUFFER, places[i], GL_RENDERBUFFER, m.buffers[i]);
  }
  require(m.gl->check_framebuffer_status(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE, ErrorCode::sim_render_failed, "OpenGL has no frame buffer of 32-bit colours");
  m.gl->enable(GL_DEPTH_TEST);
  m.gl->disable(GL_DITHER);
  m.gl->disable(GL_BLEND);
  m.gl->disable(GL_LIGHTING);
  m.gl->disable(GL_CULL_FACE);
  m.gl->shade_model(GL_FLAT);
}

GlVisibility::~GlVisibility() {
  const GlContext::Current here(impl_->context);
  impl_->gl->delete_renderbuffers(2, impl_->buffers);
  impl_->gl->delete_framebuffers(1, &impl_->framebuffer);
}

voxel::testing::RayCastView GlVisibility::evaluate(const Pose& X_WC, const Pinhole& camera) {
  Impl& m = *impl_;
  require(camera.width <= m.width && camera.height <= m.height, ErrorCode::bad_size, "the picture is larger than the frame buffer");
  const GlContext::Current here(m.context);
  const Gl& gl = *m.gl;
  gl.bind_framebuffer(GL_FRAMEBUFFER, m.framebuffer);
  gl.viewport(0, 0, camera.width, camera.height);
  gl.clear_color(0, 0, 0, 0);
  gl.clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  // Row r of the picture (from the top) is row r of the frame buffer: centres at r + 0.5 in the window.
  Eigen::Matrix4d P = Eigen::Matrix4d::Zero();
  P(0, 0) = 2 * camera.fx / camera.width;
  P(0, 2) = (2 * camera.cx + 1) / camera.width - 1;
  P(1, 1) = 2 * camera.fy / camera.height;
  P(1, 2) = (2 * camera.cy + 1) / camera.height - 1;
  P(2, 2) = (kFar + kNear) / (kFar - kNear);
  P(2, 3) = -2 * kFar * kNear / (kFar - kNear);
  P(3, 2) = 1;
  Eigen::Matrix4d X_CG = (X_WC.inverse() * m.geometry.X_WG).matrix();
  X_CG.leftCols<3>() *= m.geometry.voxel_size;
  const Eigen::Matrix4f M = (P * X_CG).cast<float>();
  gl.matrix_mode(GL_PROJECTION);
  gl.load_matrix(M.data());
  gl.matrix_mode(GL_MODELVIEW);
  gl.load_identity();
  gl.enable_client_state(GL_VERTEX_ARRAY);
  gl.enable_client_state(GL_COLOR_ARRAY);
  gl.vertex_pointer(3, GL_FLOAT, 0, m.vertices.data());
  gl.color_pointer(4, GL_UNSIGNED_BYTE, 0, m.colors.data());
  gl.draw_arrays(GL_QUADS, 0, static_cast<GLsizei>(m.colors.size()));
  gl.read_pixels(0, 0, camera.width, camera.height, GL_RGBA, GL_UNSIGNED_BYTE, m.picture.data());

  voxel::testing::RayCastView view;
  const Eigen::Vector3i n = m.geometry.size;
  const std::size_t pixels = static_cast<std::size_t>(camera.width) * camera.height;
  for (std::size_t i = 0; i < pixels; ++i) ++m.count[m.picture[i]];
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::uint32_t number = m.picture[i], seen = m.count[number];
    if (seen == 0 || number == 0) continue;
    m.count[number] = 0;
    const std::uint32_t voxel = number - 1;
    const std::uint32_t ny = static_cast<std::uint32_t>(n.y()), nz = static_cast<std::uint32_t>(n.z());
    switch (m.grid.state(Eigen::Vector3i(static_cast<int>(voxel / nz / ny), static_cast<int>(voxel / nz % ny), static_cast<int>(voxel % nz)))) {
      case voxel::VoxelState::unknown:
        view.unknown[voxel] = seen;
        break;
      case voxel::VoxelState::known:
        view.known += seen;
        break;
      default:
        view.environment += seen;
    }
  }
  m.count[0] = 0;
  return view;
}

}  // namespace periplus::render
