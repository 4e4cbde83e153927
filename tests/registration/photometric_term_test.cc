#include "registration/photometric_term.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "registration/intensity_finder.h"
#include "registration/view_level.h"
#include "registration/wall_frames.h"

namespace surfit {
namespace {

using testing::WallFrames;

class PhotometricTermTest : public ::testing::Test {
 protected:
  PhotometricTermTest() { model_.photometric_weight = 0.01; }
  PhotometricTerm Term() const {
    return {Source(), frames_.target.levels[0], 0.1, model_, frames_.target_from_source};
  }
  const FrameLevel& Source() const { return frames_.source.levels[0]; }
  FrameLevel& Target() { return frames_.target.levels[0]; }

  WallFrames frames_{testing::AlongTheWall()};
  ErrorModel model_;
};

// Single precision: pixels are off by 1e-5 px, and intensities change by a tenth per px at most.
TEST_F(PhotometricTermTest, LooksUpWhereEachPointProjects) {
  const IntensityPairs pairs = Term().Collect(frames_.target_from_source);
  ASSERT_GT(pairs.size, 1000);
  for (int i = 0; i < pairs.size; ++i) {
    const Eigen::Vector3d p(pairs.px[i], pairs.py[i], pairs.pz[i]);
    const Eigen::Vector2d at = Target().camera.Project(p);
    const auto u = static_cast<float>(at.x()), v = static_cast<float>(at.y());
    const BilinearSample expected = SampleAt(Target().intensity, u, v);
    ASSERT_NEAR(pairs.target[i], expected.value, 1e-5);
    // Slopes jump where the four pixels change.
    if (std::abs(u - std::round(u)) < 1e-3 || std::abs(v - std::round(v)) < 1e-3) continue;
    ASSERT_NEAR(pairs.slope_u[i], expected.slope_u, 1e-5);
    ASSERT_NEAR(pairs.slope_v[i], expected.slope_v, 1e-5);
  }
}

TEST_F(PhotometricTermTest, TakesThePointsWhereIntensityChanges) {
  const FrameLevel& source = Source();
  const IntensityPairs pairs = Term().Collect(Rigid3d());
  int next = 0;
  for (int v = 1; v < 119; ++v) {
    for (int u = 1; u < 159; ++u) {
      const Image<float>& image = source.intensity;
      const double slope = std::hypot(image(u + 1, v) - image(u - 1, v),  //
                                      image(u, v + 1) - image(u, v - 1));
      const bool taken = next < pairs.size && pairs.px[next] == source.vertex.x(u, v) &&
                         pairs.py[next] == source.vertex.y(u, v);
      if (taken) ++next;
      if (std::abs(slope / 2 - model_.intensity_sigma) < 1e-6) continue;
      const bool known = source.normal.z(u, v) < 0 && Target().vertex.z(u, v) > 0;
      ASSERT_EQ(taken, known && slope / 2 > model_.intensity_sigma) << u << " " << v;
    }
  }
  EXPECT_EQ(next, pairs.size);
}

TEST_F(PhotometricTermTest, HiddenPointsAndUnknownColorsHaveNoSay) {
  const Rigid3d pose = frames_.target_from_source;
  const int all = Term().Collect(pose).size;
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 50; ++u) Target().vertex.z(u, v) -= 0.2f;
    for (int u = 110; u < 160; ++u) {
      Target().intensity(u, v) = std::numeric_limits<float>::quiet_NaN();
    }
  }
  const IntensityPairs pairs = Term().Collect(pose);
  EXPECT_GT(pairs.size, all / 5);
  for (int i = 0; i < pairs.size; ++i) {
    const double u = Target().camera.Project({pairs.px[i], pairs.py[i], pairs.pz[i]}).x();
    ASSERT_GT(u, 49.49);  // to the nearest pixel
    ASSERT_LT(u, 109.01);
  }
}

// Whatever the processor has.
TEST_F(PhotometricTermTest, InstructionsGiveTheSamePairs) {
  TexturedPoints points;
  for (int i = 0; i < 83; ++i) {
    const Eigen::Vector3f p = Source().vertex(20 + i, 50);
    points.x.push_back(p.x()), points.y.push_back(p.y()), points.z.push_back(p.z());
    points.intensity.push_back(Source().intensity(20 + i, 50));
  }
  const IntensitySearch search = {Target(), frames_.target_from_source, 0.1};
  IntensityPairs base, best;
  for (IntensityPairs* pairs : {&base, &best}) pairs->SetCapacity(100);
  const int count = WithInstructions([&](auto instructions) {
    return IntensityFinder<decltype(instructions)>(search).Find(points, 0, &best);
  });
  WithBaseInstructions([&](auto instructions) {
    EXPECT_EQ(IntensityFinder<decltype(instructions)>(search).Find(points, 0, &base), count);
  });
  EXPECT_EQ(count, 83);
  for (int k = 0; k < IntensityPairs::kArrays; ++k) {
    const auto &a = *base.Arrays()[k], &b = *best.Arrays()[k];
    EXPECT_TRUE(std::equal(a.begin(), a.begin() + count, b.begin())) << k;
  }
}

// Quartiles of thousands of points, resampled: to a few thousandths.
TEST_F(PhotometricTermTest, FindsTheExposure) {
  EXPECT_NEAR(Term().exposure().gain, 1, 0.02);
  EXPECT_NEAR(Term().exposure().offset, 0, 0.01);
  frames_.ChangeExposure(1.25f, -0.125f);
  EXPECT_NEAR(Term().exposure().gain, 0.8, 0.02);
  EXPECT_NEAR(Term().exposure().offset, 0.1, 0.01);
}

}  // namespace
}  // namespace surfit
