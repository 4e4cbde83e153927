#include "surfit/registration/icp.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "registration/icp/icp_level.h"
#include "registration/simulated_views.h"
#include "registration/three_planes.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/association.h"
#include "surfit/registration/pose_solver.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

// A pixel of 1/131 rad is 23 mm wide at 3 m. A surface fitted to thousands of pixels has a small
// fraction of this error. The align program has a tolerance of 3 mm and 0.1 deg at full resolution.
constexpr double kIcpToleranceM = 0.003;
constexpr double kIcpToleranceRad = 0.1 * M_PI / 180;

TEST(Register, FindsMotionOfHandHeldCamera) {
  for (const std::uint64_t seed : {1, 2}) {
    for (const int gap : {1, 5}) {
      const SimulatedViews views = MakeViews(3, gap, seed);
      const IcpResult result = Register(views.source, views.target, Rigid3d(), IcpOptions());
      EXPECT_TRUE(result.Succeeded());
      EXPECT_THAT(result.target_from_source,
                  RigidNear(views.target_from_source, kIcpToleranceM, kIcpToleranceRad))
          << "seed " << seed << ", gap " << gap;
    }
  }
}

TEST(Register, FindsMotionOfTenFrames) {
  const SimulatedViews views = MakeViews(20, 10);
  ASSERT_GT(RotationAngle(views.target_from_source.rotation), 7 * M_PI / 180);
  const IcpResult result = Register(views.source, views.target, Rigid3d(), IcpOptions());
  EXPECT_EQ(result.termination, Termination::kConverged);
  EXPECT_THAT(result.target_from_source,
              RigidNear(views.target_from_source, kIcpToleranceM, kIcpToleranceRad));
}

TEST(Register, AllSolversAgree) {
  const SimulatedViews views = MakeViews(3, 5);
  IcpOptions options;
  options.min_relative_rmse_change = 0;  // all solvers converge to the same point
  options.stop_at_rmse_increase = false;
  options.min_increment = 1e-8;
  options.max_iterations = 30;
  const Rigid3d expected =
      Register(views.source, views.target, Rigid3d(), options).target_from_source;
  for (const std::string& name : PointToPlaneSolverNames()) {
    options.solver = name;
    // LDLT and LU use single-precision sums, so the last steps differ by a relative 1e-6. One pixel
    // in 20,000 may change its correspondence.
    EXPECT_THAT(Register(views.source, views.target, Rigid3d(), options).target_from_source,
                RigidNear(expected, 1e-6, 1e-6))
        << name;
  }
}

TEST(Register, ReportsIterationsAndFinalState) {
  const SimulatedViews views = MakeViews(3, 5);
  const IcpOptions options;
  const IcpResult result = Register(views.source, views.target, Rigid3d(), options);
  ASSERT_EQ(views.source.levels.size(), 3u);
  ASSERT_FALSE(result.iterations.empty());
  // Levels are coarse to fine, complete, and within the maximum number of iterations.
  std::vector<int> on_level(3, 0);
  int last_level = 2;
  for (const IcpIteration& iteration : result.iterations) {
    EXPECT_LE(iteration.level, last_level);
    last_level = iteration.level;
    ++on_level[iteration.level];
    EXPECT_GT(iteration.inlier_count, 0);
    EXPECT_GT(iteration.average_loss, 0);
  }
  EXPECT_EQ(result.step_count, static_cast<int>(result.iterations.size()) - 3);
  for (const int count : on_level) {
    EXPECT_GE(count, 2);
    EXPECT_LE(count, options.max_iterations + 1);  // steps and the final state
  }
  // At an initial error of 7 cm, the loss decreases in each of the first steps.
  EXPECT_LT(result.iterations[1].average_loss, result.iterations[0].average_loss);
  EXPECT_LT(result.iterations[2].average_loss, result.iterations[1].average_loss);

  // The final state is described on the finest level, at the returned pose.
  const ProjectiveAssociation association(views.source.levels[0], views.target.levels[0],
                                          options.gates, options.error_model);
  const NormalSystem system = Linearize(association, result.target_from_source,
                                        ResidualType::kPointToPlane, options.error_model.kernel);
  EXPECT_EQ(result.inlier_count, system.inlier_count);
  EXPECT_EQ(result.iterations.back().inlier_count, system.inlier_count);
  EXPECT_EQ(result.iterations.back().average_loss, system.AverageLoss());
  EXPECT_EQ(result.rmse_m, std::sqrt(system.AverageLoss()));
  EXPECT_TRUE(result.information == system.hessian);
  EXPECT_TRUE(result.eigenvalues == Observe(system, options.observability).eigenvalues);
  EXPECT_GT(result.eigenvalues[0], options.observability.min_eigenvalue);
  EXPECT_TRUE(result.degenerate_directions.empty());
  ASSERT_TRUE(result.covariance);
  EXPECT_TRUE(*result.covariance == CovarianceOf(system));
  const auto& z = views.source.levels[0].vertex.z;
  const auto valid = std::count_if(z.begin(), z.end(), [](float depth) { return depth > 0; });
  EXPECT_NEAR(result.inlier_ratio, static_cast<double>(result.inlier_count) / valid, 1e-15);
  EXPECT_TRUE(result.information == result.information.transpose());
}

TEST(Register, GatesGrowOnCoarserLevels) {
  // The motion is 15 mm and one degree: far above the gate of 0.1 mm, and far below 30^2 times the
  // gate.
  const SimulatedViews views = MakeViews(3, 1);
  IcpOptions options;
  options.gates.max_distance_m = 1e-4;
  options.gate_growth = 1;
  EXPECT_EQ(Register(views.source, views.target, Rigid3d(), options).termination,
            Termination::kTooFewInliers);
  options.gate_growth = 30;
  const IcpResult result = Register(views.source, views.target, Rigid3d(), options);
  EXPECT_EQ(result.iterations.front().level, 2);
  EXPECT_GT(result.iterations.back().level, -1);
  EXPECT_LT(result.iterations.back().level, 2);
}

TEST(Register, ReportsTooFewInliers) {
  const SimulatedViews views = MakeViews(3, 1);
  IcpOptions options;
  options.min_inliers = 1'000'000;
  const IcpResult by_count = Register(views.source, views.target, Rigid3d(), options);
  EXPECT_EQ(by_count.termination, Termination::kTooFewInliers);
  EXPECT_FALSE(by_count.Succeeded());
  EXPECT_EQ(by_count.iterations.size(), 1u);
  EXPECT_GT(by_count.inlier_count, 0);

  options = IcpOptions();
  options.min_inlier_ratio = 1;
  EXPECT_EQ(Register(views.source, views.target, Rigid3d(), options).termination,
            Termination::kTooFewInliers);

  const Rigid3d around(QuaternionExp<double>({0, M_PI, 0}), {0, 0, 0});
  const IcpResult apart = Register(views.source, views.target, around, IcpOptions());
  EXPECT_EQ(apart.termination, Termination::kTooFewInliers);
  EXPECT_THAT(apart.target_from_source, RigidNear(around, 0, 1e-15));
}

// An occluder leaves a sixth of the image: less than 200 points of the coarsest level.
TEST(Register, ConvergesWithSmallPartOfImage) {
  const SimulatedViews views = MakeViews(3, 1);
  const auto& [scene, path] = MakeRoomWithPath(5, 1);
  RgbdFrame frame = RenderFrame(scene, ViewCamera(), path[3].world_from_camera);
  for (int y = 0; y < frame.depth_m.height(); ++y) {
    for (int x = 0; x < frame.depth_m.width(); ++x) {
      if (x < 48 || x >= 48 + 64 || y < 36 || y >= 36 + 48) frame.depth_m(x, y) = 0;
    }
  }
  const FramePyramid part = PreprocessDepth(frame.depth_m, {ViewCamera(), {}}, PreprocessOptions());
  const IcpResult result = Register(part, views.target, Rigid3d(), IcpOptions());
  EXPECT_TRUE(result.Succeeded()) << ToString(result.termination);
  EXPECT_EQ(result.iterations.front().level, 2);
  EXPECT_LT(result.iterations.front().inlier_count, 200);
  EXPECT_THAT(result.target_from_source,
              RigidNear(views.target_from_source, kIcpToleranceM, kIcpToleranceRad));
}

TEST(Register, FramesWithoutDepthHaveTooFewInliers) {
  const FramePyramid view = OneLevel(RenderCorner(PoseBeforeTheCorner()));
  const FramePyramid nothing = OneLevel(RenderCorner(PoseBeforeTheCorner(), 0));
  for (const auto* source : {&view, &nothing}) {
    const IcpResult result = Register(*source, nothing, Rigid3d(), IcpOptions());
    EXPECT_EQ(result.termination, Termination::kTooFewInliers);
    EXPECT_EQ(result.inlier_count, 0);
    EXPECT_EQ(result.inlier_ratio, 0);
    EXPECT_EQ(result.rmse_m, 0);
    EXPECT_TRUE(result.target_from_source.Matrix().allFinite());
  }
  EXPECT_EQ(Register(FramePyramid(), FramePyramid(), Rigid3d(), IcpOptions()).termination,
            Termination::kTooFewInliers);
}

TEST(Register, UsesCommonLevels) {
  SimulatedViews views = MakeViews(3, 1);
  views.target.levels.pop_back();
  const IcpResult result = Register(views.source, views.target, Rigid3d(), IcpOptions());
  EXPECT_TRUE(result.Succeeded());
  EXPECT_EQ(result.iterations.front().level, 1);
}

TEST(Register, StopsAtThresholdsOfOptions) {
  const SimulatedViews views = MakeViews(3, 5);
  IcpOptions options;
  options.min_relative_rmse_change = 0;
  options.stop_at_rmse_increase = false;
  options.min_increment = 0;
  options.max_iterations = 4;
  const IcpResult all = Register(views.source, views.target, Rigid3d(), options);
  EXPECT_EQ(all.termination, Termination::kMaxIterations);
  EXPECT_EQ(all.step_count, 12);

  options.min_increment = 10;  // every step is smaller
  const IcpResult one = Register(views.source, views.target, Rigid3d(), options);
  EXPECT_EQ(one.termination, Termination::kConverged);
  EXPECT_EQ(one.step_count, 3);

  options.min_increment = 0;
  options.min_relative_rmse_change = 1e9;  // every change is smaller: ends at the second iteration
  EXPECT_EQ(Register(views.source, views.target, Rigid3d(), options).step_count, 6);
}

TEST(Register, EndsCoarseLevelsByStepInPixels) {
  const SimulatedViews views = MakeViews(3, 5);
  IcpOptions options;
  options.min_relative_rmse_change = 0;
  options.stop_at_rmse_increase = false;
  options.min_increment = 0;
  options.max_iterations = 4;
  options.min_coarse_step_px = 1000;  // every step is smaller
  const IcpResult result = Register(views.source, views.target, Rigid3d(), options);
  EXPECT_EQ(result.step_count, 1 + 1 + 4);
  EXPECT_EQ(result.termination, Termination::kMaxIterations);  // of the finest level
  // 7 cm at 3 m and a few degrees: the first steps are larger than a pixel of 1/33 rad, and the
  // last steps are smaller.
  options.max_iterations = 10;
  options.min_coarse_step_px = 1;
  const IcpResult some = Register(views.source, views.target, Rigid3d(), options);
  EXPECT_GT(some.step_count, 1 + 1 + 10);
  EXPECT_LT(some.step_count, 10 + 10 + 10);
}

TEST(Register, CanSkipMiddleLevels) {
  const SimulatedViews views = MakeViews(3, 5);
  IcpOptions options;
  options.middle_levels = false;
  const IcpResult result = Register(views.source, views.target, Rigid3d(), options);
  EXPECT_EQ(result.termination, Termination::kConverged);
  EXPECT_EQ(result.iterations.front().level, 2);
  EXPECT_EQ(result.iterations.back().level, 0);
  for (const IcpIteration& iteration : result.iterations) EXPECT_NE(iteration.level, 1);
  EXPECT_THAT(result.target_from_source,
              RigidNear(views.target_from_source, kIcpToleranceM, kIcpToleranceRad));
}

// The growth by level affects the first iteration of the coarsest level.
TEST(Register, GatesAndKernelGrowByOptions) {
  const SimulatedViews views = MakeViews(3, 5);
  IcpOptions options;
  options.gate_growth = 3;
  options.kernel_growth = 2;
  const IcpResult result = Register(views.source, views.target, Rigid3d(), options);
  const double distance_m = 9 * options.gates.max_distance_m;
  ErrorModel model = options.error_model;
  model.kernel.width *= 4;
  const ProjectiveAssociation association(views.source.levels[2], views.target.levels[2],
                                          {distance_m, options.gates.max_normal_angle_rad}, model);
  const NormalSystem system =
      Linearize(association, Rigid3d(), ResidualType::kPointToPlane, model.kernel);
  EXPECT_NEAR(result.iterations[0].average_loss, system.AverageLoss(),
              1e-6 * system.AverageLoss());  // rounding of powers can differ
  EXPECT_NEAR(result.iterations[0].inlier_count, system.inlier_count, 1);
}

TEST(Register, IsTheSameAtAnyNumberOfThreads) {
  const SimulatedViews views = MakeViews(3, 5);
  const auto pose = [&](int threads, const std::string& solver) {
    const ThreadLimit limit(threads);
    IcpOptions options;
    options.solver = solver;
    return Register(views.source, views.target, Rigid3d(), options).target_from_source.Matrix();
  };
  for (const std::string& solver : PointToPlaneSolverNames()) {
    const Eigen::Matrix4d expected = pose(1, solver);
    for (const int threads : {2, 4}) EXPECT_TRUE(pose(threads, solver) == expected) << solver;
  }
}

}  // namespace
}  // namespace surfit::testing
