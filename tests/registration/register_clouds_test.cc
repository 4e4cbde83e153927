#include "surfit/registration/register_clouds.h"

#include <gmock/gmock.h>

#include <optional>
#include <random>
#include <utility>

#include "testing/matchers.h"
#include "testing/random_pose.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr float kSigma_m = 0.002f;

// Corner of three walls of 1 m, at 2 m from the origin, with 1 point per square centimetre and
// noise along the normals.
PointSet Corner(double sigma_m, int seed) {
  constexpr int kPointsOfWall = 10000;
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> noise(0, 1);
  PointSet set;
  for (int wall = 0; wall < 3; ++wall) {
    for (int i = 0; i < kPointsOfWall; ++i) {
      Eigen::Vector3d point(uniform(rng), uniform(rng), uniform(rng));
      point[wall] = sigma_m * noise(rng);
      set.Add((point + Eigen::Vector3d(-0.5, -0.5, 2)).cast<float>(), Eigen::Vector3f::Unit(wall),
              kSigma_m);
    }
  }
  return set;
}

PointSet Moved(PointSet set, const Rigid3d& pose) {
  for (auto& point : set.points) point = (pose * point.cast<double>()).cast<float>();
  for (auto& normal : set.normals) normal = (pose.rotation * normal.cast<double>()).cast<float>();
  return set;
}

// Other points of the same planes are exact, except for rounding: 1.2e-7 for each of N = 30,000
// coordinates up to 2.5. So the random error of the plane is below 1e-8. A common bias of p' = R p
// + t stays below 2.4e-7.
TEST(RegisterClouds, RecoversEachDegreeOfFreedom) {
  const PointSet target = Corner(0, 1), corner = Corner(0, 2);
  RegisterCloudsOptions options;
  options.icp.max_iterations = 30;
  for (const Vector6d& motion : EachDirection(0.05, 0.1)) {
    const Rigid3d truth = LeftIncrement<double>(motion, Rigid3d());
    const IcpResult result =
        RegisterClouds(Moved(corner, truth.Inverse()), target, Rigid3d(), options);
    EXPECT_TRUE(result.Succeeded());
    EXPECT_THAT(result.target_from_source, RigidNear(truth, 1e-6, 1e-6));
  }
}

// A wall has N = 10,000 points with an RMS distance of 0.41 m to its centre. It constrains two
// rotations to sqrt(2) sigma / (0.41 sqrt(N)) = 7e-5 rad, with the noise of both clouds. 4 sigma of
// three rotations is 4.8e-4 rad, and 1.1 mm at the origin, 2.3 m away.
TEST(RegisterClouds, FindsMotionOfNoisyClouds) {
  std::mt19937_64 rng(5);
  for (int i = 0; i < 3; ++i) {
    const Rigid3d truth = RandomPose(0.05, 0.1, &rng);
    for (const bool reciprocal : {false, true}) {
      RegisterCloudsOptions options;
      options.reciprocal = reciprocal;
      const IcpResult result = RegisterClouds(Moved(Corner(0.002, 7), truth.Inverse()),
                                              Corner(0.002, 6), Rigid3d(), options);
      EXPECT_TRUE(result.Succeeded());
      EXPECT_THAT(result.target_from_source, RigidNear(truth, 1.1e-3, 4.8e-4));
    }
  }
}

TEST(RegisterClouds, StartsWithTheCoarsestGateForAnyNumberOfPoints) {
  const auto coarsest = [](int count, int levels) {
    PointSet set = Corner(0, 1);
    set.points.resize(count), set.normals.resize(count), set.sigma_m.resize(count);
    RegisterCloudsOptions options;
    options.levels = levels;
    return RegisterClouds(set, Corner(0, 2), Rigid3d(), options).iterations.front().level;
  };
  EXPECT_EQ(coarsest(30000, 4), 3);
  EXPECT_EQ(coarsest(30000, 2), 1);
  EXPECT_EQ(coarsest(500, 4), 3);
}

SensedCloud Sensed(PointSet set) {
  SensedCloud cloud;
  cloud.points = std::move(set);
  cloud.has_signed_normals = true;
  return cloud;
}

// Corner of walls with different sizes and a box, so that no rotation maps it to itself.
PointSet CornerWithBox(double sigma_m, int seed) {
  PointSet set = Corner(sigma_m, seed);
  for (auto& point : set.points) point.y() *= 1.8f, point.z() = 2 + 0.6f * (point.z() - 2);
  std::mt19937_64 rng(seed + 50);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d point(0.2 + 0.3 * uniform(rng), -0.3 + 0.2 * uniform(rng), 2.25);
    set.Add(point.cast<float>(), Eigen::Vector3f::UnitZ(), kSigma_m);
    const Eigen::Vector3d side(0.2, -0.3 + 0.2 * uniform(rng), 2 + 0.25 * uniform(rng));
    set.Add(side.cast<float>(), -Eigen::Vector3f::UnitX(), kSigma_m);
  }
  return set;
}

// The tolerance is that of FindsMotionOfNoisyClouds, for coordinates up to 10 m from the origin.
TEST(RegisterCloudsFrom, FindsAnyPoseByAutoAndGlobal) {
  std::mt19937_64 rng(9);
  for (const char* method : {"auto", "global"}) {
    const Rigid3d truth = RandomPose(2, 5, &rng);
    CloudStartOptions start;
    start.method = method;
    RegisterCloudsOptions options;
    options.icp.gates.max_distance_m = 0;
    const CloudRegistration result =
        RegisterCloudsFrom(Sensed(Moved(CornerWithBox(0.002, 7), truth.Inverse())),
                           Sensed(CornerWithBox(0.002, 6)), std::nullopt, start, options);
    EXPECT_TRUE(result.accepted()) << ToString(result.reason);
    EXPECT_EQ(result.start, "global");
    EXPECT_THAT(result.icp.target_from_source, RigidNear(truth, 5e-3, 4.8e-4));
  }
}

// A wall does not constrain two translations and the rotation about its normal.
// The part has 8 % of the surface, which is less than IcpOptions::min_inlier_ratio. The limit must
// not apply to the backward registration, because each point of the part has a correspondence.
TEST(RegisterCloudsFrom, AcceptsSmallPartOfLargeCloud) {
  constexpr float kPart_m = 0.28f;
  const PointSet all = Corner(kSigma_m, 1), other = Corner(kSigma_m, 2);
  PointSet part;
  for (std::size_t i = 0; i < other.size(); ++i) {
    const Eigen::Vector3f from_corner = other.points[i] - Eigen::Vector3f(-0.5f, -0.5f, 2);
    if (from_corner.maxCoeff() < kPart_m)
      part.Add(other.points[i], other.normals[i], other.sigma_m[i]);
  }
  ASSERT_LT(part.size(), 0.09 * all.size());
  CloudStartOptions start;
  start.method = "identity";
  RegisterCloudsOptions options;
  options.icp.gates.max_distance_m = 0;
  const CloudRegistration result =
      RegisterCloudsFrom(Sensed(part), Sensed(all), std::nullopt, start, options);
  EXPECT_EQ(ToString(result.reason), "accepted");
  EXPECT_THAT(result.icp.target_from_source, RigidNear(Rigid3d(), 0.005, 0.005));
}

TEST(RegisterCloudsFrom, RejectsNoisyWallAsDegenerate) {
  const auto wall = [](int seed) {
    PointSet set = Corner(0.002, seed);
    set.points.erase(set.points.begin(), set.points.begin() + 20000);
    CloudSensor sensor;
    sensor.noise.inverse_depth_sigma = 0;
    set.normals = EstimateCloudNormals(set.points, sensor, {}).normals;
    set.sigma_m.resize(set.points.size());
    return Sensed(std::move(set));
  };
  RegisterCloudsOptions options;
  options.icp.gates.max_distance_m = 0;
  const CloudRegistration result = RegisterCloudsFrom(wall(1), wall(2), std::nullopt, {}, options);
  EXPECT_EQ(ToString(result.reason), "degenerate");
  EXPECT_EQ(result.icp.degenerate_directions.size(), 3u);
}

TEST(RegisterCloudsFrom, IsTheSameAtAnyNumberOfThreads) {
  const Rigid3d moved(QuaternionExp<double>({0.8, 0.4, 0}), {0.5, 0, 0.2});
  CloudStartOptions start;
  start.method = "global";
  RegisterCloudsOptions options;
  options.icp.gates.max_distance_m = 0;
  const auto results = AtThreads({1, 4}, [&] {
    return RegisterCloudsFrom(Sensed(Moved(CornerWithBox(0.002, 1), moved)),
                              Sensed(CornerWithBox(0.002, 2)), std::nullopt, start, options);
  });
  EXPECT_EQ(results[0].icp.target_from_source.Matrix(), results[1].icp.target_from_source.Matrix());
  EXPECT_EQ(results[0].icp.information, results[1].icp.information);
  EXPECT_EQ(results[0].score_margin, results[1].score_margin);
}

TEST(RegisterCloudsFrom, RejectsInvalidOptions) {
  CloudStartOptions start;
  start.method = "magic";
  ExpectInputError([&] { RegisterCloudsFrom({}, {}, std::nullopt, start, {}); },
                   Names("method", "magic", "identity", "file", "global", "auto"));
  start.method = "file";
  ExpectInputError([&] { RegisterCloudsFrom({}, {}, std::nullopt, start, {}); },
                   Names("start", "file"));
}

TEST(RegisterClouds, ReportsTooFewInliers) {
  const PointSet corner = Corner(0, 1);
  const Rigid3d away(Eigen::Quaterniond::Identity(), {10, 0, 0});
  EXPECT_EQ(ToString(RegisterClouds(corner, corner, away, {}).termination), "too_few_inliers");
  EXPECT_EQ(ToString(RegisterClouds({}, corner, {}, {}).termination), "too_few_inliers");
  EXPECT_EQ(ToString(RegisterClouds(corner, {}, {}, {}).termination), "too_few_inliers");
}

TEST(RegisterClouds, IsTheSameAtAnyNumberOfThreads) {
  const Rigid3d moved(QuaternionExp<double>({0.02, 0.01, 0}), {0.05, 0, 0.02});
  const auto results = AtThreads(
      {1, 4}, [&] { return RegisterClouds(Corner(0.002, 1), Corner(0.002, 2), moved, {}); });
  EXPECT_EQ(results[0].target_from_source.Matrix(), results[1].target_from_source.Matrix());
  EXPECT_EQ(results[0].information, results[1].information);
}

TEST(RegisterClouds, RejectsInvalidOptions) {
  RegisterCloudsOptions options;
  options.levels = 0;
  ExpectInputError([&] { RegisterClouds({}, {}, {}, options); }, Names("levels", 0, 1, 10));
  options = {};
  options.icp.association = "projective";
  ExpectInputError([&] { RegisterClouds({}, {}, {}, options); },
                   Names("association", "projective", "kd_tree"));
  options = {};
  options.icp.solver = "magic";
  ExpectInputError([&] { RegisterClouds({}, {}, {}, options); }, Names("icp.solver", "magic"));
}

}  // namespace
}  // namespace surfit::testing
