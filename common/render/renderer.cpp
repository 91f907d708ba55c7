#include "common/render/renderer.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>

#include "common/core/error.h"
#include "common/render/gl_context.h"
#include "common/render/world_builder.h"
#include "common/robot/mujoco_model.h"

namespace periplus::render {
namespace {

constexpr int kMostGeoms = 2000;

struct DeleteData {
  void operator()(mjData* d) const { mj_deleteData(d); }
};
robot::MjModelPtr compile(const World& world) {
  robot::MjModelPtr model = robot::compile_mjcf(world.xml, world.meshes, ErrorCode::sim_scene_bad);
  for (const auto& [name, picture] : world.textures) {
    const int id = mj_name2id(model.get(), mjOBJ_TEXTURE, name.c_str());
    PERIPLUS_ASSERT(id >= 0 && model->tex_width[id] == picture.width && model->tex_height[id] == picture.height);
    std::memcpy(model->tex_rgb + model->tex_adr[id], picture.data.data(), picture.data.size());
  }
  return model;
}

}  // namespace

struct Renderer::Impl {
  RendererOptions options;
  robot::MjModelPtr model;
  std::unique_ptr<mjData, DeleteData> data;
  GlContext gl;
  mjvScene scene{};
  mjvOption visual{};
  mjvCamera free_camera{};
  mjrContext context{};
  std::mutex mutex;

  Impl(const scene::Scene& world, const std::vector<TrueObject>& objects, const RendererOptions& o)
      : options(o), model(compile(build_world(world, objects, o))), data(mj_makeData(model.get())), gl(o.backend, o.threads) {
    mj_forward(model.get(), data.get());
    const GlContext::Current current(gl);
    mjv_defaultScene(&scene);
    mjv_defaultOption(&visual);
    mjv_defaultCamera(&free_camera);
    mjr_defaultContext(&context);
    mjv_makeScene(model.get(), &scene, kMostGeoms);
    mjr_makeContext(model.get(), &context, mjFONTSCALE_50);
    mjr_setBuffer(mjFB_OFFSCREEN, &context);
    require(context.currentBuffer == mjFB_OFFSCREEN, ErrorCode::sim_render_failed, "there is no off-screen frame buffer to draw into");
    for (const int flag : {mjRND_SHADOW, mjRND_REFLECTION, mjRND_SKYBOX, mjRND_FOG, mjRND_HAZE, mjRND_CULL_FACE})
      scene.flags[flag] = 0;  // open meshes are seen from both sides
    mjv_updateScene(model.get(), data.get(), &visual, nullptr, &free_camera, mjCAT_ALL, &scene);
  }

  ~Impl() {
    const GlContext::Current current(gl);
    mjr_freeContext(&context);
    mjv_freeScene(&scene);
  }

  void place_camera(const Pose& X_WC, const Pinhole& camera) {
    const double pixel = options.near_m / camera.fx;  // pixel centres stand at integers, so edges at halves
    for (mjvGLCamera& c : scene.camera) {
      for (int i = 0; i < 3; ++i) {
        c.pos[i] = static_cast<float>(X_WC.translation()[i]);
        c.forward[i] = static_cast<float>(X_WC.linear()(i, 2));
        c.up[i] = static_cast<float>(-X_WC.linear()(i, 1));
      }
      c.frustum_near = static_cast<float>(options.near_m);
      c.frustum_far = static_cast<float>(options.far_m);
      c.frustum_top = static_cast<float>((camera.cy + 0.5) * pixel);
      c.frustum_bottom = static_cast<float>((camera.cy + 0.5 - camera.height) * pixel);
      c.frustum_center = static_cast<float>((0.5 * (camera.width - 1) - camera.cx) * pixel);
    }
  }
};

Renderer::Renderer(const scene::Scene& scene, const std::vector<TrueObject>& objects, const RendererOptions& options)
    : impl_([&] {
        const robot::MujocoErrors errors(ErrorCode::sim_render_failed);
        return std::make_unique<Impl>(scene, objects, options);
      }()) {}

Renderer::~Renderer() = default;

const std::string& Renderer::backend() const { return impl_->gl.backend(); }

RenderedView Renderer::render(const Pose& X_WC, const Pinhole& camera) {
  camera.check();
  require(std::abs(camera.fx - camera.fy) <= 1e-9 * camera.fx, ErrorCode::bad_input, "render: pixels must be square (fx equal to fy)");
  require(camera.width <= impl_->options.max_width && camera.height <= impl_->options.max_height, ErrorCode::bad_size,
          "render: pictures of at most " + std::to_string(impl_->options.max_width) + " x " + std::to_string(impl_->options.max_height) +
              " pixels are possible with these options");
  require(is_finite(X_WC), ErrorCode::not_finite, "render: the camera pose is not finite");
  const robot::MujocoErrors errors(ErrorCode::sim_render_failed);
  const std::lock_guard lock(impl_->mutex);
  const GlContext::Current current(impl_->gl);
  impl_->place_camera(X_WC, camera);
  const mjrRect viewport{0, 0, camera.width, camera.height};
  mjr_render(viewport, &impl_->scene, &impl_->context);

  ImageU8 bottom_up(camera.width, camera.height, 3);
  ImageF window(camera.width, camera.height);
  mjr_readPixels(bottom_up.data.data(), window.data.data(), viewport, &impl_->context);
  RenderedView view{ImageU8(camera.width, camera.height, 3), ImageF(camera.width, camera.height)};
  const double near = impl_->options.near_m, far = impl_->options.far_m;
  const std::size_t row = static_cast<std::size_t>(camera.width) * 3;
  for (int y = 0; y < camera.height; ++y) {
    const int from = camera.height - 1 - y;
    std::memcpy(&view.colour.data[static_cast<std::size_t>(y) * row], &bottom_up.data[static_cast<std::size_t>(from) * row], row);
    for (int x = 0; x < camera.width; ++x) {
      const double w = window.at(x, from);
      view.depth.at(x, y) = w < 1 ? static_cast<float>(near * far / (far - w * (far - near))) : 0.0f;
    }
  }
  return view;
}

}  // namespace periplus::render
