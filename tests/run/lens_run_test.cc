// Recordings of a camera with lens distortion. Rays follow the lens, so depth and colour are exact.
#include <gtest/gtest.h>

#include <cmath>

#include "frame/lens.h"
#include "surfit/core/parallel.h"
#include "surfit/io/camera_files.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/run/slam_run.h"
#include "surfit/simulation/camera_path.h"
#include "surfit/simulation/render.h"
#include "testing/pixels.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

constexpr int kLensFrames = 40;
constexpr double kCountsPerMetre = 5000;

// Rays of the distorted pixels, with z = 1, by fixed-point iteration.
Image<Eigen::Vector3d> RaysOf(const PinholeCamera& camera) {
  const Lens<double> lens(camera);
  Image<Eigen::Vector3d> rays(camera.width, camera.height, Eigen::Vector3d::Zero());
  for (const auto [u, v] : PixelsOf(rays)) {
    Eigen::Vector3d ray = camera.Ray(u, v);
    for (int i = 0; i < 30; ++i) {
      const LensPixel<double> pixel = lens.Project(ray);
      ray.x() += (u - pixel.u) / camera.fx;
      ray.y() += (v - pixel.v) / camera.fy;
    }
    rays(u, v) = ray;
  }
  return rays;
}

// Exact images along these rays.
void WriteView(const Scene& scene, const Image<Eigen::Vector3d>& rays,
               const Rigid3d& world_from_camera, const std::string& depth_path,
               const std::string& color_path) {
  Image<std::uint16_t> depth(rays.width(), rays.height(), 0);
  LightImage light(rays.width(), rays.height(), Eigen::Vector3f::Zero());
  const std::vector<RayCandidate> candidates = scene.ObjectsInCone(
      world_from_camera.translation, world_from_camera.rotation * Eigen::Vector3d::UnitZ(), 1);
  ParallelFor(0, rays.height(), 4, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      std::vector<int> columns;
      std::vector<ScenePoint> points;
      for (int u = 0; u < rays.width(); ++u) {
        const Eigen::Vector3d direction = world_from_camera.rotation * rays(u, v);
        const auto hit = scene.Intersect(world_from_camera.translation, direction, candidates);
        if (!hit) continue;
        depth(u, v) = static_cast<std::uint16_t>(std::lround(kCountsPerMetre * hit->t));
        columns.push_back(u);
        points.push_back({*hit, world_from_camera.translation + hit->t * direction});
      }
      const std::vector<Eigen::Vector3f> seen = scene.Light(points);
      for (std::size_t i = 0; i < seen.size(); ++i) light(columns[i], v) = seen[i];
    }
  });
  WriteDepth(depth_path, depth);
  WriteColor(color_path, ToSrgbImage(light, Eigen::Vector3f::Ones()));
}

// ATE in mm of a recording by a camera with this lens. camera.yaml has the true lens.
double LensErrorMm(const std::array<double, 5>& distortion, int seed) {
  const TempFolder folder;
  RgbdCamera camera;
  camera.depth = {320, 240, 300, 300, 159.5, 119.5, distortion};
  camera.depth_units_per_metre = kCountsPerMetre;
  WriteCameraYaml(camera, folder.Write("camera.yaml", ""));
  const Scene scene = MakeScene("room", seed);
  const Trajectory path = MakePath(scene, kLensFrames, seed);
  const Image<Eigen::Vector3d> rays = RaysOf(camera.depth);
  std::string rgb, depth;
  for (int i = 0; i < kLensFrames; ++i) {
    const std::string stamp = std::to_string(path[i].stamp_s);
    const std::string depth_name = Format("depth/%03d.png", i),
                      color_name = Format("rgb/%03d.png", i);
    folder.Write(depth_name, "");
    folder.Write(color_name, "");
    WriteView(scene, rays, path[i].world_from_camera, folder / depth_name, folder / color_name);
    rgb += stamp + " " + color_name + "\n";
    depth += stamp + " " + depth_name + "\n";
  }
  folder.Write("rgb.txt", rgb);
  folder.Write("depth.txt", depth);
  WriteTumTrajectory(path, folder / "groundtruth.txt");
  SlamRunOptions options;
  const TempFolder output;
  options.sequence = Options(folder);
  options.output = output.path();
  options.pictures = options.final_map = options.refine = false;
  const SlamRunSummary summary = RunSlam(options, false, [](const SlamRunProgress&) {});
  EXPECT_EQ(summary.frames_tracked, kLensFrames);
  if (!summary.evaluation || !summary.evaluation->ate) return HUGE_VAL;
  return 1000 * summary.evaluation->ate->translation_m.rmse;
}

// A wrong lens, or a lens that is applied twice, has errors of centimetres.
TEST(LensRun, AKnownLensIsTrackedWithin2Millimetres) {
  EXPECT_LT(LensErrorMm({0.08, 0, 0, 0, 0}, 4), 1.5);
  EXPECT_LT(LensErrorMm({-0.2, 0.05, 0.001, 0, 0}, 4), 1.8);
}

}  // namespace
}  // namespace surfit::testing
