#include "common/render/gl_context.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/core/error.h"

namespace periplus::render {
namespace {

TEST(GlContext, MayChangeThreadsButNotBeShared) {
  const GlContext context("auto", 1);
  EXPECT_TRUE(context.backend() == "egl" || context.backend() == "osmesa");
  { const GlContext::Current here(context); }
  std::thread([&] { EXPECT_NO_THROW(GlContext::Current{context}); }).join();
  if (context.backend() != "egl") return;
  const GlContext::Current here(context);
  std::thread([&] { EXPECT_THROW(GlContext::Current{context}, Error); }).join();
}

TEST(GlContext, UnknownBackendIsRefused) { EXPECT_THROW(GlContext("directx", 1), Error); }

}  // namespace
}  // namespace periplus::render
