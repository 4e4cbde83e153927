#include "surfit/mapping/fusion.h"

#include <algorithm>
#include <deque>

#include "mapping/fusion/frame_observations.h"
#include "mapping/fusion/measured_points.h"
#include "mapping/map/block_lanes.h"
#include "mapping/map/block_observations.h"
#include "mapping/map/merge_gate.h"
#include "mapping/map/surfel_assignment.h"
#include "mapping/rendering/bands.h"
#include "mapping/rendering/frame_colors.h"
#include "mapping/rendering/posed_camera.h"
#include "surfit/core/error.h"
#include "surfit/core/lanes.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kCandidatesAhead = 16;

// Drops new surfels that would exceed `max_map_points`. Returns the number of dropped surfels.
int DropAboveLimit(int max_map_points, std::size_t map_points, std::vector<Surfel>* added) {
  if (max_map_points == 0) return 0;
  const auto most = static_cast<std::size_t>(max_map_points);
  const std::size_t places = most > map_points ? most - map_points : 0;
  if (added->size() <= places) return 0;
  const auto refused = static_cast<int>(added->size() - places);
  added->resize(places);
  return refused;
}

}  // namespace

class FrameWindow {
 public:
  // Window of the last `frames` + 1 frames.
  explicit FrameWindow(int frames) : most_(static_cast<std::size_t>(frames) + 1) {}

  void Push(int index) {
    indices_.push_back(index);
    if (indices_.size() > most_) indices_.pop_front();
  }

  // Oldest frame index in the window. Minimum of int while the window has fewer than `frames` + 1
  // frames.
  int Begin() const {
    return indices_.size() == most_ ? indices_.front() : std::numeric_limits<int>::min();
  }

 private:
  const std::size_t most_;
  std::deque<int> indices_;
};

// Options and buffers of Fusion, reused for every frame.
struct Fusion::Workspace {
  explicit Workspace(const FusionOptions& fusion_options)
      : options(fusion_options),
        gate(fusion_options),
        choice(gate),
        awake(fusion_options.max_inactive_frames),
        active(fusion_options.active_frames) {}

  void Begin(const RgbdFrame& new_frame, const FrameLevel& surface);
  void FindCandidates(const PosedCamera& camera, SurfelMap* map);
  int ActiveSince() const;
  bool MayBeInactive(const SurfelBounds& bounds) const;
  void MarkInactive(SurfelBlock* block) const;
  std::vector<Surfel> NewSurfels(const PosedCamera& camera, const FrameColors& colors);
  Surfel NewSurfel(const PosedCamera& camera, int pixel) const;
  void SetColors(const FrameColors& colors, const std::vector<int>& pixels, Surfel* surfels) const;
  void MergePoints(SurfelMap* map) const;
  void MergePoints(const std::vector<Candidate>& of_cell, SurfelMap* map) const;

  const FusionOptions& options;
  const MergeGate gate;
  SurfelAssignment choice;
  FrameObservations sightings;
  const RgbdFrame* frame = nullptr;
  FrameWindow awake;  // low-confidence surfels unseen in this window are removed
  FrameWindow active;
  Image<float> weights;
  double weights_cx = 0, weights_cy = 0;
  std::vector<MeasuredPoint> points;  // per pixel
  Image<float> free_depth_m;          // per pixel
  std::vector<std::int32_t> cells;
  std::vector<CandidateList> candidates;
};

Fusion::Fusion(const FusionOptions& options)
    : options_((Validate(options), options)), workspace_(std::make_unique<Workspace>(options_)) {}

Fusion::~Fusion() = default;

int Fusion::ActiveSince() const { return workspace_->ActiveSince(); }

void Fusion::ContinueAfter(const std::vector<int>& fused_frames) {
  for (const int index : fused_frames) {
    workspace_->awake.Push(index);
    workspace_->active.Push(index);
  }
}

FusionReport Fusion::Fuse(const RgbdFrame& frame, const FrameLevel& surface,
                          const Rigid3d& world_from_camera, const FrameMotion& motion,
                          SurfelMap* map) {
  ThrowIf(frame.index < 0 || frame.index > SurfelBlock::kMaxFrame, "the frame index ", frame.index,
          " must be from 0 to ", SurfelBlock::kMaxFrame);
  ThrowIf(frame.depth_m.width() != surface.camera.width ||
              frame.depth_m.height() != surface.camera.height,
          "frame ", frame.index, ": the depth image has ", frame.depth_m.width(), " x ",
          frame.depth_m.height(), " pixels, must have ", surface.camera.width, " x ",
          surface.camera.height, " like its surface");
  const PosedCamera camera(surface.camera, world_from_camera);
  Workspace& work = *workspace_;
  work.Begin(frame, surface);
  const FrameColors colors(frame, camera, motion);
  work.FindCandidates(camera, map);
  FusionReport report;
  work.choice.SetCandidates(camera.width, camera.height, &work.candidates);
  report.input_points = work.choice.AssignAll(work.points);
  const FrameObservations::Counts merged =
      work.sightings.Gather(frame, colors, work.points, work.weights, camera, work.choice);
  work.MergePoints(map);
  std::vector<Surfel> added = work.NewSurfels(camera, colors);
  report.merged_points = merged.points;
  report.merged = merged.surfels;
  report.covered_points =
      report.input_points - report.merged_points - static_cast<int>(added.size());
  report.removed = static_cast<int>(map->RemoveMarked());
  report.refused = DropAboveLimit(options_.max_map_points, map->size(), &added);
  report.added = static_cast<int>(added.size());
  map->Append(added);
  return report;
}

void Fusion::Workspace::Begin(const RgbdFrame& new_frame, const FrameLevel& surface) {
  frame = &new_frame;
  awake.Push(frame->index);
  active.Push(frame->index);
  const int width = surface.camera.width, height = surface.camera.height;
  const PinholeCamera& camera = surface.camera;
  if (weights.width() != width || weights.height() != height || weights_cx != camera.cx ||
      weights_cy != camera.cy) {
    weights = PointWeights(camera);
    weights_cx = camera.cx;
    weights_cy = camera.cy;
  }
  MeasurePoints(new_frame, surface, options, &points);
  free_depth_m = FreeDepths(frame->depth_m, surface.noise, options);
}

int Fusion::Workspace::ActiveSince() const {
  return options.active_frames == 0 ? std::numeric_limits<int>::min() : active.Begin();
}

// False: MarkInactive() would mark no surfel inside these bounds.
bool Fusion::Workspace::MayBeInactive(const SurfelBounds& bounds) const {
  return bounds.least_last_seen < awake.Begin() &&
         bounds.least_confidence < options.min_inactive_confidence;
}

// Marks low-confidence surfels for removal if their last observation is older than the window
// `awake`. Updates the bounds of the block.
void Fusion::Workspace::MarkInactive(SurfelBlock* block) const {
  constexpr int kCapacity = SurfelBlock::kCapacity;
  const float lasting = options.min_inactive_confidence;
  const int since = awake.Begin(), count = block->count;
  block->to_remove |= WithInstructions([&](auto) {
    PerSurfel<std::uint8_t> dormant;
    PerSurfel<float> confidence;
    std::int32_t least_last_seen = std::numeric_limits<std::int32_t>::max();
    for (int k = 0; k < kCapacity; ++k) {
      confidence[k] = k < count ? block->Confidence(k) : lasting;
      const std::int32_t last_seen = k < count ? block->LastSeen(k) : since;
      dormant[k] = (last_seen < since) & (confidence[k] < lasting);
      least_last_seen = last_seen < least_last_seen ? last_seen : least_last_seen;
    }
    block->bounds.least_confidence = LeastOf(confidence);
    block->bounds.least_last_seen = least_last_seen;
    return MaskOf(dormant);
  });
}

// Finds surfels that pass the merge gate with the measured point at their pixel. Marks inactive
// surfels and free-space violations for removal.
void Fusion::Workspace::FindCandidates(const PosedCamera& camera, SurfelMap* map) {
  const CandidateFinder finder(camera, points, free_depth_m, gate, ActiveSince());
  cells.clear();
  for (std::int32_t i = 0; i < map->cell_count(); ++i) {
    const SurfelBounds& bounds = map->cell(i).bounds;
    if (finder.MaySee(bounds) || MayBeInactive(bounds)) cells.push_back(i);
  }
  candidates.resize(cells.size());
  ParallelFor(0, static_cast<int>(cells.size()), 1, [&](int i, int) {
    SurfelCell& cell = map->cell(cells[i]);
    CandidateList& list = candidates[i];
    ClearClosely(cell.blocks.size() * SurfelBlock::kCapacity, &list.candidates);
    std::vector<std::int32_t> seen;
    seen.reserve(cell.blocks.size());
    for (std::size_t k = 0; k < cell.blocks.size(); ++k) {
      const std::int32_t b = cell.blocks[k];
      SurfelBlock& block = map->block(b);
      FetchAges(map->block(cell.blocks[std::min(k + 2, cell.blocks.size() - 1)]));
      if (MayBeInactive(block.bounds)) MarkInactive(&block);
      if (finder.MaySee(block.bounds)) seen.push_back(b);
    }
    finder.Find(seen, map, &list.candidates);
    cell.is_marked = std::any_of(cell.blocks.begin(), cell.blocks.end(),
                                 [&](std::int32_t b) { return map->block(b).to_remove != 0; });
    list.bands.Clear(BandCount(camera.height));
    for (std::size_t k = 0; k < list.candidates.size(); ++k) {
      list.bands.Add(static_cast<int>(k), list.candidates[k].pixel / (camera.width * kBandRows));
    }
  });
}

std::vector<Surfel> Fusion::Workspace::NewSurfels(const PosedCamera& camera,
                                                  const FrameColors& colors) {
  const std::vector<std::vector<int>>& bands = choice.SelectNew(points);
  std::vector<std::size_t> begins = {0};
  for (const std::vector<int>& of_band : bands) begins.push_back(begins.back() + of_band.size());
  std::vector<Surfel> added(begins.back());
  ParallelFor(0, static_cast<int>(bands.size()), 1, [&](int band, int) {
    Surfel* const of_band = added.data() + begins[band];
    for (std::size_t k = 0; k < bands[band].size(); ++k) {
      of_band[k] = NewSurfel(camera, bands[band][k]);
    }
    if (!frame->color.empty()) SetColors(colors, bands[band], of_band);
  });
  return added;
}

Surfel Fusion::Workspace::NewSurfel(const PosedCamera& camera, int pixel) const {
  const MeasuredPoint& point = points[pixel];
  Surfel surfel;
  surfel.position_in_world = camera.PointInWorld(point.position());
  surfel.normal_in_world = camera.world_rotation * point.normal();
  surfel.color = {128, 128, 128};
  surfel.radius_m = point.radius_m;
  surfel.confidence = weights[pixel];
  surfel.at_edge = point.at_edge;
  surfel.first_seen = surfel.last_seen = frame->index;
  return surfel;
}

void Fusion::Workspace::SetColors(const FrameColors& colors, const std::vector<int>& pixels,
                                  Surfel* surfels) const {
  ColorBatch batch;
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    batch.Add(points[pixels[k]].position(), points[pixels[k]].normal());
    if (batch.count < ColorBatch::kCapacity && k + 1 < pixels.size()) continue;
    colors.LookUp(&batch);
    Surfel* const first = surfels + (k + 1 - batch.count);
    for (int i = 0; i < batch.count; ++i) {
      const SeenColor seen = batch.Seen(i);
      first[i].color = ToRgb8(seen.color);
      first[i].color_weight = seen.weight;
    }
    batch.count = 0;
  }
}

// Merges candidates with their observations. Marks duplicate candidates for removal.
void Fusion::Workspace::MergePoints(SurfelMap* map) const {
  ParallelFor(0, static_cast<int>(candidates.size()), 1, [&](int list, int) {
    MergePoints(candidates[list].candidates, map);
    SurfelCell& cell = map->cell(cells[list]);
    cell.bounds = {};
    for (const std::int32_t b : cell.blocks) {
      cell.bounds.Add(map->block(b).bounds);
      cell.is_marked |= map->block(b).to_remove != 0;
    }
  });
}

void Fusion::Workspace::MergePoints(const std::vector<Candidate>& of_cell, SurfelMap* map) const {
  const int count = static_cast<int>(of_cell.size());
  const auto block_of = [&](int k) { return of_cell[k].surfel / SurfelBlock::kCapacity; };
  BlockObservations of_block;
  for (int k = 0; k < count; ++k) {
    const int soon = std::min(k + kCandidatesAhead, count - 1);
    if (of_cell[soon].seen) Fetch(of_cell[soon].seen, of_cell[soon].seen + 1);
    if (soon == 0 || block_of(soon) != block_of(soon - 1)) FetchAll(map->block(block_of(soon)));
    const Candidate& candidate = of_cell[k];
    SurfelBlock& block = map->block(block_of(k));
    const int place = candidate.surfel % SurfelBlock::kCapacity;
    block.to_remove |= static_cast<std::uint64_t>(candidate.is_duplicate) << place;
    if (candidate.seen) {
      of_block.Add(place, *candidate.seen);
      block.SetLastSeen(place, frame->index);
    }
    if (k + 1 < count && block_of(k + 1) == block_of(k)) continue;
    if (!of_block.empty()) {
      of_block.MergeInto(&block, FusionOptions::kMaxConfidence);
      of_block.Clear();
    }
    BoundPositions(&block);
  }
}

}  // namespace surfit
