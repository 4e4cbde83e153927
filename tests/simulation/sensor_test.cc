#include "surfit/simulation/sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "surfit/core/error.h"
#include "surfit/core/parallel.h"
#include "testing/expect_input_error.h"
#include "testing/shared_data.h"

namespace surfit {
namespace {

constexpr double kConstant_m = 351.3;

PinholeCamera Camera() {
  PinholeCamera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 525;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

// The plane whose disparity is a u + b v + c steps.
Image<float> PlaneDepth(double a, double b, double c) {
  Image<float> depth(640, 480);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      depth(u, v) = static_cast<float>(kConstant_m / (a * u + b * v + c));
    }
  }
  return depth;
}

struct Moments {
  double mean = 0, variance = 0;
  int count = 0;
};

// Of the error in disparity steps, over pixels away from the border.
Moments DisparityError(const Image<float>& exact, const Image<float>& measured) {
  std::vector<double> errors;
  for (int v = 4; v < 476; ++v) {
    for (int u = 4; u < 636; ++u) {
      if (measured(u, v) == 0) continue;
      errors.push_back(kConstant_m / measured(u, v) - kConstant_m / exact(u, v));
    }
  }
  Moments moments;
  moments.count = static_cast<int>(errors.size());
  for (const double e : errors) moments.mean += e / errors.size();
  for (const double e : errors) {
    moments.variance += (e - moments.mean) * (e - moments.mean) / errors.size();
  }
  return moments;
}

// On a plane the error in steps is the sum of independent parts: a shift of (s_u, s_v) px adds
// a s_u + b s_v, the noise has sd 1/6, and rounding adds a uniform error of variance 1/12, as the
// disparities of a sloping plane take all fractions of a step alike.
class KinectOnAPlane : public ::testing::TestWithParam<std::array<double, 3>> {};

TEST_P(KinectOnAPlane, HasTheVarianceOfItsParts) {
  const auto [a, b, c] = GetParam();
  const Image<float> exact = PlaneDepth(a, b, c);
  const Moments error = DisparityError(exact, KinectDepth(exact, Camera(), 3));
  ASSERT_EQ(error.count, 632 * 472);
  const double variance = 0.25 * (a * a + b * b) + 1.0 / 36 + 1.0 / 12;
  // Five standard errors; for variances with the kurtosis of a normal distribution (ours is lower).
  EXPECT_NEAR(error.mean, 0, 5 * std::sqrt(variance / error.count));
  EXPECT_NEAR(error.variance, variance, 5 * variance * std::sqrt(2.0 / error.count));
}

INSTANTIATE_TEST_SUITE_P(Slopes, KinectOnAPlane,
                         ::testing::Values(std::array<double, 3>{0.011, 0.007, 290},
                                           std::array<double, 3>{0.05, 0.031, 110},
                                           std::array<double, 3>{0.013, 0.6, 90},
                                           std::array<double, 3>{-0.3, 0.017, 330}));

TEST(Kinect, IsMissingNearFarAndAtGrazingAngles) {
  for (const auto& [depth_m, seen] : {std::pair{0.39, false}, std::pair{0.42, true},
                                      std::pair{4.3, true}, std::pair{4.8, false}}) {
    const Image<float> wall(640, 480, static_cast<float>(depth_m));
    const Image<float> measured = KinectDepth(wall, Camera(), 1);
    const auto valid = measured.size() - std::count(measured.begin(), measured.end(), 0.f);
    EXPECT_EQ(valid, seen ? measured.size() : 0u) << depth_m;
  }
}

// A floor 0.3 m below the camera: row v sees it at z = 0.3 fy / (v - cy), at an angle of incidence
// with cosine (v - cy) / fy / |ray|.
TEST(Kinect, IsMissingBeyond80DegreesOfIncidence) {
  const PinholeCamera camera = Camera();
  Image<float> floor(640, 480, 0.f);
  for (int v = 280; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      floor(u, v) = static_cast<float>(0.3 * camera.fy / (v - camera.cy));
    }
  }
  const Image<float> measured = KinectDepth(floor, camera, 1);
  for (int v = 282; v < 478; ++v) {
    for (int u = 0; u < 640; ++u) {
      const Eigen::Vector3d ray = camera.Ray(u, v);
      const double angle_deg = std::acos(ray.y() / ray.norm()) * 180 / M_PI;
      // Float depth and one-sided differences at the border: far below 0.1 deg.
      if (angle_deg < 79.9 && floor(u, v) > 0.42) {
        EXPECT_GT(measured(u, v), 0) << u << " " << v;
      }
      if (angle_deg > 80.1) {
        EXPECT_EQ(measured(u, v), 0) << u << " " << v;
      }
    }
  }
}

TEST(Kinect, DoesNotMixDepthsAcrossAStep) {
  Image<float> step(640, 480, 1.f);
  for (int v = 0; v < 480; ++v) std::fill(step.row(v) + 320, step.row(v) + 640, 2.f);
  const Image<float> measured = KinectDepth(step, Camera(), 1);
  // A step of disparity is z^2 / 351.3; rounding and noise of 6 sd move by at most 1.5 of them.
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      if (u == 319 || u == 320) {
        EXPECT_EQ(measured(u, v), 0) << "a step looks like a surface seen at a grazing angle";
      } else {
        const double z = step(u, v);
        EXPECT_NEAR(measured(u, v), z, 1.6 * z * z / kConstant_m);
      }
    }
  }
}

TEST(Kinect, KeepsMissingPixelsMissing) {
  Image<float> depth(640, 480, 2.f);
  depth(100, 100) = 0;
  EXPECT_EQ(KinectDepth(depth, Camera(), 1)(100, 100), 0);
}

TEST(Kinect, DependsOnTheSeedAndNotOnTheThreads) {
  const Image<float> depth = PlaneDepth(0.05, 0.031, 110);
  std::vector<Image<float>> images;
  for (const int threads : {1, 2, 5}) {
    ThreadLimit limit(threads);
    images.push_back(KinectDepth(depth, Camera(), 7));
  }
  EXPECT_TRUE(images[0] == images[1]);
  EXPECT_TRUE(images[0] == images[2]);
  EXPECT_FALSE(images[0] == KinectDepth(depth, Camera(), 8));
}

TEST(Kinect, RefusesBadOptionsByName) {
  KinectOptions options;
  options.max_depth_m = 0.2;
  testing::ExpectInputError([&] { KinectDepth(Image<float>(640, 480, 1.f), Camera(), 1, options); },
                            ::testing::HasSubstr("max_depth_m is 0.2, must be above min_depth_m"));
}

// The shared recording was made from icl_office by the noise model that ours follows.
class KinectAgainstRecording : public ::testing::Test {
 protected:
  static constexpr int kFrames = 5;

  void SetUp() override {
    SURFIT_REQUIRE_SHARED_DATA("icl_office_kinect");
    SURFIT_REQUIRE_SHARED_DATA("icl_office");
    PinholeCamera camera = Camera();
    camera.fx = 481.203;
    camera.fy = 480;
    for (int i = 0; i < kFrames; ++i) {
      char name[32];
      std::snprintf(name, sizeof(name), "/depth/%.6f.png", 2 + i * 40 / 30.0);
      exact_.push_back(Load(testing::SharedData("icl_office") + name));
      recorded_.push_back(Load(testing::SharedData("icl_office_kinect") + name));
      ours_.push_back(KinectDepth(exact_.back(), camera, i));
    }
  }

  static Image<float> Load(const std::string& path) {
    const cv::Mat units = cv::imread(path, cv::IMREAD_UNCHANGED);
    if (units.empty()) throw InputError(path + " cannot be read");
    Image<float> depth(units.cols, units.rows);
    std::transform(units.begin<std::uint16_t>(), units.end<std::uint16_t>(), depth.begin(),
                   [](std::uint16_t unit) { return unit / 5000.f; });
    return depth;
  }

  static double ValidShare(const std::vector<Image<float>>& images) {
    double valid = 0, all = 0;
    for (const Image<float>& image : images) {
      valid += image.size() - std::count(image.begin(), image.end(), 0.f);
      all += image.size();
    }
    return valid / all;
  }

  // Sorted errors where the exact depth is within 10 cm of this one.
  std::vector<double> Errors(const std::vector<Image<float>>& images, double depth_m) const {
    std::vector<double> errors;
    for (int i = 0; i < kFrames; ++i) {
      for (std::size_t k = 0; k < images[i].size(); ++k) {
        const double exact = exact_[i][k], measured = images[i][k];
        if (measured > 0 && std::abs(exact - depth_m) < 0.1) errors.push_back(measured - exact);
      }
    }
    std::sort(errors.begin(), errors.end());
    return errors;
  }

  std::vector<Image<float>> exact_, recorded_, ours_;
};

double Quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * (sorted.size() - 1))];
}

TEST_F(KinectAgainstRecording, LosesTheSameShareOfPixels) {
  EXPECT_NEAR(ValidShare(ours_), ValidShare(recorded_), 0.005);
}

// Half the width of the middle 68.27 %: the sd of a normal distribution, without the outliers that
// the recording has at edges. Its own description gives 3, 8, 16 and 21 mm with these.
TEST_F(KinectAgainstRecording, HasTheSameSpreadAtEachDistanceAndNoBias) {
  const double most_mm[] = {3, 8, 16, 21};
  for (int i = 0; i < 4; ++i) {
    const double depth_m = 1.2 + i;
    const std::vector<double> ours = Errors(ours_, depth_m), recorded = Errors(recorded_, depth_m);
    ASSERT_GT(ours.size(), 20000u);
    const auto spread = [](const std::vector<double>& e) {
      return (Quantile(e, 0.84134) - Quantile(e, 0.15866)) / 2;
    };
    // The recording is quantised to 0.2 mm. The standard error of the spread is 1.2 sd / sqrt(N)
    // < 1 %; disparities that are whole numbers in one image and not in the other add to it.
    EXPECT_NEAR(spread(ours), spread(recorded), 0.0002 + 0.03 * spread(recorded)) << depth_m;
    EXPECT_LT(spread(ours), most_mm[i] / 1000);
    // A few standard errors of the median, 1.25 sd / sqrt(N), and half a unit of the recording.
    EXPECT_NEAR(Quantile(ours, 0.5), 0, 5 * 1.25 * spread(ours) / std::sqrt(ours.size()) + 0.0001);
  }
}

}  // namespace
}  // namespace surfit
