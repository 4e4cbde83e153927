#include <gmock/gmock.h>

#include "io/image_sequence.h"

namespace surfit {
namespace {

using ::testing::HasSubstr;

// The warning about an image whose valid depth is mostly `count`, beside invalid codes.
std::string Warning(std::uint16_t count, double scale) {
  Image<std::uint16_t> depth(10, 10, count);
  for (int v = 0; v < 10; ++v) depth(0, v) = depth(1, v) = v < 5 ? 0 : 65535;
  depth(2, 0) = 1;
  return DepthScaleWarning(depth, scale, "d.png").value_or("");
}

TEST(DepthScaleWarning, IsSilentAboutUsualDepth) {
  EXPECT_EQ(Warning(1800, 1000), "");
  EXPECT_EQ(Warning(700, 1000), "");
  EXPECT_EQ(Warning(15000, 5000), "");
  EXPECT_EQ(Warning(13000, 6553.5), "");
}

TEST(DepthScaleWarning, TellsValueAndLikelyScale) {
  EXPECT_THAT(Warning(1800, 5000), HasSubstr("d.png is 0.36 m at 5000 units per metre; the scale "
                                             "is more likely 1000, which makes it 1.8 m"));
  EXPECT_THAT(Warning(18000, 1), HasSubstr("18000 m at 1 units per metre"));
}

TEST(DepthScaleWarning, TakesTumsDepthForTumsUpToFiveMetres) {
  for (const double depth_m : {1.2, 2.2, 3.5, 4.9}) {
    const auto count = static_cast<std::uint16_t>(5000 * depth_m);
    EXPECT_THAT(Warning(count, 1000), HasSubstr("more likely 5000, ")) << depth_m;
  }
  // 6.4 m at TUM's scale, 4.9 m at Replica's, 3.2 m in tenths of millimetres
  EXPECT_THAT(Warning(32000, 1000), HasSubstr("more likely 10000, "));
}

TEST(DepthScaleWarning, IsSilentWhereNoScaleFitsBetterUnlessAbsurd) {
  EXPECT_EQ(Warning(350, 1000), "");  // a desk close by
  EXPECT_NE(Warning(150, 1000), "");
}

TEST(DepthScaleWarning, NeedsCounts) {
  EXPECT_FALSE(DepthScaleWarning(Image<float>(4, 4, 1000.f), 5000, "d.tiff"));
  EXPECT_FALSE(DepthScaleWarning(Image<std::uint16_t>(4, 4, 0), 5000, "d.png"));
}

}  // namespace
}  // namespace surfit
