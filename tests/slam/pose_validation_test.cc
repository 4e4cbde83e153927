#include "tracking/pose_validation.h"

#include <gtest/gtest.h>

#include <vector>

#include "slam/simulated_sequence.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rectify_frame.h"
#include "testing/matchers.h"
#include "tracking/moving_regions.h"
#include "tracking/view_comparison.h"

namespace surfit::testing {
namespace {

IcpResult GoodFit() {
  IcpResult icp;
  icp.termination = Termination::kConverged;
  icp.inlier_ratio = 0.8;
  icp.rmse_m = 0.003;
  return icp;
}

ViewComparison Views(int in_front, int behind, double alike = 0.9) {
  ViewComparison views;
  views.points = views.compared = 1000;
  views.in_front = in_front;
  views.behind = behind;
  views.alike = alike;
  return views;
}

TEST(PoseValidation, DependsOnSurfacesAndBrightness) {
  const SlamOptions options;
  EXPECT_EQ(ValidateRegistration(GoodFit(), Views(20, 20), 0, options), Verdict::kAccepted);
  EXPECT_EQ(ValidateRegistration(GoodFit(), Views(100, 80), 0, options), Verdict::kUncertain);
  EXPECT_EQ(ValidateRegistration(GoodFit(), Views(200, 100), 0, options), Verdict::kRejected);
  EXPECT_EQ(ValidateRegistration(GoodFit(), Views(20, 20, 0.4), 0, options), Verdict::kUncertain);
  EXPECT_EQ(ValidateRegistration(GoodFit(), Views(20, 20, 0.1), 0, options), Verdict::kRejected);
  EXPECT_EQ(ValidateRegistration(GoodFit(), Views(100, 80, 0.4), 0, options), Verdict::kRejected);
}

TEST(PoseValidation, IgnoresMovingCellsAndRequiresOtherCellsToAgree) {
  const SlamOptions options;
  EXPECT_EQ(ValidateRegistration(GoodFit(), Views(400, 20), 390, options), Verdict::kAccepted);
  EXPECT_EQ(ValidateRegistration(GoodFit(), Views(400, 20), 0, options), Verdict::kRejected);
  EXPECT_EQ(ValidateRegistration(GoodFit(), Views(400, 100), 390, options), Verdict::kRejected);
}

// Few inliers are enough for an uncertain pose if correspondences agree and constrain all
// directions.
TEST(PoseValidation, FewInliersNeedAgreementAndConstraints) {
  const SlamOptions options;
  IcpResult icp = GoodFit();
  icp.inlier_ratio = 0.5 * options.min_inlier_ratio;
  icp.inlier_count = 900;
  icp.system.pair_count = 1000;
  icp.eigenvalues.setConstant(2 * options.min_turn_eigenvalue);
  EXPECT_EQ(ValidateRegistration(icp, Views(20, 20), 0, options), Verdict::kUncertain);
  EXPECT_EQ(ValidateRegistration(icp, Views(400, 20), 390, options), Verdict::kUncertain);
  IcpResult weak = icp;
  weak.eigenvalues[0] = 0.5 * options.min_turn_eigenvalue;
  EXPECT_EQ(ValidateRegistration(weak, Views(20, 20), 0, options), Verdict::kRejected);
  IcpResult split = icp;
  split.inlier_count = 700;
  EXPECT_EQ(ValidateRegistration(split, Views(20, 20), 0, options), Verdict::kRejected);
  ViewComparison unknown = Views(20, 20);
  unknown.compared = 200;
  EXPECT_EQ(ValidateRegistration(icp, unknown, 0, options), Verdict::kRejected);
}

TEST(PoseValidation, RejectsFailedRegistration) {
  const SlamOptions options;
  IcpResult icp = GoodFit();
  icp.inlier_ratio = 0.9 * options.min_inlier_ratio;
  EXPECT_EQ(ValidateRegistration(icp, Views(0, 0), 0, options), Verdict::kRejected);
  icp = GoodFit();
  icp.rmse_m = 1.1 * options.max_rmse_m;
  EXPECT_EQ(ValidateRegistration(icp, Views(0, 0), 0, options), Verdict::kRejected);
  icp = GoodFit();
  icp.termination = Termination::kTooFewInliers;
  EXPECT_EQ(ValidateRegistration(icp, Views(0, 0), 0, options), Verdict::kRejected);
}

TEST(PoseValidation, LimitsMotionOfHand) {
  const auto motion = [](double way_m, double turn_rad) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY()));
    return Rigid3d(turn, Eigen::Vector3d(way_m, 0, 0));
  };
  EXPECT_TRUE(PossibleMotion(1. / 30).Allows(motion(0.15, 0.3)));
  EXPECT_FALSE(PossibleMotion(1. / 30).Allows(motion(1, 0)));
  EXPECT_FALSE(PossibleMotion(1. / 30).Allows(motion(0, 1)));
  EXPECT_TRUE(PossibleMotion(1).Allows(motion(1, 1)));
}

FrameLevel SurfaceOf(const RgbdFrame& frame) {
  const FramePyramid pyramid = PreprocessDepth(frame.depth_m, {SimulatedCamera(), {}}, {});
  return pyramid.levels.front();
}

Image<float> GreyOfCells(const Image<Rgb8>& color) {
  const ViewGrid grid(SimulatedCamera());
  Image<float> grey(grid.width, grid.height);
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) grey(u, v) = GreyOf(color(grid.Pixel(u), grid.Pixel(v)));
  }
  return grey;
}

// Two frames of a simulated room, at a distance of 10 frames, with ground truth.
TEST(ViewComparison, CountsContradictionsOfCorrectAndWrongPose) {
  const SimulatedSequence& room = IdealRoom();
  const RgbdFrame &model = room.frames[0], &frame = room.frames[10];
  const Rigid3d model_from_frame = room.world_from_camera[0].Inverse() * room.world_from_camera[10];
  const auto compare = [&](const Rigid3d& pose) {
    return CompareViews(SurfaceOf(frame), frame.color, SurfaceOf(model), GreyOfCells(model.color),
                        ErrorModel(), pose);
  };
  const ViewComparison right = compare(model_from_frame);
  EXPECT_GT(right.compared, 0.6 * right.points);
  EXPECT_LT(right.in_front + right.behind, 0.05 * right.compared);
  EXPECT_GT(right.alike, 0.8);
  const Rigid3d shift(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.15, 0.1, 0.2));
  const ViewComparison wrong = compare(shift * model_from_frame);
  EXPECT_GT(wrong.in_front + wrong.behind, 0.3 * wrong.compared);
}

// The frame shows a wall in front of the wall of the model.
TEST(ViewComparison, ToleratesNoiseOfBothViews) {
  const DepthNoise noise;
  const ErrorModel error_model;
  const auto wall_at = [](double depth_m) {
    RgbdFrame wall;
    wall.depth_m = Image<float>(160, 120, static_cast<float>(depth_m));
    return SurfaceOf(wall);
  };
  // Five sigmas. The sigma of the frame is computed at about 1.9 m.
  const double bound_m = 5 * std::hypot(error_model.Sigma(1.9, noise), noise.SigmaZ(2));
  const auto share_in_front = [&](double height_m) {
    const ViewComparison views =
        CompareViews(wall_at(2 - height_m), {}, wall_at(2), {}, error_model, Rigid3d());
    return static_cast<double>(views.in_front) / views.compared;
  };
  EXPECT_EQ(share_in_front(0.95 * bound_m), 0);
  EXPECT_EQ(share_in_front(1.05 * bound_m), 1);
}

// Frame with a ball of 0.25 m radius in front of the camera.
RgbdFrame WithBall(int i, double across_m) {
  const Rigid3d& world_from_camera = IdealRoom().world_from_camera[i];
  Scene scene = MakeScene("room", 1);
  const Eigen::Vector3d place = world_from_camera * Eigen::Vector3d(across_m, 0, 0.9);
  scene.Add(MakeSphere(0.25), Rigid3d(Eigen::Quaterniond::Identity(), place),
            [](const Eigen::Vector3d&) { return Eigen::Vector3f(0.6f, 0.3f, 0.2f); });
  RgbdFrame frame = RenderFrame(scene, SimulatedCamera(), world_from_camera, i, i / 30.);
  frame.color_stamp_s = frame.stamp_s;
  return frame;
}

// Ratio of moving cells in frame 20. The model does not contain the ball. `before` is the view 15
// frames earlier.
double MovingRatio(const RgbdFrame& before, const RgbdFrame& now) {
  const SimulatedSequence& room = IdealRoom();
  const Rigid3d &then = room.world_from_camera[5], &here = room.world_from_camera[20];
  MovingRegions regions;
  regions.Remember(SurfaceOf(before), {}, then, 5 / 30.);
  const FrameLevel frame = SurfaceOf(now);
  const ViewComparison views =
      CompareViews(frame, {}, SurfaceOf(room.frames[20]), {}, ErrorModel(), Rigid3d());
  const CellMask moving = regions.Find(frame, views, here, 20 / 30.);
  return static_cast<double>(moving.size() - std::count(moving.begin(), moving.end(), 0)) /
         views.points;
}

TEST(MovingRegions, AreSurfacesInRecentFreeSpace) {
  const SimulatedSequence& room = IdealRoom();
  const double arrived = MovingRatio(room.frames[5], WithBall(20, 0));
  EXPECT_GT(arrived, 0.1);
  EXPECT_LT(arrived, 0.5);
  EXPECT_GT(MovingRatio(WithBall(5, 0.3), WithBall(20, 0)), 0.1);
  EXPECT_EQ(MovingRatio(room.frames[5], room.frames[20]), 0);
}

// A surface that the model does not contain, but that an earlier frame observed, is new and static.
TEST(MovingRegions, ExcludeNewStaticSurfaces) {
  const SimulatedSequence& room = IdealRoom();
  const Eigen::Vector3d place = room.world_from_camera[20] * Eigen::Vector3d(0, 0, 0.9);
  const Eigen::Vector3d in_camera = room.world_from_camera[5].Inverse() * place;
  Scene scene = MakeScene("room", 1);
  scene.Add(MakeSphere(0.25), Rigid3d(Eigen::Quaterniond::Identity(), place),
            [](const Eigen::Vector3d&) { return Eigen::Vector3f(0.6f, 0.3f, 0.2f); });
  ASSERT_GT(in_camera.z(), 0.5);
  EXPECT_EQ(
      MovingRatio(RenderFrame(scene, SimulatedCamera(), room.world_from_camera[5], 5, 5 / 30.),
                  RenderFrame(scene, SimulatedCamera(), room.world_from_camera[20], 20, 20 / 30.)),
      0);
}

// Starting with frame 6, a ball swings in front of the camera, at up to 0.6 m/s.
TEST(Slam, MovingObjectsAreNeitherTrackedNorFused) {
  const SimulatedSequence& room = IdealRoom();
  Slam slam({room.camera, {}}, SlamOptions(), room.world_from_camera[0]);
  for (int i = 0; i < 25; ++i) {
    const bool has_ball = i >= 6;
    const FrameReport report =
        slam.Process(has_ball ? WithBall(i, 0.2 * std::sin(0.1 * i)) : room.frames[i]);
    ASSERT_NE(report.state, FrameState::kLost) << i;
    EXPECT_THAT(report.world_from_camera,
                RigidNear(room.world_from_camera[i], kPixelAt2m, kPixelRad))
        << i;
    EXPECT_EQ(report.moving_ratio > 0.1, has_ball) << i;
  }
}

// A square at 1 m moves to the right, in front of a wall at 2 m. A shelf at 1 m is below the
// square.
TEST(MovingRegions, FollowsObjectThroughLostFrames) {
  const auto view_at = [](int left) {
    RgbdFrame frame = IdealRoom().frames[0];
    for (int v = 0; v < frame.depth_m.height(); ++v) {
      for (int u = 0; u < frame.depth_m.width(); ++u) {
        const bool is_square = v >= 30 && v < 70 && u >= left && u < left + 40;
        frame.depth_m(u, v) = is_square || v >= 70 ? 1 : 2;
      }
    }
    return SurfaceOf(frame);
  };
  const FrameLevel first = view_at(40);
  const ViewGrid grid(first.camera);
  const auto is_square = [&](int cell_u, int cell_v, int left) {
    const int u = grid.Pixel(cell_u), v = grid.Pixel(cell_v);
    return v >= 30 && v < 70 && u >= left && u < left + 40;
  };
  CellMask moving(grid.width, grid.height, 0);
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) moving(u, v) = is_square(u, v, 40) ? 2 : 0;
  }
  MovingRegions regions;
  regions.Remember(first, moving, Rigid3d(), 0);
  EXPECT_TRUE(regions.Followed().empty());
  for (int i = 1; i <= 8; ++i) regions.Follow(view_at(40 + 4 * i));
  const CellMask followed = regions.Followed();
  ASSERT_FALSE(followed.empty());
  constexpr int kMargin = 5;  // cells
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      if (is_square(u, v, 72)) {
        EXPECT_NE(followed(u, v), 0) << u << " " << v;
      }
      const bool is_distant =
          grid.Pixel(v) >= 70 + kMargin * grid.step || grid.Pixel(u) < 72 - kMargin * grid.step;
      if (is_distant) {
        EXPECT_EQ(followed(u, v), 0) << u << " " << v;
      }
    }
  }
}

}  // namespace
}  // namespace surfit::testing
