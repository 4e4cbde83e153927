#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <vector>

#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/slam/slam.h"
#include "tracking/tracker.h"

namespace surfit {

// Owns the map: fuses frames, renders model views, and applies corrections by loop closures and
// calibrations. Call Fuse() or Skip() for each frame with a pose, and Correct() between frames. All
// functions run on the tracking thread.
class Mapper : public ModelViews {
 public:
  // Keeps a reference to the options. With loops, `fusion.active_frames` must be
  // LoopOptions::active_frames. `use`: kLocalize disables ActivateAround().
  Mapper(const DepthSensor& sensor, const SlamOptions& options, StateUse use);

  // Replaces the map. Call before the first frame. `fused_frames`: indices of its fused frames,
  // ascending; may be empty. The map contains the first `submaps` submaps.
  void ContinueFrom(SurfelMap map, const std::vector<int>& fused_frames, int submaps);
  // Keeps the pointer, and reads it in each call. Null: the calibration of the input sensor.
  void UseCalibration(const DepthCalibration* calibration) { calibration_ = calibration; }

  // Map of the current submap. The reference stays valid, the content changes with Fuse(),
  // Correct(), ActivateAround() and UseSubmap().
  const SurfelMap& map() const { return map_; }
  // Bounding box of the map of each submap, m. Empty box without surfels.
  std::vector<Eigen::AlignedBox3d> Boxes() const;
  // Total number of merged duplicate surfels, and number of changes by Correct() and UseSubmap().
  std::size_t merged_duplicates() const { return merged_duplicates_; }
  int corrections() const { return corrections_; }

  // Input sensor with the current camera and readout.
  DepthSensor sensor() const;

  const ReferenceView& View() const override { return view_; }
  bool Update(const Rigid3d& world_from_predicted, bool must, bool with_intensities) override;
  ReferenceView ViewAt(const Rigid3d& world_from_view, bool with_intensities) override {
    return Render(&renderer_, world_from_view, with_intensities);
  }
  ReferenceView NewestViewAt(const Rigid3d& world_from_view, bool with_intensities) override {
    return Render(&newest_renderer_, world_from_view, with_intensities);
  }
  // Does nothing in localisation.
  void ActivateAround(int frame_index, int now) override;
  void UseSubmap(int submap) override;

  // Replaces SlamOptions::map_period. Requires frames >= 1.
  void SetPeriod(int frames) { period_ = frames; }
  bool has_longer_period() const { return period_ > options_.map_period; }
  // True after the period, or after a large image shift since the last fused frame.
  // `max_view_shift` limits the shift, and 1.5 `max_view_shift` with a longer period.
  bool IsTurnToFuse(const PreprocessedFrame& frame, const Rigid3d& world_from_camera) const;
  // Fuses a frame without moving objects. `motion`: camera velocity during the frame. Restarts the
  // period.
  FusionReport Fuse(const PreprocessedFrame& frame, const Rigid3d& world_from_camera,
                    const CameraMotion& motion);
  // Counts a frame that is not fused.
  void Skip() { ++unfused_count_; }

  // Moves the map by a loop closure or a calibration, and merges duplicate surfels. `frame_index`:
  // index of the current frame. Also activates surfels near loop closures.
  void Correct(const WorldCorrection& correction, int frame_index);

 private:
  int MapOfSubmap(int submap);
  SurfelMap& MapAt(int map) { return map == current_ ? map_ : parked_.at(map); }
  bool JoinMaps(const std::vector<int>& piece_of_submap);
  double MaxViewShift() const;
  ReferenceView Render(ModelRenderer* renderer, const Rigid3d& world_from_view,
                       bool with_intensities);

  const SlamOptions& options_;
  const bool may_change_;
  const DepthSensor input_sensor_;
  const DepthCalibration* calibration_ = nullptr;
  ModelRenderer renderer_;
  ModelRenderer newest_renderer_;  // treats all surfels as stable
  Fusion fusion_;
  SurfelMap map_;                    // current map
  std::map<int, SurfelMap> parked_;  // maps of submaps that are not connected to the current one
  int current_ = 0;                  // number of `map_`: its first submap
  std::vector<int> map_of_submap_ = {0};
  ReferenceView view_;
  bool has_view_ = false;  // `view_` uses the current calibration
  bool is_view_new_ = false;
  int period_;
  int unfused_count_ = 0;
  Rigid3d world_from_fused_;
  std::size_t merged_duplicates_ = 0;
  int corrections_ = 0;
  int merged_until_ = 0;  // duplicates are merged for all surfels first seen before this frame
};

}  // namespace surfit
