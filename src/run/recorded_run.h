#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/frame_source.h"

namespace surfit {

// What a run of surfit_slam has left of itself beside its map.
struct RecordedRun {
  Trajectory trajectory;
  std::map<int, Rigid3d> world_from_camera;     // by the frame's index
  std::optional<DepthCalibration> calibration;  // that the run found of the frames as it read them
  double color_latency_s = 0;                   // likewise, beyond the given one
  std::set<int> held_out;                       // frames

  // What the run saw these frames with in the end.
  DepthSensor SensorOf(const SequenceInfo& frames) const;
  // A frame as it saw it in the end: depth corrected, colour at its moment.
  void Correct(RgbdFrame* frame) const;
};

// Reads poses.json and summary.json of the run's folder. Throws InputError naming the file at
// fault.
RecordedRun ReadRecordedRun(const std::string& folder);

// Throws InputError unless frames have the size of those that the run was calibrated by.
void RequireCameraOfFrames(const RecordedRun& run, const std::string& folder,
                           const PinholeCamera& frames);

}  // namespace surfit
