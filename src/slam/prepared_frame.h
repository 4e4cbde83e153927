#pragma once

#include "slam/moving_regions.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/registration/far_registration.h"
#include "surfit/slam/backend.h"

namespace surfit {

// A frame as tracking and fusion take it.
struct PreparedFrame {
  const RgbdFrame& images;  // its depth brought to the middle of the readout
  ColoredView view;
  CameraMotion motion;  // by which

  const FrameLevel& surface() const { return view.pyramid.levels.front(); }
};

// Makes frames as tracking and fusion take them. What it returns may refer to images of its own,
// which last until the next frame.
class FrameMaker {
 public:
  // Keeps a reference to the options.
  explicit FrameMaker(const PreprocessOptions& options) : options_(options) {}

  // By the sensor and what the backend (may be null) has found of it, and the expected motion.
  PreparedFrame Prepare(const RgbdFrame& frame, const CameraMotion& motion,
                        const DepthSensor& sensor, const Backend* backend, bool with_intensities);

  // Without what moves: a frame as given, and one that was prepared.
  const RgbdFrame& AtRest(const RgbdFrame& frame, const CellMask& moving);
  PreparedFrame AtRest(PreparedFrame frame, const CellMask& moving);

 private:
  const RgbdFrame& AsSeen(const RgbdFrame& frame, const CameraMotion& motion,
                          const DepthSensor& sensor, const Backend* backend);

  const PreprocessOptions& options_;
  RgbdFrame seen_;              // the frame, if it is not taken as it comes
  RgbdFrame seen_rest_, rest_;  // the same, and the frame as given, without what moves
};

}  // namespace surfit
