#include "surfit/mapping/fusion.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "mapping/atomic_minimum.h"
#include "mapping/measured_points.h"
#include "mapping/surfel_projection.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kRowsPerBlock = 8;
constexpr std::int32_t kNone = -1;

struct MergeCounts {
  int points = 0;
  int surfels = 0;
  MergeCounts& operator+=(const MergeCounts& other) {
    points += other.points;
    surfels += other.surfels;
    return *this;
  }
};

}  // namespace

// The fusion of one frame; owns the buffers that are kept between frames.
struct Fusion::Workspace {
  explicit Workspace(const FusionOptions& fusion_options)
      : options(fusion_options), min_cosine(std::cos(fusion_options.max_normal_angle_rad)) {}

  void Begin(const RgbdFrame& new_frame, const FrameLevel& surface, const SurfelMap& map);
  void FindOwnSurfels(const PosedCamera& camera, const SurfelMap& map);
  void FindSurfelsOfNeighbours(const PosedCamera& camera, const SurfelMap& map);
  MergeCounts MergePoints(const PosedCamera& camera, SurfelMap* map) const;
  std::vector<Surfel> NewSurfels(const PosedCamera& camera, int* input_points) const;

  bool Belongs(const MeasuredPoint& point, const Eigen::Vector3f& surfel_in_camera,
               const Eigen::Vector3f& surfel_normal) const;
  void OfferChunk(const PosedCamera& camera, const SurfelMap& map, int begin, int end);
  std::int32_t SurfelOfNeighbours(const PosedCamera& camera, const SurfelMap& map, int u,
                                  int v) const;
  int MergeAround(const PosedCamera& camera, int u, int v, SurfelMap* map) const;
  std::int32_t Own(int pixel) const {
    const std::uint64_t key = own[pixel].load(std::memory_order_relaxed);
    return key == kNoMinimum ? kNone : IndexOfKey(key);
  }

  const FusionOptions& options;
  const float min_cosine;
  const RgbdFrame* frame = nullptr;
  std::deque<int> last_frames;  // indices of the last max_dormant_frames + 1, this one included
  int awake_since = 0;          // surfels that were last seen before this frame are dormant
  Image<float> weights;
  double weights_cx = 0, weights_cy = 0;        // the principal point they belong to
  std::vector<MeasuredPoint> points;            // per pixel
  std::vector<std::atomic<std::uint64_t>> own;  // per pixel: nearest surfel that projects there
  Image<std::int32_t> surfel_of_point;          // per pixel: own or a neighbour's, or kNone
  std::vector<std::uint8_t> remove;             // per surfel
};

void FusionOptions::Validate() const {
  const auto require = [](bool holds, const char* field, double value, const char* constraint) {
    if (!holds) throw InputError(Concat(field, " is ", value, ", must be ", constraint));
  };
  if (weighting != "confidence" && weighting != "uniform") {
    throw InputError(Concat("weighting is '", weighting, "', must be one of: confidence, uniform"));
  }
  require(max_distance_m > 0, "max_distance_m", max_distance_m, "positive");
  require(max_normal_angle_rad > 0 && max_normal_angle_rad < 1.57f, "max_normal_angle_rad",
          max_normal_angle_rad, "positive and below pi/2");
  require(max_spacing_m > 0, "max_spacing_m", max_spacing_m, "positive");
  require(max_slant_scale >= 1, "max_slant_scale", max_slant_scale, "at least 1");
  require(max_radius_ratio > 0, "max_radius_ratio", max_radius_ratio, "positive");
  require(lasting_confidence >= 0, "lasting_confidence", lasting_confidence, "zero or positive");
  require(max_dormant_frames >= 0, "max_dormant_frames", max_dormant_frames, "zero or positive");
  require(max_confidence > 0, "max_confidence", max_confidence, "positive");
  require(free_space_margin_m > 0, "free_space_margin_m", free_space_margin_m, "positive");
  require(noise.inverse_depth_sigma >= 0, "inverse_depth_sigma", noise.inverse_depth_sigma,
          "zero or positive");
}

Fusion::Fusion(const FusionOptions& options)
    : options_(options), workspace_(std::make_unique<Workspace>(options_)) {
  options.Validate();
}

Fusion::~Fusion() = default;

FusionReport Fusion::Fuse(const RgbdFrame& frame, const FrameLevel& surface,
                          const Rigid3d& world_from_camera, SurfelMap* map) {
  CHECK_EQ(frame.depth_m.width(), surface.camera.width);
  CHECK_EQ(frame.depth_m.height(), surface.camera.height);
  const PosedCamera camera(surface.camera, world_from_camera);
  Workspace& work = *workspace_;
  work.Begin(frame, surface, *map);
  work.FindOwnSurfels(camera, *map);
  work.FindSurfelsOfNeighbours(camera, *map);
  const MergeCounts merged = work.MergePoints(camera, map);

  FusionReport report;
  const std::vector<Surfel> added = work.NewSurfels(camera, &report.input_points);
  report.merged_points = merged.points;
  report.merged = merged.surfels;
  report.added = static_cast<int>(added.size());
  report.removed = static_cast<int>(map->Replace(work.remove, added));
  return report;
}

void Fusion::Workspace::Begin(const RgbdFrame& new_frame, const FrameLevel& surface,
                              const SurfelMap& map) {
  frame = &new_frame;
  const std::size_t most = static_cast<std::size_t>(options.max_dormant_frames) + 1;
  last_frames.push_back(frame->index);
  if (last_frames.size() > most) last_frames.pop_front();
  awake_since = last_frames.size() == most ? last_frames.front() : std::numeric_limits<int>::min();
  const int width = surface.camera.width, height = surface.camera.height;
  const PinholeCamera& camera = surface.camera;
  if (weights.width() != width || weights.height() != height || weights_cx != camera.cx ||
      weights_cy != camera.cy) {
    weights = PointWeights(camera, options);
    weights_cx = camera.cx;
    weights_cy = camera.cy;
  }
  MeasurePoints(new_frame, surface, options, &points);
  ResetMinima(points.size(), &own);
  surfel_of_point.Resize(width, height);
  remove.resize(map.size());
}

// Point and surfel are the same piece of surface.
bool Fusion::Workspace::Belongs(const MeasuredPoint& point, const Eigen::Vector3f& surfel_in_camera,
                                const Eigen::Vector3f& surfel_normal) const {
  const Eigen::Vector3f gap = point.position - surfel_in_camera;
  const float along = surfel_normal.dot(gap);
  const float across2 = gap.squaredNorm() - along * along;
  const float reach = std::min(point.radius_m, options.max_spacing_m);
  return std::fabs(along) <= options.max_distance_m && across2 <= reach * reach &&
         surfel_normal.dot(point.normal) >= min_cosine;
}

// Filter passes 1 and 2: each surfel that projects into the image (pass 1) and belongs to the point
// found there (pass 2) offers itself; the pixel keeps the nearest. Marks what is to be removed.
void Fusion::Workspace::FindOwnSurfels(const PosedCamera& camera, const SurfelMap& map) {
  ParallelFor(0, static_cast<int>(map.size()), 16 * ProjectedChunk::kCapacity,
              [&](int begin, int end) {
                for (int i = begin; i < end; i += ProjectedChunk::kCapacity) {
                  OfferChunk(camera, map, i, std::min(end, i + ProjectedChunk::kCapacity));
                }
              });
}

void Fusion::Workspace::OfferChunk(const PosedCamera& camera, const SurfelMap& map, int begin,
                                   int end) {
  ProjectedChunk chunk;
  chunk.Project(map, camera, begin, end);
  for (int k = 0; k < end - begin; ++k) {
    const int i = begin + k;
    const bool dormant = map.last_seen[i] < awake_since;
    remove[i] = dormant && map.confidence[i] < options.lasting_confidence;
    const float u = chunk.u[k] + 0.5f, v = chunk.v[k] + 0.5f;
    if (!(u >= 0 && v >= 0 && u < camera.width && v < camera.height)) continue;
    const int pixel = static_cast<int>(v) * camera.width + static_cast<int>(u);
    const MeasuredPoint& point = points[pixel];
    if (chunk.z[k] < point.free_depth_m) remove[i] = 1;
    if (remove[i] || !(point.radius_m > 0)) continue;
    const Eigen::Vector3f position(chunk.x[k], chunk.y[k], chunk.z[k]);
    if (!Belongs(point, position, camera.NormalInCamera(map, i))) continue;
    LowerTo(MinimumKey((point.position - position).squaredNorm(), i), &own[pixel]);
  }
}

// A point without a surfel of its own takes the nearest of its neighbours' surfels it belongs to.
void Fusion::Workspace::FindSurfelsOfNeighbours(const PosedCamera& camera, const SurfelMap& map) {
  ParallelFor(0, camera.height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const int pixel = v * camera.width + u;
        const std::int32_t i = Own(pixel);
        const bool lonely = i == kNone && points[pixel].radius_m > 0;
        surfel_of_point(u, v) = lonely ? SurfelOfNeighbours(camera, map, u, v) : i;
      }
    }
  });
}

std::int32_t Fusion::Workspace::SurfelOfNeighbours(const PosedCamera& camera, const SurfelMap& map,
                                                   int u, int v) const {
  const MeasuredPoint& point = points[v * camera.width + u];
  std::uint64_t nearest = kNoMinimum;
  for (int qv = std::max(0, v - 1); qv <= std::min(camera.height - 1, v + 1); ++qv) {
    for (int qu = std::max(0, u - 1); qu <= std::min(camera.width - 1, u + 1); ++qu) {
      const std::int32_t i = Own(qv * camera.width + qu);
      if (i == kNone) continue;
      const Eigen::Vector3f position = camera.PositionInCamera(map, i);
      if (!Belongs(point, position, camera.NormalInCamera(map, i))) continue;
      nearest = std::min(nearest, MinimumKey((point.position - position).squaredNorm(), i));
    }
  }
  return nearest == kNoMinimum ? kNone : IndexOfKey(nearest);
}

// A surfel projects to one pixel, and the points that chose it lie around that pixel: no two tasks
// touch the same surfel, and it meets its points in raster order.
MergeCounts Fusion::Workspace::MergePoints(const PosedCamera& camera, SurfelMap* map) const {
  return ParallelSum(0, camera.height, kRowsPerBlock, MergeCounts(), [&](int begin, int end) {
    MergeCounts counts;
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        if (Own(v * camera.width + u) == kNone) continue;
        counts.points += MergeAround(camera, u, v, map);
        ++counts.surfels;
      }
    }
    return counts;
  });
}

// Merges the surfel of pixel (u, v) with the points that chose it; returns how many.
int Fusion::Workspace::MergeAround(const PosedCamera& camera, int u, int v, SurfelMap* map) const {
  const std::int32_t i = Own(v * camera.width + u);
  int count = 0;
  for (int qv = std::max(0, v - 1); qv <= std::min(camera.height - 1, v + 1); ++qv) {
    for (int qu = std::max(0, u - 1); qu <= std::min(camera.width - 1, u + 1); ++qu) {
      if (surfel_of_point(qu, qv) != i) continue;
      const MeasuredPoint& point = points[qv * camera.width + qu];
      SurfelObservation observation;
      observation.position_in_world = camera.PointInWorld(point.position);
      observation.normal_in_world = camera.world_rotation * point.normal;
      observation.color = frame->color.empty() ? map->Color(i) : frame->color(qu, qv);
      observation.radius_m = point.radius_m;
      observation.weight = weights(qu, qv);
      observation.at_edge = point.at_edge;
      const bool fine =
          !point.at_edge && point.radius_m < options.max_radius_ratio * map->radius_m[i];
      map->Merge(i, observation, fine, options.max_confidence);
      ++count;
    }
  }
  map->last_seen[i] = frame->index;
  return count;
}

// The points that no surfel stands for, in raster order.
std::vector<Surfel> Fusion::Workspace::NewSurfels(const PosedCamera& camera,
                                                  int* input_points) const {
  const int blocks = (camera.height + kRowsPerBlock - 1) / kRowsPerBlock;
  std::vector<std::vector<Surfel>> of_block(blocks);
  *input_points = ParallelSum(0, camera.height, kRowsPerBlock, 0, [&](int begin, int end) {
    int count = 0;
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const MeasuredPoint& point = points[v * camera.width + u];
        if (!(point.radius_m > 0)) continue;
        ++count;
        if (surfel_of_point(u, v) != kNone) continue;
        Surfel surfel;
        surfel.position_in_world = camera.PointInWorld(point.position);
        surfel.normal_in_world = camera.world_rotation * point.normal;
        surfel.color = frame->color.empty() ? Rgb8{128, 128, 128} : frame->color(u, v);
        surfel.radius_m = point.radius_m;
        surfel.confidence = weights(u, v);
        surfel.at_edge = point.at_edge;
        surfel.first_seen = surfel.last_seen = frame->index;
        of_block[begin / kRowsPerBlock].push_back(surfel);
      }
    }
    return count;
  });
  std::vector<Surfel> all;
  for (const auto& surfels : of_block) all.insert(all.end(), surfels.begin(), surfels.end());
  return all;
}

}  // namespace surfit
