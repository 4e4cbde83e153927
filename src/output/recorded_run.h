#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "finishing/posed_sequence.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Results of a run of surfit_slam, in the world frame of its map.
struct RecordedRun {
  Trajectory trajectory;                     // in the order of poses.json
  std::map<int, Rigid3d> world_from_camera;  // by frame index
  EstimatedSensor found;                     // for prepared frames
  std::set<int> held_out;                    // indices of frames that were not fused; may be empty
};

// Reads poses.json and summary.json from the folder of a run. Throws InputError with the path of a
// missing or invalid file, and without the path for an invalid camera. Quaternions are normalised,
// but not checked.
RecordedRun ReadRecordedRun(const std::string& folder);

// Throws InputError if the calibration of the run has another image size than `frames`, the camera
// of the prepared frames. Does nothing without an estimated calibration.
void RequireCameraOfFrames(const RecordedRun& run, const std::string& folder,
                           const PinholeCamera& frames);

// Default file names of EvaluateViews(), in the folder of a run: tables and up to kMaxViewPictures
// pictures. `rank` 0: worst view.
inline constexpr int kMaxViewPictures = 100;
std::string ViewPictureName(int rank);
std::vector<std::string> ViewFileNames();

}  // namespace surfit
