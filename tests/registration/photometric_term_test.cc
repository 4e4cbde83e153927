#include "registration/icp/photometric_term.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cost_functions/photometric.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/robust_kernel.h"
#include "registration/global/view_fit.h"
#include "registration/icp/icp_level.h"
#include "registration/icp/intensity_finder.h"
#include "registration/simulated_views.h"
#include "testing/pixels.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

class PhotometricTermTest : public ::testing::Test {
 protected:
  PhotometricTermTest() { model_.photometric_weight = 0.01; }
  PhotometricTerm Term() const {
    return {Source(), frames_.target.levels[0], 0.1, model_, frames_.target_from_source};
  }
  const FrameLevel& Source() const { return frames_.source.levels[0]; }
  FrameLevel& Target() { return frames_.target.levels[0]; }

  WallFrames frames_{AlongTheWall()};
  ErrorModel model_;
};

// Single precision: the error of pixels is 1e-5 px, and intensities change by at most 0.1 per px.
TEST_F(PhotometricTermTest, SamplesAtProjectionOfPoints) {
  const IntensityPairs pairs = Term().Collect(frames_.target_from_source);
  ASSERT_GT(pairs.size, 1000);
  for (int i = 0; i < pairs.size; ++i) {
    const Eigen::Vector3d p(pairs.px[i], pairs.py[i], pairs.pz[i]);
    const Eigen::Vector2d at = Target().camera.Project(p);
    const auto u = static_cast<float>(at.x()), v = static_cast<float>(at.y());
    const BilinearSample expected = SampleAt(Target().intensity, u, v);
    ASSERT_NEAR(pairs.target[i], expected.value, 1e-5);
    // Slopes are discontinuous at pixel boundaries.
    if (std::abs(u - std::round(u)) < 1e-3 || std::abs(v - std::round(v)) < 1e-3) continue;
    ASSERT_NEAR(pairs.slope_u[i], expected.slope_u, 1e-5);
    ASSERT_NEAR(pairs.slope_v[i], expected.slope_v, 1e-5);
  }
}

TEST_F(PhotometricTermTest, SelectsPointsWithIntensityGradient) {
  const FrameLevel& source = Source();
  const IntensityPairs pairs = Term().Collect(Rigid3d());
  int next = 0;
  for (const auto [u, v] : Pixels(1, 159, 1, 119)) {
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
  EXPECT_EQ(next, pairs.size);
}

TEST_F(PhotometricTermTest, IgnoresOccludedPointsAndUnknownColors) {
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
    ASSERT_GT(u, 49.49);  // occlusion is tested at the nearest pixel
    ASSERT_LT(u, 109.01);
  }
}

TEST_F(PhotometricTermTest, IsBitwiseIdenticalForAllInstructionSets) {
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

// Quartiles of thousands of resampled points have an error of a few thousandths.
TEST_F(PhotometricTermTest, EstimatesExposure) {
  EXPECT_NEAR(Term().exposure().gain, 1, 0.02);
  EXPECT_NEAR(Term().exposure().offset, 0, 0.01);
  frames_.ChangeExposure(1.25f, -0.125f);
  EXPECT_NEAR(Term().exposure().gain, 0.8, 0.02);
  EXPECT_NEAR(Term().exposure().offset, 0.1, 0.01);
}

using Jet = ceres::Jet<double, 6>;

// Normal system of the functor, by autodiff at the left increment 0.
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

// Single precision: see linearize_test.cc. The residual (about 0.01) is a difference of values
// below one with rounding errors of 1e-7.
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

  WallFrames frames_{AlongTheWall()};
  ErrorModel model_;
};

TEST_F(LinearizeIntensity, AgreesWithFunctor) {
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

TEST_F(LinearizeIntensity, AgreesWithCollectedList) {
  const PhotometricTerm term = Term();
  ExpectNear(Linearize(term, Rigid3d()), Linearize(term.Collect(Rigid3d()), term));
}

TEST_F(LinearizeIntensity, IsTheSameAtAnyNumberOfThreads) {
  const auto systems = AtThreads({1, 2, 4}, [&] {
    const PhotometricTerm term = Term();
    PhotometricSystem both = Linearize(term, Rigid3d());
    both += Linearize(term.Collect(Rigid3d()), term);
    return both;
  });
  const PhotometricSystem& expected = systems[0];
  for (const PhotometricSystem& actual : systems) {
    EXPECT_TRUE(actual.hessian == expected.hessian);
    EXPECT_TRUE(actual.right_side == expected.right_side);
    EXPECT_EQ(actual.cost, expected.cost);
    EXPECT_EQ(actual.row_count, expected.row_count);
  }
}

}  // namespace
}  // namespace surfit::testing
