#include "run/start_slam.h"

#include <gtest/gtest.h>

namespace surfit::testing {
namespace {

// Photometric weight of a run with these options. `confidence_range`: SequenceInfo.
double WeightOf(SlamOptions options, int confidence_range, bool has_color,
                std::optional<double> measured_noise = {}) {
  SequenceInfo info;
  info.confidence_range = confidence_range;
  NoiseReport noise;
  noise.start = 0.002;
  noise.measured = measured_noise;
  WeighColor(info, noise, has_color, &options);
  return options.icp.error_model.photometric_weight;
}

TEST(WeighColor, UsesColourWithTheDepthOfPhonesOnly) {
  EXPECT_GT(WeightOf({}, 2, true), 0);
  EXPECT_EQ(WeightOf({}, 2, false), 0);
  EXPECT_EQ(WeightOf({}, 255, true), 0);
  EXPECT_EQ(WeightOf({}, 0, true), 0);
}

TEST(WeighColor, LeavesExactDepthAlone) {
  EXPECT_GT(WeightOf({}, 2, true, 0.0006), 0);
  EXPECT_EQ(WeightOf({}, 2, true, 0.0002), 0);
}

TEST(KeepCalibrationOfPhones, CalibratesWithAPriorOnly) {
  const auto calibrates = [](int confidence_range, double center_px) {
    SequenceInfo info;
    info.confidence_range = confidence_range;
    info.camera.prior.center_px = center_px;
    SlamOptions options;
    KeepCalibrationOfPhones(info, &options);
    return options.calibration.enabled;
  };
  const double usual_px = CalibrationPrior().center_px;
  EXPECT_FALSE(calibrates(2, usual_px));
  EXPECT_TRUE(calibrates(2, usual_px + 1));
  EXPECT_TRUE(calibrates(255, usual_px));
  EXPECT_TRUE(calibrates(0, usual_px));
}

TEST(WeighColor, LeavesOptionsThatDecide) {
  SlamOptions options;
  options.icp.error_model.photometric_weight = 0.1;
  EXPECT_EQ(WeightOf(options, 2, true), 0.1);
  options = {};
  options.weakly_constrained_photometric_weight = 0;
  EXPECT_EQ(WeightOf(options, 2, true), 0);
  options = {};
  options.icp.solver = "svd";
  EXPECT_EQ(WeightOf(options, 2, true), 0);
}

}  // namespace
}  // namespace surfit::testing
