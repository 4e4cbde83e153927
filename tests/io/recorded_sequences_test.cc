// Reads recorded sequences. Missing sequences are skipped.

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/sequence_writer.h"
#include "testing/shared_data.h"

namespace surfit::testing {
namespace {

SequenceOptions Options(const std::string& sequence, int last = -1) {
  SequenceOptions options;
  options.path = SharedData(sequence);
  options.last = last;
  return options;
}

TEST(RecordedSequences, TumFr1Desk) {
  SURFIT_REQUIRE_SHARED_DATA("tum_fr1_desk_9");
  const auto source = OpenSequence(Options("tum_fr1_desk_9"));
  const SequenceInfo& info = source->info();
  EXPECT_EQ(info.format, "tum");
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_TRUE(info.camera.depth.HasDistortion());
  EXPECT_FALSE(info.pinhole.HasDistortion());
  EXPECT_GT(info.ground_truth.size(), 2000u);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 9u);
  EXPECT_EQ(results[0].stamp_s, 1305031453.374112);  // timestamp of depth
  EXPECT_EQ(results[0].frame->color_stamp_s, 1305031453.359684);
  for (const ReadResult& result : results) {
    ASSERT_TRUE(result.frame) << result.error;
    EXPECT_EQ(result.frame->color.width(), 640);
    for (const float depth : result.frame->depth_m) {
      EXPECT_TRUE(depth == 0 || (depth > 0.3f && depth <= 8)) << depth;
    }
  }
}

// 37.7 % of all pixels of this recording have confidence 0, and none lacks depth. Depth beyond 8 m
// is missing as well.
TEST(RecordedSequences, PhoneConfidenceRemovesAThirdOfDepth) {
  SURFIT_REQUIRE_SHARED_DATA("phone_lidar_walk");
  SequenceOptions options = Options("phone_lidar_walk");
  const auto count = [&] {
    std::size_t depths = 0;
    for (const ReadResult& result : ReadAll(OpenSequence(options).get())) {
      EXPECT_TRUE(result.frame) << result.error;
      if (!result.frame) continue;
      const Image<float>& depth_m = result.frame->depth_m;
      depths += depth_m.size() - std::count(depth_m.begin(), depth_m.end(), 0.0f);
    }
    return static_cast<double>(depths);
  };
  const SequenceInfo info = OpenSequence(options)->info();
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_THAT(info.assumed, Names("confidence", "2"));
  ASSERT_TRUE(info.low_confidence_ratio);
  const double kept = count();
  options.confidence = false;
  EXPECT_FALSE(OpenSequence(options)->info().low_confidence_ratio);
  EXPECT_NEAR(1 - kept / count(), 0.377, 0.02);
}

// The first frames of each sequence, and frames with fast rotation.
TEST(RecordedSequences, CauseNoRegistrationWarning) {
  for (const char* name :
       {"tum_fr1_desk", "icl_office", "icl_office_kinect", "seven_scenes_kitchen"}) {
    SURFIT_REQUIRE_SHARED_DATA(name);
    for (const int first : {0, 60}) {
      SequenceOptions options = Options(name);
      options.first = first;
      // Without its format, the camera of 7-Scenes is a guess.
      if (name == std::string("seven_scenes_kitchen")) options.format = "seven_scenes";
      EXPECT_THAT(OpenSequence(options)->info().warnings, IsEmpty()) << name << ", " << first;
    }
  }
}

// Colour of 7-Scenes has a separate camera. If it is used as registered, it is 10 % too large.
TEST(RecordedSequences, WarnAboutUnregisteredColor) {
  SURFIT_REQUIRE_SHARED_DATA("seven_scenes_kitchen");
  for (const int first : {0, 200, 500}) {
    SequenceOptions options = Options("seven_scenes_kitchen");
    options.camera = "redwood";
    options.intrinsics = {585, 585, 320, 240};
    options.first = first;
    EXPECT_THAT(
        OpenSequence(options)->info().warnings,
        ::testing::Contains(::testing::AnyOf(Names("color_camera", 89), Names("color_camera", 92))))
        << first;
  }
}

TEST(RecordedSequences, UseTheCameraNamedByATumDownload) {
  SURFIT_REQUIRE_SHARED_DATA("tum_fr1_desk");
  const auto source = OpenSequence(Options("tum_fr1_desk", 0));
  EXPECT_THAT(source->info().warnings, IsEmpty());
  EXPECT_EQ(source->info().camera.depth.fx, 517.3);
  EXPECT_EQ(source->info().camera.latency_s, 0.02);
  const RgbdFrame frame = *source->Next()->frame;
  EXPECT_EQ(frame.stamp_s, 1305031453.374112 - 0.02);
  EXPECT_EQ(frame.color_stamp_s, 1305031453.359684 - 0.02);
}

TEST(RecordedSequences, IclOffice) {
  SURFIT_REQUIRE_SHARED_DATA("icl_office");
  for (const char* format : {"auto", "icl_nuim"}) {
    SequenceOptions options = Options("icl_office", 4);
    options.format = format;
    const auto source = OpenSequence(options);
    EXPECT_FALSE(source->info().mirrored);  // camera.yaml: rendered upright
    EXPECT_EQ(source->info().pinhole.fx, 481.203);
    EXPECT_EQ(source->info().ground_truth.size(), 200u);
    const auto results = ReadAll(source.get());
    ASSERT_EQ(results.size(), 5u);
    EXPECT_EQ(results[1].stamp_s, 2.033333);
    // Windows have no depth. The default depth limit keeps most other pixels.
    const auto& depth = results[4].frame->depth_m;
    EXPECT_GT(std::count_if(depth.begin(), depth.end(), [](float d) { return d > 0; }), 290000);
  }
}

TEST(RecordedSequences, IclOfficeKinectReadsItsLinkedColor) {
  SURFIT_REQUIRE_SHARED_DATA("icl_office_kinect");
  SURFIT_REQUIRE_SHARED_DATA("icl_office");
  const auto noisy = ReadAll(OpenSequence(Options("icl_office_kinect", 1)).get());
  const auto clean = ReadAll(OpenSequence(Options("icl_office", 1)).get());
  ASSERT_TRUE(noisy[1].frame) << noisy[1].error;
  EXPECT_EQ(noisy[1].frame->color, clean[1].frame->color);
}

// Median difference in metres between the depth of frame 0, transformed by the ground truth into
// frame `gap`, and the depth of that frame. It is large if signs, scale, direction of the poses or
// the order of quaternion components are wrong.
float MedianDepthDifference(const std::string& sequence, int gap) {
  SequenceOptions options = Options(sequence, gap);
  options.stride = gap;
  const auto source = OpenSequence(options);
  const auto results = ReadAll(source.get());
  const SequenceInfo& info = source->info();
  const auto pose_at = [&](double stamp_s) {
    return std::min_element(info.ground_truth.begin(), info.ground_truth.end(),
                            [&](const StampedPose& a, const StampedPose& b) {
                              return std::abs(a.stamp_s - stamp_s) < std::abs(b.stamp_s - stamp_s);
                            })
        ->world_from_camera;
  };
  const Rigid3d last_from_first =
      pose_at(results.back().stamp_s).Inverse() * pose_at(results.front().stamp_s);
  const auto& first = results.front().frame->depth_m;
  const auto& last = results.back().frame->depth_m;
  std::vector<float> differences_m;
  for (int v = 0; v < first.height(); v += 4) {
    for (int u = 0; u < first.width(); u += 4) {
      if (first(u, v) == 0) continue;
      const Eigen::Vector3d point = last_from_first * (first(u, v) * info.pinhole.Ray(u, v));
      const Eigen::Vector2d pixel = info.pinhole.Project(point);
      const int u1 = static_cast<int>(std::lround(pixel.x()));
      const int v1 = static_cast<int>(std::lround(pixel.y()));
      if (u1 < 0 || v1 < 0 || u1 >= last.width() || v1 >= last.height()) continue;
      if (last(u1, v1) == 0) continue;
      differences_m.push_back(std::abs(last(u1, v1) - static_cast<float>(point.z())));
    }
  }
  std::sort(differences_m.begin(), differences_m.end());
  return differences_m.at(differences_m.size() / 2);
}

// Depth and poses are exact. The remaining difference is the slope over half a pixel: about
// 3 m / 481 / 2 = 3 mm for a surface at 45 deg.
TEST(RecordedSequences, IclOfficeGroundTruthMatchesDepth) {
  SURFIT_REQUIRE_SHARED_DATA("icl_office");
  EXPECT_LT(MedianDepthDifference("icl_office", 20), 0.003f);
}

// ABOUT.md of the data set reports a median of 8.1 mm at gap 20.
TEST(RecordedSequences, KitchenGroundTruthMatchesDepth) {
  SURFIT_REQUIRE_SHARED_DATA("seven_scenes_kitchen");
  EXPECT_LT(MedianDepthDifference("seven_scenes_kitchen", 20), 0.015f);
}

// Motion capture and a Kinect at 1 to 2 m: noise of a few mm, calibration error of about 1 cm.
TEST(RecordedSequences, TumGroundTruthMatchesDepth) {
  SURFIT_REQUIRE_SHARED_DATA("tum_fr1_desk_9");
  EXPECT_LT(MedianDepthDifference("tum_fr1_desk_9", 8), 0.02f);
}

TEST(RecordedSequences, KitchenHasNoInvalidCodesAndASeparateColorCamera) {
  SURFIT_REQUIRE_SHARED_DATA("seven_scenes_kitchen");
  SequenceOptions options = Options("seven_scenes_kitchen", 33);
  options.first = 33;  // first frame with the invalid code 65535
  const auto source = OpenSequence(options);
  EXPECT_EQ(source->info().format, "seven_scenes");
  EXPECT_FALSE(source->info().camera.color_is_registered);
  EXPECT_EQ(source->info().ground_truth.size(), 1000u);
  const auto results = ReadAll(source.get());
  ASSERT_EQ(results.size(), 1u);
  EXPECT_DOUBLE_EQ(results[0].stamp_s, 33 / 30.);
  const std::string stem = SharedData("seven_scenes_kitchen") + "/frame-000033";
  const cv::Mat raw = cv::imread(stem + ".depth.png", cv::IMREAD_UNCHANGED);
  const cv::Mat bgr = cv::imread(stem + ".color.jpg");
  const RgbdFrame& frame = *results[0].frame;
  int invalid_codes = 0;
  for (const auto [u, v] : PixelsOf(640, 480)) {
    const int counts = raw.at<std::uint16_t>(v, u);
    invalid_codes += counts == 65535;
    EXPECT_EQ(frame.depth_m(u, v), counts == 65535 ? 0.f : counts / 1000.f);
  }
  EXPECT_GT(invalid_codes, 0);
  // Colour pixel = 525/585 (depth pixel - centre) + centre + (-8, 0). Depth pixel 320 + 39 k is
  // exactly colour pixel 312 + 35 k. ABOUT.md states a ratio of about 0.90.
  for (int k = -8; k <= 8; ++k) {
    for (int l = -6; l <= 6; ++l) {
      const auto& p = bgr.at<cv::Vec3b>(240 + 35 * l, 312 + 35 * k);
      EXPECT_EQ(frame.color(320 + 39 * k, 240 + 39 * l), (Rgb8{p[2], p[1], p[0]}));
    }
  }
}

}  // namespace
}  // namespace surfit::testing
