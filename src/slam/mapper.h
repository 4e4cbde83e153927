#pragma once

#include <cstddef>
#include <vector>

#include "surfit/mapping/fusion.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/slam/slam.h"
#include "tracking/tracker.h"

namespace surfit {

// Keeps the map: fuses frames into it, draws the views that frames are registered to, in turns,
// and moves it where loops have been closed.
class Mapper : public ModelViews {
 public:
  // Keeps a reference to the options. If loops are enabled, fusion.active_frames is the bound of
  // LoopOptions.
  Mapper(const DepthSensor& sensor, const SlamOptions& options, StateUse use);

  // Continues with a map after these fused frames.
  void GoOnFrom(SurfelMap map, const std::vector<int>& fused_frames);
  // Keeps the pointer to the estimated calibration. Null: the input sensor.
  void UseCalibration(const DepthCalibration* calibration) { calibration_ = calibration; }

  const SurfelMap& map() const { return map_; }
  // Surfels that became part of others when the map was moved, in all.
  std::size_t merged_doubles() const { return merged_doubles_; }
  // How often surfels have changed that no frame was fused to.
  int corrections() const { return corrections_; }

  // Sensor with the estimated calibration.
  DepthSensor sensor() const;

  const ReferenceView& View() const override { return view_; }
  bool Update(const Rigid3d& world_from_predicted, bool must, bool with_intensities) override;
  ReferenceView ViewAt(const Rigid3d& world_from_view, bool with_intensities) override {
    return Render(&renderer_, world_from_view, with_intensities);
  }
  ReferenceView NewestViewAt(const Rigid3d& world_from_view, bool with_intensities) override {
    return Render(&newest_renderer_, world_from_view, with_intensities);
  }
  // Does nothing if the map is only used for localisation.
  void ActivateAround(int frame_index, int now) override;

  // Of so many frames that are held one has its turn to be fused, of SlamOptions::map_period at
  // first.
  void SetPeriod(int frames) { period_ = frames; }
  bool is_hurried() const { return period_ > options_.map_period; }
  // Also one that sees much that the last did not.
  bool IsTurnToFuse(const PreparedFrame& frame, const Rigid3d& world_from_camera) const;
  FusionReport Fuse(const PreparedFrame& frame, const Rigid3d& world_from_camera,
                    const CameraMotion& motion);
  void Skip() { ++unfused_count_; }

  void Correct(const WorldCorrection& correction, int frame_index);

 private:
  ReferenceView Render(ModelRenderer* renderer, const Rigid3d& world_from_view,
                       bool with_intensities);

  const SlamOptions& options_;
  const bool may_change_;
  const DepthSensor input_sensor_;
  const DepthCalibration* calibration_ = nullptr;
  ModelRenderer renderer_;
  ModelRenderer newest_renderer_;  // for which all surfels are stable
  Fusion fusion_;
  SurfelMap map_;
  ReferenceView view_;
  bool has_view_ = false;     // of today's camera
  bool is_view_new_ = false;  // the map has not changed since it was drawn
  int period_;
  int unfused_count_ = 0;     // frames that were held since the last one that was fused
  Rigid3d world_from_fused_;  // of that one
  std::size_t merged_doubles_ = 0;
  int corrections_ = 0;
  int merged_until_ = 0;  // frame before which all doubles of the map are merged
};

}  // namespace surfit
