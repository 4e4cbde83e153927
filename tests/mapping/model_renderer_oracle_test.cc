// Compares model views with all discs at every pixel.
#include <gmock/gmock.h>

#include <algorithm>

#include "mapping/random_surfel.h"
#include "surfit/mapping/model_renderer.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

// Rule of the header in double precision, for one disc and one pixel.
class DiscAtPixel {
 public:
  DiscAtPixel(const Surfel& s, const PinholeCamera& camera, const Rigid3d& world_from_view, int u,
              int v, const RenderOptions& options) {
    const Rigid3d camera_from_world = world_from_view.Inverse();
    const Eigen::Vector3d p = camera_from_world * s.position_in_world.cast<double>();
    const Eigen::Vector3d n = camera_from_world.rotation * s.normal_in_world.cast<double>();
    stable_ = s.confidence >= options.stable_confidence;
    if (p.z() < 0.05) return;  // kMinDepth
    const Eigen::Vector3d ray = camera.Ray(u, v);
    depth_ = n.dot(p) / n.dot(ray);
    point_ = depth_ * ray;
    const double radius = 1. * options.radius_ratio * s.radius_m;
    offset_ = (point_ - p).norm() / radius;
    back_ = depth_ + options.surface_thickness_m + 4 * DepthNoise().SigmaZ(depth_);
    const double window = std::min(camera.fx * radius / p.z(), 1. * options.max_half_window_px);
    const Eigen::Vector2d off = camera.Project(p) - Eigen::Vector2d(u, v);
    // All values are positive if the disc covers the pixel.
    margin_ =
        std::min({-n.dot(p.normalized()), depth_, radius / p.z() - (point_ - p).norm() / p.z(),
                  (window - off.lpNorm<Eigen::Infinity>()) / camera.fx});
  }

  // Single precision decides differently only within a few roundings of the limits. This is the
  // rounding of positions up to 10 m at depths of at least 0.05 m, amplified by steep discs.
  static constexpr double kEpsilon = 3e-5;
  bool Covers() const { return margin_ > kEpsilon; }
  bool MayCover() const { return margin_ > -kEpsilon; }
  // True if the other disc is certainly behind the surface of this disc.
  bool CertainlyHides(const DiscAtPixel& other) const {
    if (stable_ != other.stable_) return stable_;
    return back_ * (1 + kEpsilon) + kEpsilon < other.depth_;
  }
  bool MayHide(const DiscAtPixel& other) const {
    if (stable_ != other.stable_) return stable_;
    return back_ * (1 - kEpsilon) - kEpsilon < other.depth_;
  }
  bool IsCertainlyCloserToTheRay(const DiscAtPixel& other) const {
    return offset_ < other.offset_ - 100 * kEpsilon;
  }
  const Eigen::Vector3d& point() const { return point_; }

 private:
  bool stable_ = false;
  double margin_ = -1;
  double depth_ = 0;
  double back_ = 0;    // back of the surface that starts at this disc
  double offset_ = 0;  // relative to the radius
  Eigen::Vector3d point_;
};

struct Coverage {
  int drawn = 0;
  int empty = 0;
};

// Compares a view with all discs, pixel by pixel.
Coverage CheckView(const SurfelMap& map, const ModelView& view, const RenderOptions& options) {
  const PinholeCamera& camera = view.surface.camera;
  Coverage coverage;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      std::vector<DiscAtPixel> discs;
      for (std::int32_t id = 0; id < map.id_end(); ++id) {
        const Surfel s = map.Has(id) ? map[id] : Surfel();  // covers no pixel
        discs.emplace_back(s, camera, view.world_from_view, u, v, options);
      }
      const std::int32_t drawn = view.surfel_index(u, v);
      if (drawn == ModelView::kNoSurfel) {
        ++coverage.empty;
        for (const DiscAtPixel& disc : discs) EXPECT_FALSE(disc.Covers()) << u << " " << v;
        continue;
      }
      ++coverage.drawn;
      EXPECT_TRUE(discs.at(drawn).MayCover()) << u << " " << v;
      for (const DiscAtPixel& disc : discs) {
        if (!disc.Covers()) continue;
        EXPECT_FALSE(disc.CertainlyHides(discs[drawn])) << u << " " << v;
        if (!disc.IsCertainlyCloserToTheRay(discs[drawn])) continue;
        EXPECT_TRUE(std::any_of(
            discs.begin(), discs.end(),
            [&](const DiscAtPixel& other) { return other.MayCover() && other.MayHide(disc); }))
            << u << " " << v;
      }
      // The vertex is on the disc. The slope of a steep disc amplifies the rounding.
      EXPECT_THAT(view.surface.vertex(u, v).cast<double>(),
                  VectorNear(discs[drawn].point(), 1e-3 * discs[drawn].point().norm()));
    }
  }
  return coverage;
}

TEST(ModelRenderer, AgreesWithBruteForce) {
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < 6; ++trial) {
    const Rigid3d world_from_view = RandomPose(2, 2, &rng);
    const SurfelMap map = RandomDiscs(trial < 3 ? 300 : 40, 0.2f, world_from_view, &rng);
    RenderOptions options;
    options.radius_ratio = trial % 2 == 0 ? 0.6f : 1;
    options.max_half_window_px = trial < 3 ? 4 : 20;
    const Coverage coverage = CheckView(
        map, ModelRenderer(options).Render(map, {SmallCamera(), {}}, world_from_view), options);
    EXPECT_GT(coverage.drawn, 200);
    EXPECT_GT(coverage.empty, 200);
  }
}

// Close to the camera, some rays intersect the plane of a steep disc behind the camera.
TEST(ModelRenderer, AgreesWithBruteForceForLargeNearDiscs) {
  std::mt19937_64 rng(2);
  RenderOptions options;
  options.max_half_window_px = 64;
  for (int trial = 0; trial < 10; ++trial) {
    SurfelMap map;
    for (int i = 0; i < 3; ++i) {
      const float z = Uniform(0.06f, 0.2f, &rng);
      map.Append(Disc({z * Uniform(-0.4f, 0.4f, &rng), z * Uniform(-0.3f, 0.3f, &rng), z},
                      RandomNormal(1.55f, &rng), 0.5f, Uniform(0, 20, &rng)));
    }
    CheckView(map, ModelRenderer(options).Render(map, {SmallCamera(), {}}, {}), options);
  }
}

}  // namespace
}  // namespace surfit::testing
