#include "common/scene/environment_texts.h"

#include <gtest/gtest.h>

#include "common/core/hash.h"

namespace periplus::scene {
namespace {

TEST(EnvironmentTexts, RevisionIsOfAllThreeTextsAndOfWhereTheyEnd) {
  EXPECT_EQ(hash_of_texts({"ab", "c"}), sha256_hex("2\nab1\nc"));
  EXPECT_NE(hash_of_texts({"ab", "c"}), hash_of_texts({"a", "bc"}));
  const EnvironmentTexts texts{"room", "scene", "robot", "urdf"};
  const std::string revision = environment_revision(texts);
  EXPECT_EQ(revision, hash_of_texts({"scene", "robot", "urdf"}));
  EXPECT_EQ(environment_revision({"another name", "scene", "robot", "urdf"}), revision);
  EXPECT_NE(environment_revision({"room", "scene ", "robot", "urdf"}), revision);
  EXPECT_NE(environment_revision({"room", "scene", "robot ", "urdf"}), revision);
  EXPECT_NE(environment_revision({"room", "scene", "robot", "urdf "}), revision);
}

}  // namespace
}  // namespace periplus::scene
