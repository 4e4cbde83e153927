#include "surfit/mapping/fusion.h"

#include <glog/logging.h>

#include <algorithm>
#include <deque>
#include <limits>

#include "mapping/bands.h"
#include "mapping/candidate_finder.h"
#include "mapping/measured_points.h"
#include "mapping/merge_gate.h"
#include "mapping/posed_camera.h"
#include "mapping/surfel_choice.h"
#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// So many meetings before its own the point is asked for, to be in the cache by then.
constexpr int kMeetingsAhead = 16;

// A surfel and the pixel of a point that chose it.
struct Meeting {
  std::int32_t surfel;
  int pixel;
};

struct MergeCounts {
  int points = 0;
  int surfels = 0;
  MergeCounts& operator+=(const MergeCounts& other) {
    points += other.points;
    surfels += other.surfels;
    return *this;
  }
};

// By surfel, and there in raster order.
std::vector<Meeting> Meetings(const CandidateList& list, int width, int* surfels) {
  std::vector<Meeting> meetings;
  for (const Candidate& candidate : list.candidates) {
    if (!candidate.chosen_by[4]) continue;  // nor did others: its own point chose another one
    ++*surfels;
    for (int k = 0; k < 9; ++k) {
      const int pixel = candidate.pixel + (k / 3 - 1) * width + k % 3 - 1;
      if (candidate.chosen_by[k]) meetings.push_back({candidate.surfel, pixel});
    }
  }
  return meetings;
}

}  // namespace

// The fusion of one frame; owns the buffers that are kept between frames.
struct Fusion::Workspace {
  explicit Workspace(const FusionOptions& fusion_options)
      : options(fusion_options), gate(fusion_options), choice(gate) {}

  void Begin(const RgbdFrame& new_frame, const FrameLevel& surface);
  void FindCandidates(const PosedCamera& camera, const SurfelMap& map);
  void MarkDormant(const SurfelMap& map, int begin, int end);
  int ChooseSurfels(const PosedCamera& camera);
  Surfel NewSurfel(const PosedCamera& camera, int pixel) const;
  MergeCounts MergePoints(const PosedCamera& camera, SurfelMap* map) const;
  void Fetch(int pixel) const;
  void Merge(const PosedCamera& camera, const Meeting& meeting, SurfelMap* map) const;

  const FusionOptions& options;
  const MergeGate gate;
  SurfelChoice choice;
  const RgbdFrame* frame = nullptr;
  std::deque<int> last_frames;  // indices of the last max_dormant_frames + 1, this one included
  int awake_since = 0;          // surfels that were last seen before this frame are dormant
  Image<float> weights;
  double weights_cx = 0, weights_cy = 0;           // the principal point they belong to
  std::vector<MeasuredPoint> points;               // per pixel
  Image<float> free_depth_m;                       // per pixel
  std::vector<CandidateList> candidates;           // per part of the map
  std::vector<std::vector<Surfel>> added_of_band;  // in raster order
  std::vector<std::uint8_t> remove;                // per surfel
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
  work.Begin(frame, surface);
  work.FindCandidates(camera, *map);
  FusionReport report;
  report.input_points = work.ChooseSurfels(camera);
  const MergeCounts merged = work.MergePoints(camera, map);
  std::vector<Surfel> added;
  for (const auto& of_band : work.added_of_band) {
    added.insert(added.end(), of_band.begin(), of_band.end());
  }
  report.merged_points = merged.points;
  report.merged = merged.surfels;
  report.added = static_cast<int>(added.size());
  report.removed = static_cast<int>(map->Replace(work.remove, added));
  return report;
}

void Fusion::Workspace::Begin(const RgbdFrame& new_frame, const FrameLevel& surface) {
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
  free_depth_m = FreeDepths(frame->depth_m, options);
}

void Fusion::Workspace::MarkDormant(const SurfelMap& map, int begin, int end) {
  for (int i = begin; i < end; ++i) {
    const bool dormant = map.last_seen[i] < awake_since;
    const bool lasting = map.confidence[i] >= options.lasting_confidence;
    remove[i] = dormant & !lasting;
  }
}

// Filter passes 1 and 2: the surfels that project into the image (pass 1) and belong to the point
// found there (pass 2). Marks what is to be removed.
void Fusion::Workspace::FindCandidates(const PosedCamera& camera, const SurfelMap& map) {
  constexpr int kCapacity = CandidateFinder::kCapacity;
  const CandidateFinder finder(map, camera, points, free_depth_m, gate);
  remove.resize(map.size());
  candidates.resize((map.size() + kCapacity - 1) / kCapacity);
  ParallelFor(0, static_cast<int>(map.size()), kCapacity, [&](int begin, int end) {
    MarkDormant(map, begin, end);
    finder.Find(begin, end, &remove, &candidates[begin / kCapacity]);
  });
}

// Each point chooses its surfel; those that no surfel stands for become new ones. Returns how many
// points there are.
int Fusion::Workspace::ChooseSurfels(const PosedCamera& camera) {
  choice.SetCandidates(camera.width, camera.height, &candidates);
  added_of_band.resize(BandCount(camera.height));
  return ParallelSum(0, camera.height, kBandRows, 0, [&](int begin, int end) {
    std::vector<Surfel>& added = added_of_band[begin / kBandRows];
    added.clear();
    int count = 0;
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const MeasuredPoint& point = points[v * camera.width + u];
        if (!(point.radius_m > 0)) continue;
        ++count;
        if (!choice.Choose(point, u, v)) added.push_back(NewSurfel(camera, v * camera.width + u));
      }
    }
    return count;
  });
}

Surfel Fusion::Workspace::NewSurfel(const PosedCamera& camera, int pixel) const {
  const MeasuredPoint& point = points[pixel];
  Surfel surfel;
  surfel.position_in_world = camera.PointInWorld(point.position);
  surfel.normal_in_world = camera.world_rotation * point.normal;
  surfel.color = frame->color.empty() ? Rgb8{128, 128, 128} : frame->color[pixel];
  surfel.radius_m = point.radius_m;
  surfel.confidence = weights[pixel];
  surfel.at_edge = point.at_edge;
  surfel.first_seen = surfel.last_seen = frame->index;
  return surfel;
}

// A surfel meets the points that chose it in raster order; no two tasks touch the same surfel.
MergeCounts Fusion::Workspace::MergePoints(const PosedCamera& camera, SurfelMap* map) const {
  const int lists = static_cast<int>(candidates.size());
  return ParallelSum(0, lists, 1, MergeCounts(), [&](int list, int) {
    MergeCounts counts;
    const std::vector<Meeting> meetings = Meetings(candidates[list], camera.width, &counts.surfels);
    counts.points = static_cast<int>(meetings.size());
    for (int k = 0; k < counts.points; ++k) {
      Fetch(meetings[std::min(k + kMeetingsAhead, counts.points - 1)].pixel);
      Merge(camera, meetings[k], map);
    }
    return counts;
  });
}

// Asks for what Merge() will look at.
void Fusion::Workspace::Fetch(int pixel) const {
  __builtin_prefetch(&points[pixel]);
  __builtin_prefetch(&weights[pixel]);
  if (!frame->color.empty()) __builtin_prefetch(&frame->color[pixel]);
}

void Fusion::Workspace::Merge(const PosedCamera& camera, const Meeting& meeting,
                              SurfelMap* map) const {
  const std::int32_t i = meeting.surfel;
  const MeasuredPoint& point = points[meeting.pixel];
  SurfelObservation observation;
  observation.position_in_world = camera.PointInWorld(point.position);
  observation.normal_in_world = camera.world_rotation * point.normal;
  observation.color = frame->color.empty() ? map->Color(i) : frame->color[meeting.pixel];
  observation.radius_m = point.radius_m;
  observation.weight = weights[meeting.pixel];
  observation.at_edge = point.at_edge;
  const bool fine = !point.at_edge && point.radius_m < options.max_radius_ratio * map->radius_m[i];
  map->Merge(i, observation, fine, options.max_confidence);
  map->last_seen[i] = frame->index;
}

}  // namespace surfit
