// Registers pairs of simulated views from any initial pose. No wrong pose may be accepted.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "surfit/registration/register_clouds.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "surfit/simulation/scene.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

constexpr int kRooms = 5, kPathFrames = 900;

// Kinect v1 (Khoshelham and Elberink 2012): sigma_z = 0.0015 z^2, with z in m.
constexpr double kKinectSigma = 0.0015;

PinholeCamera SmallCamera() {
  PinholeCamera camera;
  camera.width = 160, camera.height = 120;
  camera.fx = camera.fy = 131.25;
  camera.cx = 79.5, camera.cy = 59.5;
  return camera;
}

struct CloudPairCounts {
  int right = 0, refused = 0, wrong = 0;
};

std::vector<Eigen::Vector3f> PointsOfView(const Scene& scene, const Rigid3d& world_from_camera,
                                          double inverse_depth_sigma, std::mt19937_64* rng) {
  const PinholeCamera camera = SmallCamera();
  const Rendering view = RenderGeometry(scene, camera, world_from_camera);
  std::normal_distribution<double> noise(0, 1);
  std::vector<Eigen::Vector3f> points;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double z = view.depth_m(u, v);
      if (!(z > 0)) continue;
      const double measured = z + inverse_depth_sigma * z * z * noise(*rng);
      points.push_back(
          (measured * Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1))
              .cast<float>());
    }
  }
  return points;
}

SensedCloud ViewCloud(std::vector<Eigen::Vector3f> points, const Rigid3d& pose) {
  CloudSensor sensor;
  sensor.noise.inverse_depth_sigma = 0;
  for (Eigen::Vector3f& point : points) point = (pose * point.cast<double>()).cast<float>();
  sensor.viewpoint = pose.translation;
  const CloudNormals estimated = EstimateCloudNormals(points, sensor, {});
  SensedCloud cloud;
  for (std::size_t i = 0; i < points.size(); ++i) {
    cloud.points.Add(points[i], estimated.normals[i], 1e-6f + estimated.deviation_m[i]);
  }
  cloud.viewpoint = pose.translation;
  cloud.has_viewpoint = true;
  return cloud;
}

// Ratio of source points that are within 3 cm of the target at the true pose, by projection.
double OverlapOf(const std::vector<Eigen::Vector3f>& source, const Rendering& target,
                 const Rigid3d& target_from_source) {
  const PinholeCamera camera = SmallCamera();
  int seen = 0;
  for (const Eigen::Vector3f& point : source) {
    const Eigen::Vector3d p = target_from_source * point.cast<double>();
    if (!(p.z() > 0)) continue;
    const int u = static_cast<int>(std::lround(camera.fx * p.x() / p.z() + camera.cx));
    const int v = static_cast<int>(std::lround(camera.fy * p.y() / p.z() + camera.cy));
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    const double z = target.depth_m(u, v);
    seen += z > 0 && std::abs(z - p.z()) < 0.03 + 0.02 * z;
  }
  return static_cast<double>(seen) / static_cast<double>(source.size());
}

// A pose is right within 5 cm at the centre of the source, and 2 degrees.
bool IsRight(const Rigid3d& found, const Rigid3d& truth, const Eigen::Vector3d& center) {
  return (found * center - truth * center).norm() < 0.05 &&
         RotationAngle(found.rotation.conjugate() * truth.rotation) < 2 * kRadPerDeg;
}

// Registers `count` pairs with an overlap from 10 to 90 %. The source has any rotation.
CloudPairCounts RegisterCloudPairs(int count, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::vector<Scene> scenes;
  std::vector<Trajectory> paths;
  for (int room = 0; room < kRooms; ++room) {
    scenes.push_back(MakeScene("room", room + 1));
    paths.push_back(MakePath(scenes.back(), kPathFrames, room + 1));
  }
  CloudPairCounts counts;
  for (int pair = 0; pair < count;) {
    const int room = pair % kRooms;
    const double noise = pair / kRooms % 2 == 0 ? 0 : kKinectSigma;
    std::uniform_int_distribution<int> frame(0, kPathFrames - 1);
    const Rigid3d source_pose = paths[room][frame(rng)].world_from_camera;
    const Rigid3d target_pose = paths[room][frame(rng)].world_from_camera;
    const Rigid3d target_from_camera = target_pose.Inverse() * source_pose;
    const std::vector<Eigen::Vector3f> source =
        PointsOfView(scenes[room], source_pose, noise, &rng);
    const double overlap = OverlapOf(
        source, RenderGeometry(scenes[room], SmallCamera(), target_pose), target_from_camera);
    if (overlap < 0.1 || overlap > 0.9) continue;
    ++pair;
    const Rigid3d moved = RandomPose(M_PI, 2, &rng);
    const std::vector<Eigen::Vector3f> target =
        PointsOfView(scenes[room], target_pose, noise, &rng);
    const CloudRegistration result =
        RegisterCloudsFrom(ViewCloud(source, moved), ViewCloud(target, {}), std::nullopt, {}, [] {
          RegisterCloudsOptions options;
          options.icp.gates.max_distance_m = 0;
          return options;
        }());
    const Rigid3d truth = target_from_camera * moved.Inverse();
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3f& point : source) center += moved * point.cast<double>();
    center /= static_cast<double>(source.size());
    const bool is_right = IsRight(result.icp.target_from_source, truth, center);
    counts.right += result.accepted() && is_right;
    counts.wrong += result.accepted() && !is_right;
    counts.refused += !result.accepted();
    if (result.accepted() && !is_right) {
      std::printf(
          "wrong: pair %d, room %d, noise %g, overlap %.2f, start %s: overlap ratio %.2f, "
          "inliers %.2f, free space %.3f, margin %.2f, error %.3f m\n",
          pair, room, noise, overlap, result.start.c_str(), result.overlap_ratio,
          result.inlier_ratio, result.free_space_violation_ratio.value_or(-1), result.score_margin,
          (result.icp.target_from_source * center - truth * center).norm());
    }
    if (std::getenv("SURFIT_VERBOSE_PAIRS") != nullptr) {
      std::printf(
          "pair %d overlap %.2f noise %g %s %s: %s ratio %.2f inliers %.2f free %.3f margin "
          "%.2f sigma/spacing %.2f\n",
          pair, overlap, noise, is_right ? "right" : "WRONG", result.start.c_str(),
          ToString(result.reason).c_str(), result.overlap_ratio, result.inlier_ratio,
          result.free_space_violation_ratio.value_or(-1), result.score_margin,
          result.sigma_m / result.spacing_m);
    }
  }
  std::printf("%d right, %d refused, %d wrong of %d pairs\n", counts.right, counts.refused,
              counts.wrong, count);
  return counts;
}

// Most pairs have little overlap, or two planes in the overlap. They must be rejected. The limits
// of accepted pairs ensure that the test does not pass by rejecting all pairs.
TEST(CloudPairs, NoWrongRegistrationIsAccepted) {
  const CloudPairCounts counts = RegisterCloudPairs(30, 1);
  EXPECT_EQ(counts.wrong, 0);
  EXPECT_GE(counts.right, 12);
}

TEST(CloudPairsSweep, NoWrongRegistrationIsAccepted) {
  const CloudPairCounts counts = RegisterCloudPairs(1000, 2);
  EXPECT_EQ(counts.wrong, 0);
  EXPECT_GE(counts.right, 300);
}

}  // namespace
}  // namespace surfit::testing
