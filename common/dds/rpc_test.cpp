#include "common/dds/rpc.h"

#include <gtest/gtest.h>

namespace periplus::dds {
namespace {

ErrorCode code_of(const RpcResult& result) {
  try {
    result.throw_if_failed("vision/capture");
  } catch (const Error& error) {
    EXPECT_FALSE(std::string(error.what()).empty());
    return error.code();
  }
  return ErrorCode::ok;
}

TEST(RpcResult, BecomesTheErrorThatItStandsFor) {
  EXPECT_EQ(code_of({}), ErrorCode::ok);
  EXPECT_EQ(code_of({.status = RpcStatus::ok, .error_code = 401, .error_message = "no posture", .resends = 0}), ErrorCode::posture_infeasible);
  for (const RpcStatus status : {RpcStatus::no_server, RpcStatus::server_lost, RpcStatus::timeout}) {
    const RpcResult result{.status = status, .error_code = 0, .error_message = "", .resends = 0};
    EXPECT_FALSE(result.ok());
    EXPECT_EQ(code_of(result), ErrorCode::supervisor_service_lost);
    try {
      result.throw_if_failed("vision/capture");
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("vision/capture"), std::string::npos);
      EXPECT_NE(std::string(error.what()).find(to_string(status)), std::string::npos);
    }
  }
  EXPECT_EQ(code_of({.status = RpcStatus::cancelled, .error_code = 6, .error_message = "", .resends = 0}), ErrorCode::cancelled);
}

}  // namespace
}  // namespace periplus::dds
