#include "surfit/registration/error_model.h"

#include <gtest/gtest.h>

#include "registration/icp/icp_level.h"
#include "registration/three_planes.h"
#include "surfit/registration/association.h"

namespace surfit::testing {
namespace {

TEST(ErrorModel, SigmaAddsFloorToSensorNoise) {
  ErrorModel model;
  model.floor_sigma_m = 0.003;
  EXPECT_NEAR(model.Sigma(2, {0.001}), 0.005, 1e-15);  // 3, 4, 5
  EXPECT_EQ(model.Sigma(5, {0}), 0.003);
}

// Weight of a correspondence at depth z with residual r.
double WeightOf(double depth_m, double residual_m, const ErrorModel& model,
                const DepthNoise& noise = {}) {
  FrameLevel source = EmptyLevel(), target = EmptyLevel();
  source.noise = noise;
  SetPoint(&source, 2, 2, depth_m, {0, 0, -1});
  SetPoint(&target, 2, 2, depth_m + residual_m, {0, 0, -1});
  const AssociationGates off = {0, 0};
  const ProjectiveAssociation association(source, target, off, model);
  const NormalSystem system =
      Linearize(association, Rigid3d(), ResidualType::kPointToPlane, model.kernel);
  EXPECT_EQ(system.pair_count, 1);
  return system.weight_sum;
}

// rho(s) = s / (1 + s / k^2), the Geman-McClure kernel in s = (r / sigma)^2.
double Rho(double s, double k) { return s / (1 + s / (k * k)); }

TEST(ErrorModel, WeightIsKernelSlopePerVariance) {
  ErrorModel model;
  const DepthNoise noise = {0.003};
  for (const double width : {1.0, 3.0}) {
    model.kernel.width = width;
    for (const double depth_m : {0.5, 2.0, 4.0}) {
      for (const double share : {0.0, 0.5, 1.0, 3.0, 8.0}) {
        const double sigma = model.Sigma(depth_m, noise);
        const double s = share * share, h = 1e-5;
        const double derivative = (Rho(s + h, width) - Rho(s - h, width)) / (2 * h);
        const double expected = derivative / (sigma * sigma);
        // Points are floats: the error of r = 8 sigma is 2^-23 * depth = 5e-7 m, of at least 16 mm.
        // rho' depends at most on its fourth power. The error of the difference quotient is 1e-10.
        EXPECT_NEAR(WeightOf(depth_m, share * sigma, model, noise), expected, 2e-4 * expected)
            << width << " " << depth_m << " " << share;
      }
    }
  }
}

TEST(ErrorModel, WeightIsInverseVarianceWithoutKernel) {
  ErrorModel model;
  model.kernel.type = RobustKernelType::kNone;
  const double variance = std::pow(model.Sigma(2, {}), 2);
  EXPECT_NEAR(WeightOf(2, 0, model), 1 / variance, 1e-6 / variance);
  EXPECT_NEAR(WeightOf(2, 1, model), 1 / variance, 1e-6 / variance);
}

}  // namespace
}  // namespace surfit::testing
