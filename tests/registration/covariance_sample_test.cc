#include "registration/covariance_sample.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"
#include "surfit/registration/icp.h"
#include "surfit/simulation/render.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

constexpr int kCount = 3000;

PinholeCamera Camera() { return {160, 120, 131, 131, 79.5, 59.5, {}}; }

// A wall that a few small boxes, turned in all directions, stand on: most points tell nothing of
// the motion along it.
Scene WallWithBoxes() {
  Scene scene;
  const auto grey = [](const Eigen::Vector3d&) { return Eigen::Vector3f(0.5, 0.5, 0.5); };
  Eigen::Matrix3d towards_camera;
  towards_camera << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  scene.Add(MakeHalfSpace(), Rigid3d(Eigen::Quaterniond(towards_camera), {0, 0, 2}), grey);
  for (int i = 0; i < 3; ++i) {
    const auto turn = QuaternionExp<double>({0.5 + 0.2 * i, 0.7 - 0.5 * i, 0.3});
    scene.Add(MakeBox({0.15, 0.15, 0.15}), Rigid3d(turn, {-0.5 + 0.5 * i, 0.4 - 0.3 * i, 1.95}),
              grey);
  }
  return scene;
}

FramePyramid View(const Rigid3d& pose) {
  return PreprocessDepth(RenderGeometry(WallWithBoxes(), Camera(), pose).depth_m, Camera(), {});
}

const FrameLevel& Wall() {
  static const auto* const level = new FrameLevel(View(Rigid3d()).levels[0]);
  return *level;
}

// Sum of c c' over some points.
struct Held {
  Matrix6d covariance = Matrix6d::Zero();
  int count = 0;
};

Held HeldBy(const FrameLevel& level, int stride = 1) {
  Held held;
  for (std::size_t i = 0; i < level.vertex.z.size(); i += stride) {
    const Eigen::Vector3d p(level.vertex.x[i], level.vertex.y[i], level.vertex.z[i]);
    const Eigen::Vector3d n(level.normal.x[i], level.normal.y[i], level.normal.z[i]);
    if (n.z() == 0) continue;
    Vector6d row;
    row << p.cross(n), n;
    held.covariance += row * row.transpose();
    ++held.count;
  }
  return held;
}

double WeakestPerPoint(const Held& held) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(held.covariance).eigenvalues()[0] / held.count;
}

TEST(CovarianceSample, HasAboutAsManyPointsAsAskedFor) {
  const std::optional<FrameLevel> sample = CovarianceSample(Wall(), kCount);
  ASSERT_TRUE(sample);
  // Chances above one are cut, and a row's last fraction of a point is lost.
  EXPECT_LT(HeldBy(*sample).count, 1.05 * kCount);
  EXPECT_GT(HeldBy(*sample).count, 0.7 * kCount);
}

TEST(CovarianceSample, PointsAreThoseOfTheLevelInTheirOrder) {
  const FrameLevel sample = *CovarianceSample(Wall(), kCount);
  std::size_t at = 0;
  for (std::size_t i = 0; i < sample.vertex.z.size() && sample.vertex.z[i] > 0; ++i, ++at) {
    while (at < Wall().vertex.z.size() && (Wall().vertex.x[at] != sample.vertex.x[i] ||
                                           Wall().vertex.y[at] != sample.vertex.y[i])) {
      ++at;
    }
    ASSERT_LT(at, Wall().vertex.z.size()) << i;
    EXPECT_EQ(sample.normal.z[i], Wall().normal.z[at]);
  }
}

// An even choice leaves a direction what it has. The half of the sample that goes by leverage
// holds the weakest direction with a sixth of its points rather than with the few it has.
TEST(CovarianceSample, HoldsTheWeakestDirectionWithMoreOfItsPoints) {
  const double all = WeakestPerPoint(HeldBy(Wall()));
  const double even = WeakestPerPoint(HeldBy(Wall(), 6));
  const double sample = WeakestPerPoint(HeldBy(*CovarianceSample(Wall(), kCount)));
  EXPECT_LT(even, 1.3 * all);
  EXPECT_GT(sample, 1.5 * all);
}

TEST(CovarianceSample, IsNothingWhereThereAreNoMorePoints) {
  EXPECT_FALSE(CovarianceSample(Wall(), 160 * 120));
  FrameLevel empty = Wall();
  empty.vertex = empty.normal = VectorImage(160, 120);
  EXPECT_FALSE(CovarianceSample(empty, kCount));
}

TEST(CovarianceSample, IsTheSameAtAnyNumberOfThreads) {
  const ThreadLimit one(1);
  const FrameLevel alone = *CovarianceSample(Wall(), kCount);
  const ThreadLimit four(4);
  EXPECT_EQ(CovarianceSample(Wall(), kCount)->vertex.z, alone.vertex.z);
}

// Exact depth holds the pose to half a pixel, 1 / 131 rad and 15 mm at the wall.
TEST(CovarianceSample, RegistersAsExactly) {
  const Rigid3d motion(QuaternionExp<double>({0.01, -0.02, 0.01}), {0.02, 0.01, -0.01});
  IcpOptions options;
  options.max_source_points = kCount;
  const IcpResult result = Register(View(motion), View(Rigid3d()), Rigid3d(), options);
  EXPECT_TRUE(result.Succeeded()) << ToString(result.termination);
  EXPECT_LE(result.inlier_count, kCount);
  EXPECT_THAT(result.target_from_source, testing::RigidNear(motion, 0.0075, 0.0038));
}

}  // namespace
}  // namespace surfit
