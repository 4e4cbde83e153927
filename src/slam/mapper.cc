#include "slam/mapper.h"

#include <algorithm>
#include <utility>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/mapping/move_map.h"

namespace surfit {
namespace {

// Intensities of the visible surfels, one per ViewGrid cell. 0: no surfel.
Image<float> GreyOfCells(const ModelView& seen, const SurfelMap& map) {
  const ViewGrid grid(seen.surface.camera);
  Image<float> grey(grid.width, grid.height, 0.f);
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      const std::int32_t surfel = seen.surfel_index(grid.Pixel(u), grid.Pixel(v));
      if (surfel != ModelView::kNoSurfel) grey(u, v) = GreyOf(map.Color(surfel));
    }
  }
  return grey;
}

// -1 without a visible surfel.
double MeanFirstSeen(const ModelView& seen, const SurfelMap& map) {
  const ViewGrid grid(seen.surface.camera);
  double sum = 0;
  int count = 0;
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      const std::int32_t surfel = seen.surfel_index(grid.Pixel(u), grid.Pixel(v));
      if (surfel == ModelView::kNoSurfel) continue;
      const std::int32_t block = surfel / SurfelBlock::kCapacity;
      sum += map.block(block).FirstSeen(surfel % SurfelBlock::kCapacity);
      ++count;
    }
  }
  return count > 0 ? sum / count : -1;
}

RenderOptions WithAllStable(RenderOptions options) {
  options.stable_confidence = 0;
  return options;
}

// DuplicateOptions::frames_apart of surfels in two submaps. No frame observes both.
constexpr int kFramesBetweenSubmaps = 1;

}  // namespace

Mapper::Mapper(const DepthSensor& sensor, const SlamOptions& options, StateUse use)
    : options_(options),
      may_change_(use == StateUse::kContinue),
      input_sensor_(sensor),
      renderer_(options.render),
      newest_renderer_(WithAllStable(options.render)),
      fusion_(options.fusion),
      period_(options.map_period) {}

void Mapper::ContinueFrom(SurfelMap map, const std::vector<int>& fused_frames, int submaps) {
  map_ = std::move(map);
  map_of_submap_.assign(submaps, 0);
  fusion_.ContinueAfter(fused_frames);
  if (!fused_frames.empty()) merged_until_ = fused_frames.back();
}

DepthSensor Mapper::sensor() const {
  DepthSensor sensor = input_sensor_;
  if (calibration_) {
    sensor.camera = calibration_->camera;
    sensor.readout_s = calibration_->readout_s;
  }
  return sensor;
}

ReferenceView Mapper::Render(ModelRenderer* renderer, const Rigid3d& world_from_view,
                             bool with_intensities) {
  ModelView seen = renderer->Render(map_, sensor(), world_from_view, fusion_.ActiveSince());
  DropNormalsAtEdges(options_.preprocess, &seen.surface);
  Image<float> grey = GreyOfCells(seen, map_);
  ReferenceView reference = {{BuildPyramid(std::move(seen.surface), options_.preprocess), {}},
                             world_from_view,
                             std::move(grey),
                             MeanFirstSeen(seen, map_)};
  if (with_intensities) {
    // Uses colours of the map. Colours of the last frame would increase the ATE by 14 % in
    // simulated rooms, and up to 8 times in simple scenes.
    reference.view.color = ColorsOf(seen, map_);
    AddIntensity(reference.view.color, &reference.view.pyramid);
  }
  return reference;
}

bool Mapper::Update(const Rigid3d& world_from_predicted, bool must, bool with_intensities) {
  if (is_view_new_ && view_.world_from_view == world_from_predicted &&
      view_.has_intensities() == with_intensities) {
    return true;
  }
  const bool is_turn = must || !has_view_ || unfused_count_ == 0;
  const auto shift = [&] {
    return ImageShift(view_.world_from_view.Inverse() * world_from_predicted,
                      view_.view.pyramid.levels.back());
  };
  if (!is_turn && shift() <= MaxViewShift()) return false;
  view_ = ViewAt(world_from_predicted, with_intensities);
  has_view_ = is_view_new_ = true;
  return true;
}

bool Mapper::IsTurnToFuse(const PreprocessedFrame& frame, const Rigid3d& world_from_camera) const {
  return unfused_count_ + 1 >= period_ ||
         ImageShift(world_from_fused_.Inverse() * world_from_camera,
                    frame.view.pyramid.levels.back()) > MaxViewShift();
}

double Mapper::MaxViewShift() const {
  // Fast motion exceeds the given bound in every fourth frame, so a longer period saves little.
  constexpr double kInAHurry = 1.5;
  return (has_longer_period() ? kInAHurry : 1) * options_.max_view_shift;
}

FusionReport Mapper::Fuse(const PreprocessedFrame& frame, const Rigid3d& world_from_camera,
                          const CameraMotion& motion) {
  unfused_count_ = 0;
  is_view_new_ = false;
  world_from_fused_ = world_from_camera;
  return fusion_.Fuse(frame.images, frame.surface(), world_from_camera,
                      {motion, sensor().readout_s}, &map_);
}

void Mapper::Correct(const WorldCorrection& correction, int frame_index) {
  ++corrections_;
  is_view_new_ = false;
  if (correction.moves) world_from_fused_ = correction.new_from_old_now * world_from_fused_;
  const int active_frames = options_.fusion.active_frames;
  if (correction.recalibration) {
    MoveMap(correction.corrections, *correction.recalibration, &map_);
    for (auto& [number, map] : parked_) {
      MoveMap(correction.corrections, *correction.recalibration, &map);
    }
    has_view_ = false;
  } else if (correction.moves) {
    MoveMap(correction.corrections, &map_);
    for (auto& [number, map] : parked_) MoveMap(correction.corrections, &map);
    view_.world_from_view = correction.new_from_old_now * view_.world_from_view;
  }
  const bool joins_maps = JoinMaps(correction.piece_of_submap);
  // A calibration moves neighbouring surfels equally and creates no duplicates.
  if ((correction.moves && !correction.recalibration) || active_frames > 0) {
    DuplicateOptions doubles;
    doubles.frames_apart = std::max(active_frames, options_.loops.frames_apart);
    if (joins_maps) doubles.frames_apart = kFramesBetweenSubmaps;
    if (!correction.moves && !joins_maps)
      doubles.newer_since = merged_until_;  // older surfels have not changed
    merged_duplicates_ += MergeDuplicates(options_.fusion, doubles, &map_);
    merged_until_ = frame_index;
  }
  for (const int joined : correction.joined) ActivateAround(joined, frame_index);
}

// Appends the later of two maps with a common piece to the earlier map. Returns whether any maps
// were joined.
bool Mapper::JoinMaps(const std::vector<int>& piece_of_submap) {
  bool joins_maps = false;
  std::map<int, int> map_of_piece;
  for (std::size_t submap = 0; submap < piece_of_submap.size(); ++submap) {
    const int from = MapOfSubmap(static_cast<int>(submap));
    const int to = map_of_piece.emplace(piece_of_submap[submap], from).first->second;
    if (from == to) continue;
    joins_maps = true;
    AppendSurfels(MapAt(from), 0, &MapAt(to));
    if (from == current_) {
      map_ = std::move(parked_.at(to));
      current_ = to;
      parked_.erase(to);
    } else {
      parked_.erase(from);
    }
    std::replace(map_of_submap_.begin(), map_of_submap_.end(), from, to);
  }
  return joins_maps;
}

int Mapper::MapOfSubmap(int submap) {
  while (static_cast<int>(map_of_submap_.size()) <= submap) {
    map_of_submap_.push_back(static_cast<int>(map_of_submap_.size()));
    parked_[map_of_submap_.back()];
  }
  return map_of_submap_[submap];
}

void Mapper::UseSubmap(int submap) {
  const int next = MapOfSubmap(submap);
  if (next == current_) return;
  SurfelMap map = std::move(parked_.at(next));
  parked_.erase(next);
  parked_[current_] = std::move(map_);
  map_ = std::move(map);
  current_ = next;
  has_view_ = is_view_new_ = false;
  ++corrections_;
}

std::vector<Eigen::AlignedBox3d> Mapper::Boxes() const {
  std::map<int, Eigen::AlignedBox3d> box_of_map;
  const auto add = [&](int number, const SurfelMap& map) {
    Eigen::AlignedBox3d& box = box_of_map[number];
    for (const std::int32_t id : map.Ids()) box.extend(map[id].position_in_world.cast<double>());
  };
  add(current_, map_);
  for (const auto& [number, map] : parked_) add(number, map);
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const int number : map_of_submap_) boxes.push_back(box_of_map[number]);
  return boxes;
}

void Mapper::ActivateAround(int frame_index, int now) {
  const int active_frames = options_.fusion.active_frames;
  if (active_frames == 0 || !may_change_) return;
  is_view_new_ = false;
  ReactivateSurfels(frame_index - active_frames, frame_index + active_frames, now, &map_);
}

}  // namespace surfit
