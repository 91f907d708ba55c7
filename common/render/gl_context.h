// An OpenGL context that needs neither display nor graphics card: EGL without surface, or Mesa's OSMesa where EGL fails.
#pragma once

#include <memory>
#include <string>

namespace periplus::render {

class GlContext {
 public:
  // `backend`: "egl", "osmesa", or "auto" for the first that works. `threads`: of Mesa's software rasteriser (LP_NUM_THREADS
  // in the environment goes before it; pictures do not depend on it). Throws Error(sim_render_failed) with the reasons.
  GlContext(const std::string& backend, int threads);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  const std::string& backend() const;

  // The context belongs to one thread at a time: to the one that holds this.
  class Current {
   public:
    explicit Current(const GlContext& context);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;

   private:
    const GlContext& context_;
  };

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::render
