#pragma once

#include <functional>
#include <optional>
#include <utility>

#include "slam/mapper.h"
#include "slam/tracker.h"
#include "surfit/slam/backend.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Finds where a frame was taken: from where the camera is expected, against what the map shows from
// there; where that fails or is in doubt, from the last good frame, and by keyframes that show the
// same place. What is found far away must agree with the map.
class PoseFinder {
 public:
  // Keeps references to all. Where the map may not be changed, no new one is begun either.
  PoseFinder(const SlamOptions& options, bool may_change_map, Tracker* tracker, Mapper* mapper)
      : options_(options), may_change_map_(may_change_map), tracker_(tracker), mapper_(mapper) {}

  // Null without loops and calibration.
  void UseBackend(Backend* backend) { backend_ = backend; }
  void OnLostFrame(std::function<void(const LostFrame&)> call) { on_lost_ = std::move(call); }

  Tracked Find(const PreparedFrame& frame, StageTimes* times);
  // What the next frame is expected to see, if it has colours like the last, so that its pose need
  // not wait for the drawing.
  void DrawForNext(const RgbdFrame& last, StageTimes* times);

 private:
  bool UpdateView(const Rigid3d& world_from_predicted, bool has_intensities);
  Tracked TrackFromPrediction(const PreparedFrame& frame, StageTimes* times);
  Tracked AgainstNewest(const PreparedFrame& frame, Tracked tracked);
  bool IsFar(const PreparedFrame& frame, const Rigid3d& world_from_camera) const;
  Tracked SearchFor(const PreparedFrame& frame, Tracked tracked);
  std::optional<Tracked> ConfirmProposal(const PreparedFrame& frame, const Tracked& tracked);
  std::optional<Tracked> FindAgain(const PreparedFrame& frame);
  std::optional<Tracked> Relocalize(const PreparedFrame& frame);
  std::optional<Tracked> Confirm(const PreparedFrame& frame, const Rigid3d& world_from_found);
  bool IsNewMapDue(const PreparedFrame& frame) const;
  bool tracks_frame_to_frame() const { return options_.tracking == "frame_to_frame"; }

  const SlamOptions& options_;
  const bool may_change_map_;
  Tracker* tracker_;
  Mapper* mapper_;
  Backend* backend_ = nullptr;
  std::function<void(const LostFrame&)> on_lost_;
};

}  // namespace surfit
