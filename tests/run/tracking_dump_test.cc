#include "run/results/tracking_dump.h"

#include <gmock/gmock.h>

#include "registration/three_planes.h"
#include "surfit/frame/frame_pyramid.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

// Every field differs from its default.
SlamOptions OtherOptions() {
  SlamOptions options;
  options.preprocess.pyramid_levels = 2;
  options.preprocess.max_slant_rad = 1.3;
  IcpOptions& icp = options.icp;
  icp.solver = "tiny";
  icp.linear_solver = "dense_normal_cholesky";
  icp.residual = "symmetric_point_to_plane";
  icp.association = "kd_tree";
  icp.middle_levels = false;
  icp.max_iterations = 3;
  icp.gates = {0.3, 0.6};
  icp.gate_growth = 1.7;
  icp.kernel_growth = 1.1;
  icp.error_model = {
      0.003, {RobustKernelType::kTukey, 4.7}, 0.3, 0.03, {RobustKernelType::kTukey, 2.9}};
  icp.min_source_rows = 20;
  icp.min_coarse_step_px = 0.1;
  icp.min_relative_rmse_change = 1.0 / 3000;
  icp.min_increment = 1e-7;
  icp.stop_at_rmse_increase = false;
  icp.min_inliers = 100;
  icp.min_inlier_ratio = 0.01;
  icp.observability.min_eigenvalue = 1e-9;
  icp.max_free_space_violation_ratio = 0.9;
  return options;
}

Rigid3d Motion() { return {QuaternionExp<double>({0.02, -0.03, 0.01}), {0.01, 0.02, -0.03}}; }

Image<Rgb8> Stripes(int shift_px) {
  const PinholeCamera camera = CornerCamera();
  Image<Rgb8> color(camera.width, camera.height);
  for (const auto [u, v] : PixelsOf(camera)) {
    const auto value = static_cast<std::uint8_t>(100 + 12 * ((u + v / 2 + shift_px) % 13));
    color(u, v) = {value, static_cast<std::uint8_t>(value / 2), value};
  }
  return color;
}

class TrackingDumps : public ::testing::Test {
 protected:
  // Writes the dump of a lost frame: a noisy sensor in front of a corner.
  void Write(const SlamOptions& options) {
    const auto pyramid = [&](const Rigid3d& pose) {
      FrameLevel finest = RenderCorner(pose);
      finest.noise.inverse_depth_sigma = kSigma;
      return BuildPyramid(finest, options.preprocess);
    };
    const Rigid3d pose = PoseBeforeTheCorner();
    target_ = pyramid(pose);
    source_ = pyramid(pose * Motion());
    const Image<Rgb8> source_color = Stripes(1), target_color = Stripes(4);
    AddIntensity(source_color, &source_);
    AddIntensity(target_color, &target_);
    result_ = Register(source_, target_, initial_, options.icp);
    const IcpOptions used = used_.value_or(options.icp);
    WriteTrackingDump({17, source_, target_, source_color, target_color, initial_, result_, used},
                      options, path());
  }
  std::string path() const { return folder_ / "frame-000017"; }
  static constexpr double kSigma = 0.0031;

  TempFolder folder_;
  FramePyramid source_, target_;
  Rigid3d initial_ = {QuaternionExp<double>({0.01, 0, 0.1 / 3}), {0.01, 1.0 / 3000, 0}};
  IcpResult result_;
  std::optional<IcpOptions> used_;  // std::nullopt: those of the run
};

TEST_F(TrackingDumps, ReproduceTheRegistrationBitwise) {
  for (const SlamOptions& options : {SlamOptions(), OtherOptions()}) {
    Write(options);
    const TrackingDump dump = ReadTrackingDump(path());
    EXPECT_EQ(dump.frame, 17);
    EXPECT_EQ(dump.source.levels.back().noise.inverse_depth_sigma, kSigma);
    EXPECT_EQ(dump.target.levels.back().noise.inverse_depth_sigma, kSigma);
    EXPECT_EQ(dump.termination, ToString(result_.termination));
    const IcpResult again =
        Register(dump.source, dump.target, dump.target_from_source_initial, dump.icp);
    EXPECT_EQ(again.termination, result_.termination);
    EXPECT_EQ(again.target_from_source.Matrix(), result_.target_from_source.Matrix());
    EXPECT_EQ(again.information, result_.information);
    EXPECT_EQ(again.intensity_count, result_.intensity_count);
    EXPECT_EQ(again.intensity_count > 0, options.icp.error_model.UsesIntensities());
    ASSERT_EQ(again.iterations.size(), result_.iterations.size());
    ASSERT_GT(again.iterations.size(), 2u);
    for (std::size_t i = 0; i < again.iterations.size(); ++i) {
      EXPECT_EQ(again.iterations[i].average_loss, result_.iterations[i].average_loss);
    }
  }
}

TEST_F(TrackingDumps, KeepEveryOption) {
  const SlamOptions options = OtherOptions();
  Write(options);
  const IcpOptions read = ReadTrackingDump(path()).icp;
  const IcpOptions &icp = options.icp, defaults;
  EXPECT_EQ(read.solver, icp.solver);
  EXPECT_EQ(read.linear_solver, icp.linear_solver);
  EXPECT_EQ(read.residual, icp.residual);
  EXPECT_EQ(read.association, icp.association);
  EXPECT_EQ(read.error_model.kernel.type, icp.error_model.kernel.type);
  EXPECT_EQ(read.error_model.kernel.width, icp.error_model.kernel.width);
  EXPECT_EQ(read.error_model.photometric_weight, 0.3);
  EXPECT_EQ(read.error_model.intensity_sigma, 0.03);
  EXPECT_EQ(read.error_model.intensity_kernel.width, 2.9);
  EXPECT_EQ(read.gates.max_normal_angle_rad, 0.6);
  EXPECT_EQ(read.min_relative_rmse_change, icp.min_relative_rmse_change);
  EXPECT_EQ(read.max_free_space_violation_ratio, icp.max_free_space_violation_ratio);
  EXPECT_NE(read.max_free_space_violation_ratio, defaults.max_free_space_violation_ratio);
}

TEST_F(TrackingDumps, KeepTheIcpOptionsOfTheLostFrame) {
  used_.emplace().min_source_rows = 7;
  Write(SlamOptions());
  EXPECT_EQ(ReadTrackingDump(path()).icp.min_source_rows, 7);
}

TEST_F(TrackingDumps, RejectMalformedFiles) {
  ExpectInputError([] { ReadTrackingDump("nowhere"); }, Names("nowhere/frame.json"));
  Write(SlamOptions());
  folder_.Write("frame-000017/frame.json", "{\"frame\": 1}");
  ExpectInputError([&] { ReadTrackingDump(path()); }, Names("frame.json", "preprocess"));
  folder_.Write("frame-000017/frame.json", "nonsense");
  ExpectInputError([&] { ReadTrackingDump(path()); }, Names("frame.json"));
  Write(SlamOptions());
  folder_.Write("frame-000017/target.ply", ReadBytes(path() + "/source.ply").substr(0, 1000));
  ExpectInputError([&] { ReadTrackingDump(path()); }, Names("target.ply"));
}

}  // namespace
}  // namespace surfit::testing
