#include "registration/row_finder.h"

#include <gtest/gtest.h>

#include "surfit/frame/preprocess.h"
#include "surfit/registration/projective_association.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"

namespace surfit {
namespace {

// Rows of 83 pixels: ten times eight lanes and three.
constexpr PinholeCamera kCamera = {83, 60, 70, 70, 41, 29.5, {}};

class RowFinderTest : public ::testing::Test {
 protected:
  RowFinderTest() {
    const Scene scene = MakeScene("room", 1);
    const Trajectory path = MakePath(scene, 10, 1);
    const auto view = [&](int i) {
      return PreprocessDepth(RenderFrame(scene, kCamera, path[i].world_from_camera).depth_m,
                             {kCamera, {}}, PreprocessOptions())
          .levels[0];
    };
    source_ = view(0);
    target_ = view(9);
    pose_ = path[9].world_from_camera.Inverse() * path[0].world_from_camera;
  }
  ProjectiveSearch Search() const {
    return {source_, target_, pose_, gates_, error_model_, NeededNormals::kBoth};
  }
  ProjectiveAssociation Association() const {
    return {source_, target_, gates_, error_model_, NeededNormals::kBoth};
  }

  FrameLevel source_, target_;
  Rigid3d pose_;
  AssociationGates gates_;
  ErrorModel error_model_;
};

// Whatever the processor has: pairs are the same bit for bit, and in the same order.
TEST_F(RowFinderTest, InstructionsGiveTheSamePairs) {
  const ProjectiveAssociation association = Association();
  const auto finder = association.At(pose_);
  PairBuffer base, best;
  base.SetCapacity(association.block_capacity());
  best.SetCapacity(association.block_capacity());
  int pairs = 0;
  for (int v = 0; v < kCamera.height; ++v) {
    const int count = finder->Find(v, 0, &best);
    WithBaseInstructions([&](auto instructions) {
      ASSERT_EQ(RowFinder<decltype(instructions)>(Search()).Find(v, 0, &base), count);
    });
    for (int k = 0; k < PairBuffer::kArrays; ++k) {
      const auto &a = *base.Arrays()[k], &b = *best.Arrays()[k];
      EXPECT_TRUE(std::equal(a.begin(), a.begin() + count, b.begin())) << v << " " << k;
    }
    pairs += count;
  }
  EXPECT_GT(pairs, kCamera.width * kCamera.height / 2);
}

// In double precision, by the header's words. Which pixel or gate a point just misses is a matter
// of rounding: 1e-6 of a hundred pixels or of a sigma.
TEST_F(RowFinderTest, FindsThePairsThatTheDefinitionHas) {
  const PairBuffer found = Association().Collect(pose_);
  int next = 0, expected = 0, doubtful = 0;
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const Eigen::Vector3d s = source_.vertex(u, v).cast<double>();
      const Eigen::Vector3d m = pose_.rotation * source_.normal(u, v).cast<double>();
      if (!(s.z() > 0) || m.isZero(0)) continue;
      const Eigen::Vector3d p = pose_ * s;
      const double x = kCamera.fx * p.x() / p.z() + kCamera.cx + 0.5;
      const double y = kCamera.fy * p.y() / p.z() + kCamera.cy + 0.5;
      if (!(p.z() > 0) || x < 0 || y < 0 || x >= kCamera.width || y >= kCamera.height) continue;
      const Eigen::Vector3d q = target_.vertex(x, y).cast<double>();
      const Eigen::Vector3d n = target_.normal(x, y).cast<double>();
      const double distance_m = (p - q).norm(), cosine = m.dot(n);
      const double min_cosine = std::cos(gates_.max_normal_angle_rad);
      if (!(q.z() > 0) || n.isZero(0)) continue;
      if (distance_m > gates_.max_distance_m || cosine < min_cosine) continue;
      ++expected;
      if (next < found.size && (found.p(next).cast<double>() - p).norm() < 1e-5) {
        const bool same_pixel = (found.q(next).cast<double>() - q).isZero(0);
        doubtful += same_pixel ? 0 : 1;
        if (same_pixel) {
          EXPECT_LT((found.n(next).cast<double>() - n).norm(), 1e-6);
          EXPECT_LT((found.m(next).cast<double>() - m).norm(), 1e-5);
          const double sigma_m = error_model_.Sigma(s.z(), {});
          EXPECT_NEAR(found.information[next] * sigma_m * sigma_m, 1, 1e-5);
        }
        ++next;
      } else {
        ++doubtful;
      }
    }
  }
  EXPECT_EQ(next, found.size);
  EXPECT_GT(expected, kCamera.width * kCamera.height / 2);
  EXPECT_LE(doubtful, 3);
}

}  // namespace
}  // namespace surfit
