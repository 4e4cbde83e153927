#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/slam_tool.h"

namespace surfit::testing {
namespace {

using ::testing::HasSubstr;

TEST_F(SlamTool, TakesFramesAsACameraOffersThem) {
  constexpr double kSlowFps = 2;  // that a busy machine keeps up with under sanitizers
  ASSERT_EQ(Slam(Room(), Output("free")).exit_code, 0);
  const ProgramResult result =
      Slam(Room(), Output(), {"--offered_fps=" + std::to_string(kSlowFps)});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("latency"));
  const nlohmann::json summary = Summary(Output()), free = Summary(Output("free"));
  EXPECT_EQ(summary["frames_dropped"], 0);
  EXPECT_EQ(summary["digest"], free["digest"]);
  EXPECT_GE(summary["total_s"], (kFrames - 1) / kSlowFps);
  EXPECT_LT(summary["frame_ms"]["median"], 1e3 / kSlowFps);  // without waiting
  EXPECT_GT(summary["latency_ms"]["median"], 0);
  EXPECT_TRUE(free["latency_ms"].is_null());
}

TEST_F(SlamTool, CountsFramesThatAreNotTakenInTime) {
  ASSERT_EQ(Slam(Room(), Output(), {"--offered_fps=100000"}).exit_code, 0);
  const nlohmann::json summary = Summary(Output());
  EXPECT_GT(summary["frames_dropped"], 0);
  EXPECT_EQ(summary["frames_dropped"].get<int>() + summary["frames_total"].get<int>(), kFrames);
}

}  // namespace
}  // namespace surfit::testing
