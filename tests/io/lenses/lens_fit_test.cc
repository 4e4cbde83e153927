#include "io/lenses/lens_fit.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "frame/lens.h"
#include "surfit/io/camera_files.h"
#include "testing/matchers.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

const PinholeCamera kCamera = {320, 240, 300, 300, 159.5, 119.5, {}};
// Coefficients of an Azure Kinect.
const std::vector<double> kRational = {0.52, -2.73, 0.0007, -0.0002, 1.62, 0.40, -2.55, 1.54};
const std::vector<double> kFisheye = {-0.02, 0.006, -0.002, 0.0003};

// Pixel of a ray by the formulas of the ROS message CameraInfo.
Eigen::Vector2d Rational(double x, double y) {
  const std::vector<double>& n = kRational;
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double k =
      (1 + n[0] * r2 + n[1] * r4 + n[4] * r6) / (1 + n[5] * r2 + n[6] * r4 + n[7] * r6);
  return {300 * (x * k + 2 * n[2] * x * y + n[3] * (r2 + 2 * x * x)) + 159.5,
          300 * (y * k + n[2] * (r2 + 2 * y * y) + 2 * n[3] * x * y) + 119.5};
}

Eigen::Vector2d Fisheye(double x, double y) {
  const double r = std::hypot(x, y), a = std::atan(r);
  const double bent = a + kFisheye[0] * std::pow(a, 3) + kFisheye[1] * std::pow(a, 5) +
                      kFisheye[2] * std::pow(a, 7) + kFisheye[3] * std::pow(a, 9);
  const double scale = r > 0 ? bent / r : 1;
  return {300 * x * scale + 159.5, 300 * y * scale + 119.5};
}

// Largest distance of the fitted lens from the pixels of the model, px.
template <typename Model>
double ErrorOf(const std::string& name, const std::vector<double>& numbers, const Model& model) {
  PinholeCamera fitted = kCamera;
  fitted.distortion = FitDistortion(name, numbers, kCamera, "a");
  const Lens<double> lens(fitted);
  double most = 0;
  for (double y = -0.38; y <= 0.38; y += 0.02) {
    for (double x = -0.52; x <= 0.52; x += 0.02) {
      const LensPixel<double> pixel = lens.Project(x, y, 1.);
      EXPECT_TRUE(pixel.is_seen);
      most = std::max(most, (Eigen::Vector2d(pixel.u, pixel.v) - model(x, y)).norm());
    }
  }
  return most;
}

TEST(FitDistortion, AgreesWithRationalAndFisheyeModels) {
  EXPECT_LT(ErrorOf("rational_polynomial", kRational, Rational), 0.1);
  EXPECT_LT(ErrorOf("equidistant", kFisheye, Fisheye), 0.1);
}

TEST(FitDistortion, ReturnsCoefficientsThatNeedNoFit) {
  const auto fit =
      FitDistortion("rational", {0.1, -0.2, 0.001, -0.002, 0.05, 0, 0, 0}, kCamera, "a");
  const double expected[] = {0.1, -0.2, 0.001, -0.002, 0.05};
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(fit[i], expected[i], 1e-6) << i;
}

TEST(FitDistortion, RejectsLensesThatItCannotRepresent) {
  PinholeCamera wide = kCamera;
  wide.fx = wide.fy = 105;  // a fisheye of 140 degrees
  EXPECT_THAT(
      [&] {
        FitDistortion("fisheye", {0, 0, 0, 0}, wide, "k.bag");
      },
      ThrowsNaming<InputError>("k.bag", "fisheye", 0.5));
  EXPECT_THAT(
      [&] {
        FitDistortion("ftheta", {1, 2}, kCamera, "k.bag");
      },
      ThrowsNaming<InputError>("k.bag", "ftheta", "rational_polynomial"));
  EXPECT_THAT(
      [&] {
        FitDistortion("equidistant", {1, 2}, kCamera, "k.bag");
      },
      ThrowsNaming<InputError>("k.bag", "equidistant", 2, 4));
}

TEST(CameraYaml, ReadsRationalAndFisheyeLenses) {
  const TempFolder folder;
  const auto read = [&](const std::string& lens) {
    return ReadCameraYaml(folder.Write(
        "camera.yaml",
        "depth_camera: { width: 320, height: 240, fx: 300, fy: 300, cx: 159.5, cy: 119.5, " + lens +
            " }\ndepth_units_per_metre: 1000\n"));
  };
  EXPECT_EQ(read("distortion: [ 0.52, -2.73, 0.0007, -0.0002, 1.62, 0.40, -2.55, 1.54 ]")
                .depth.distortion,
            FitDistortion("rational", kRational, kCamera, "a"));
  EXPECT_EQ(read("distortion_model: fisheye, distortion: [ -0.02, 0.006, -0.002, 0.0003 ]")
                .depth.distortion,
            FitDistortion("fisheye", kFisheye, kCamera, "a"));
  EXPECT_THAT([&] { read("distortion: [ 1, 2, 3, 4 ]"); },
              ThrowsNaming<InputError>("distortion", 4, "distortion_model"));
}

}  // namespace
}  // namespace surfit::testing
