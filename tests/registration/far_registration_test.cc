#include <gmock/gmock.h>

#include "registration/simulated_views.h"
#include "surfit/core/options.h"
#include "surfit/registration/global_registration.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

// With exact depth, the error is a fraction of a pixel. A pixel is 1 / 131 rad, 15 mm at 2 m.
constexpr double kFarToleranceM = 0.01, kFarToleranceRad = 0.005;

// Views at a distance of 50 frames: at least 0.5 m and 20 degrees.
const SimulatedColoredViews& FarViews() {
  static const auto* const views = new SimulatedColoredViews(MakeColoredViews(70, 50, 12));
  return *views;
}

GlobalRegistrationResult Registered(const SimulatedColoredViews& views, const std::string& method) {
  InitializeOptions options;
  options.method = method;
  return RegisterGlobally(views.source, views.target, options, GlobalIcpOptions());
}

TEST(RegisterGlobally, FeaturesConvergeWithoutPrediction) {
  EXPECT_FALSE(Registered(FarViews(), "identity").accepted());
  const GlobalRegistrationResult result = Registered(FarViews(), "features");
  EXPECT_TRUE(result.accepted()) << ToString(result.reason);
  EXPECT_THAT(result.icp.target_from_source,
              RigidNear(FarViews().target_from_source, kFarToleranceM, kFarToleranceRad));
}

TEST(RegisterGlobally, ConvergesByGeometryOnly) {
  SimulatedColoredViews views = FarViews();
  views.source.color = {};
  const GlobalRegistrationResult result = Registered(views, "features");
  EXPECT_TRUE(result.accepted()) << ToString(result.reason);
  EXPECT_THAT(result.icp.target_from_source,
              RigidNear(views.target_from_source, kFarToleranceM, kFarToleranceRad));
}

TEST(RegisterGlobally, FindsPoseWithinBoundOnly) {
  InitializeOptions options;
  options.method = "features";
  const Rigid3d& motion = FarViews().target_from_source;
  const auto registered = [&](double ratio) {
    const MotionBound bound = {ratio * motion.translation.norm(),
                               ratio * RotationAngle(motion.rotation)};
    return RegisterGlobally(FarViews().source, FarViews().target, options, GlobalIcpOptions(),
                            bound);
  };
  const GlobalRegistrationResult result = registered(1.1);
  EXPECT_TRUE(result.accepted()) << ToString(result.reason);
  EXPECT_THAT(result.icp.target_from_source, RigidNear(motion, kFarToleranceM, kFarToleranceRad));
  EXPECT_FALSE(registered(0.2).accepted());
}

// Rooms of other seeds have only walls and floor in common.
TEST(RegisterGlobally, RejectsOtherPlaces) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SimulatedColoredViews views = MakeColoredViews(10, 1, seed);
    views.target = FarViews().target;
    EXPECT_FALSE(Registered(views, "features").accepted()) << seed;
  }
}

// A corner and the same corner with another texture: ICP converges, and only the images differ.
TEST(RegisterGlobally, RejectsSameGeometryWithOtherTexture) {
  Eigen::Matrix3d down_to_the_corner;
  down_to_the_corner.col(2) = Eigen::Vector3d(-1, -1, -0.8).normalized();
  down_to_the_corner.col(0) =
      down_to_the_corner.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  down_to_the_corner.col(1) = down_to_the_corner.col(2).cross(down_to_the_corner.col(0));
  const Rigid3d pose(down_to_the_corner, {1.2, 1.1, 1});
  const Rigid3d turn(QuaternionExp<double>({0.02, 0.05, 0}), {0.03, 0, 0.01});
  SimulatedColoredViews views;
  views.source = MakeColoredView(MakeScene("three_planes", 1), pose);
  views.target = MakeColoredView(MakeScene("three_planes", 1), pose * turn.Inverse());
  EXPECT_TRUE(Registered(views, "features").accepted());
  views.target.color = FarViews().target.color;
  EXPECT_EQ(Registered(views, "features").reason, GlobalRegistrationReason::kLooksDifferent);
}

TEST(RegisterGlobally, FailsWithoutDepth) {
  SimulatedColoredViews views = FarViews();
  for (FrameLevel& level : views.source.pyramid.levels) {
    level.vertex = VectorImage(level.camera.width, level.camera.height);
    level.normal = VectorImage(level.camera.width, level.camera.height);
  }
  for (const std::string& method : InitializeMethods()) {
    EXPECT_EQ(Registered(views, method).icp.termination, Termination::kTooFewInliers) << method;
  }
}

TEST(RegisterGlobally, IsBitwiseIdenticalWithOneAndTwoThreads) {
  const auto results = AtThreads({1, 2}, [&] { return Registered(FarViews(), "features"); });
  EXPECT_EQ(results[0].icp.target_from_source.Matrix(), results[1].icp.target_from_source.Matrix());
  EXPECT_EQ(results[0].score_margin, results[1].score_margin);
}

TEST(ViolatedCriterion, HasDistanceAndAngleWithTheirLimits) {
  const FitCriteria fit;
  GlobalRegistrationResult verdict;
  verdict.reason = GlobalRegistrationReason::kInconsistent;
  verdict.disagreement_m = 0.002;
  verdict.disagreement_rad = 0.5;
  EXPECT_EQ(ViolatedCriterion(verdict, fit),
            "forward-backward disagreement is 0.002 m and 0.5 rad, must be at most 0.01 m and 0.01 "
            "rad");
  verdict.reason = GlobalRegistrationReason::kDegenerate;
  verdict.sigma_m = 0.003;
  verdict.sigma_rad = 0.04;
  EXPECT_EQ(ViolatedCriterion(verdict, fit),
            "largest standard deviations are 0.003 m and 0.04 rad, must be at most 0.01 m and 0.01 "
            "rad");
  verdict.sigma_m = verdict.sigma_rad = 0;  // not computed: the pose is unobservable
  EXPECT_EQ(ViolatedCriterion(verdict, fit), "");
}

TEST(InitializeOptions, RejectInvalidValues) {
  const auto expect_refused = ExpectOptionsRefused<InitializeOptions>;
  Validate(InitializeOptions());
  expect_refused([](auto& o) { o.method = "magic"; }, "method", "magic");
  expect_refused([](auto& o) { o.fit.min_overlap_ratio = 1.1; }, "fit.min_overlap_ratio", "1.1");
  expect_refused([](auto& o) { o.fit.min_value_correlation = -1.5; }, "fit.min_value_correlation",
                 "-1.5");
  expect_refused([](auto& o) { o.fit.min_detail_correlation = 2; }, "fit.min_detail_correlation",
                 "2");
  expect_refused([](auto& o) { o.fit.min_score_margin = -1; }, "fit.min_score_margin", "-1");
}

}  // namespace
}  // namespace surfit::testing
