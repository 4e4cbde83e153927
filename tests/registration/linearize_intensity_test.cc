#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cost_functions/photometric.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/robust_kernel.h"
#include "registration/icp_level.h"
#include "registration/wall_frames.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using Jet = ceres::Jet<double, 6>;

// The system of the functor, by automatic differentiation at the left increment 0.
PhotometricSystem SystemOfFunctor(const IntensityPairs& pairs, const PhotometricTerm& term,
                                  const ErrorModel& model) {
  Eigen::Matrix<Jet, 3, 1> w, t;
  for (int k = 0; k < 3; ++k) w[k] = Jet(0, k), t[k] = Jet(0, k + 3);
  Jet pose[kPoseSize];
  PoseToBlock(Rigid3<Jet>(QuaternionExp<Jet>(w), t), pose);
  const PinholeCamera& camera = term.camera();
  Photometric functor(camera.fx, camera.fy, camera.cx, camera.cy);
  PhotometricSystem system;
  for (int i = 0; i < pairs.size; ++i) {
    const Eigen::Vector3d p(pairs.px[i], pairs.py[i], pairs.pz[i]);
    const Eigen::Vector2d at = camera.Project(p);
    const Exposure& exposure = term.exposure();
    functor.SetPoint(p, double{exposure.gain} * pairs.source[i] + exposure.offset, at.x(), at.y(),
                     pairs.target[i], {pairs.slope_u[i], pairs.slope_v[i]}, model.intensity_sigma);
    Jet r;
    functor(pose, &r);
    const KernelValue<double> value = EvaluateKernel(model.intensity_kernel, r.a * r.a);
    const double weight = model.photometric_weight * value.slope;
    system.hessian += weight * r.v * r.v.transpose();
    system.right_side -= weight * r.a * r.v;
    system.cost += 0.5 * model.photometric_weight * value.rho;
    system.square_sum += weight * r.a * r.a;
    ++system.row_count;
  }
  return system;
}

// Single precision: see linearize_test.cc. The residual is a difference of numbers below one,
// rounded by 1e-7, where it is a hundredth itself.
constexpr double kRelative = 1e-5;

void ExpectNear(const PhotometricSystem& actual, const PhotometricSystem& expected) {
  const Vector6d root = expected.hessian.diagonal().cwiseSqrt();
  const double residual_root = std::sqrt(expected.square_sum);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      EXPECT_NEAR(actual.hessian(i, j), expected.hessian(i, j), kRelative * root[i] * root[j]);
    }
    EXPECT_NEAR(actual.right_side[i], expected.right_side[i], kRelative * root[i] * residual_root);
  }
  EXPECT_NEAR(actual.cost, expected.cost, kRelative * expected.cost);
  EXPECT_NEAR(actual.square_sum, expected.square_sum, kRelative * expected.square_sum);
  EXPECT_EQ(actual.row_count, expected.row_count);
}

class LinearizeIntensity : public ::testing::Test {
 protected:
  LinearizeIntensity() {
    model_.photometric_weight = 0.3;
    frames_.ChangeExposure(0.9f, 0.05f);
  }
  PhotometricTerm Term() const {
    return {frames_.source.levels[0], frames_.target.levels[0], 0.1, model_, Rigid3d()};
  }

  testing::WallFrames frames_{testing::AlongTheWall()};
  ErrorModel model_;
};

TEST_F(LinearizeIntensity, HasTheRowsOfTheFunctor) {
  for (const RobustKernelType kernel :
       {RobustKernelType::kNone, RobustKernelType::kHuber, RobustKernelType::kGemanMcClure}) {
    model_.intensity_kernel.type = kernel;
    const PhotometricTerm term = Term();
    IntensityPairs pairs = term.Collect(Rigid3d());
    ASSERT_GT(pairs.size, 1000);
    ExpectNear(Linearize(pairs, term), SystemOfFunctor(pairs, term, model_));
    for (const int size : {0, 1, 63, 64, 65}) {
      pairs.size = size;
      ExpectNear(Linearize(pairs, term), SystemOfFunctor(pairs, term, model_));
    }
  }
}

TEST_F(LinearizeIntensity, SumsWhatCollectLists) {
  const PhotometricTerm term = Term();
  ExpectNear(Linearize(term, Rigid3d()), Linearize(term.Collect(Rigid3d()), term));
}

TEST_F(LinearizeIntensity, IsTheSameAtAnyNumberOfThreads) {
  const auto linearize = [&](int threads) {
    const ThreadLimit limit(threads);
    const PhotometricTerm term = Term();
    PhotometricSystem both = Linearize(term, Rigid3d());
    both += Linearize(term.Collect(Rigid3d()), term);
    return both;
  };
  const PhotometricSystem expected = linearize(1);
  for (const int threads : {2, 4}) {
    const PhotometricSystem actual = linearize(threads);
    EXPECT_TRUE(actual.hessian == expected.hessian);
    EXPECT_TRUE(actual.right_side == expected.right_side);
    EXPECT_EQ(actual.cost, expected.cost);
    EXPECT_EQ(actual.row_count, expected.row_count);
  }
}

}  // namespace
}  // namespace surfit
