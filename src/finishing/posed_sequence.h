#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "surfit/frame/frame_source.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/sequence.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Estimated calibration for prepared frames: undistorted and downsampled, with the input depth
// field applied.
struct EstimatedSensor {
  std::optional<DepthCalibration> calibration;  // std::nullopt: input calibration
  double color_latency_s = 0;                   // beyond the input latency

  // Returns the input sensor with the estimated camera and readout.
  DepthSensor Of(DepthSensor given) const;
  // Corrects the depth of a prepared frame, and subtracts the latency from color_stamp_s. Call it
  // once per frame.
  void Correct(RgbdFrame* frame) const;
};

// Returns a warning if the estimated calibration contradicts the prior of the input sensor, else
// "". The input camera may then belong to another sensor or image size. Uses a chi-square test with
// 10 degrees of freedom and 1 % false alarms. A parameter with a standard deviation of 0 in the
// prior is unknown and not compared. Both calibrations are for prepared frames.
std::string CalibrationWarning(const DepthSensor& given, const DepthCalibration& found);

// Sequence with the final results of a run. The references must outlive the object.
struct PosedSequence {
  const SequenceOptions& sequence;  // options of the run
  const SlamOptions& slam;
  const Trajectory& trajectory;    // in the world frame of the map; one pose per frame of `frames`
  const std::vector<int>& frames;  // frame index of each pose, ascending
  const std::set<int>& left_out;   // indices of frames that are not fused
  // Moving cells by frame index, as in FrameReport::moving. Frames without an entry have none.
  const std::map<int, Image<std::uint8_t>>& moving;
  EstimatedSensor found;  // estimated by the run
};

// Range of frame indices, both inclusive.
struct FrameRange {
  int first = 0, last = 0;
};

// Opens a sequence and reads a few frames ahead. `ranges` selects frames of the options, and must
// be ascending and disjoint. A range without a frame of the stride gives no frame. Empty `ranges`:
// all frames of the options. Throws InputError like OpenSequence().
std::unique_ptr<FrameSource> ReopenSequence(const SequenceOptions& sequence,
                                            const std::vector<FrameRange>& ranges = {});

// Calls `call` for each readable frame with a pose, also for frames in `left_out`. `pose` is the
// index in the trajectory. The frame is uncalibrated, and its depth in moving cells is 0. The
// source may have another image size than the run. Returns false if interrupted. `interrupted` is
// checked before each frame.
bool ReadPosedFrames(const PosedSequence& known, FrameSource* source,
                     const std::atomic<bool>& interrupted,
                     const std::function<void(std::size_t pose, RgbdFrame frame)>& call);

}  // namespace surfit
