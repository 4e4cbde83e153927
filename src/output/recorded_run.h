#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "finishing/known_sequence.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// What a run of surfit_slam has left of itself beside its map.
struct RecordedRun {
  Trajectory trajectory;
  std::map<int, Rigid3d> world_from_camera;  // by the frame's index
  FoundSensor found;                         // of the frames as the run read them
  std::set<int> held_out;                    // frames
};

// Reads poses.json and summary.json of the run's folder. Throws InputError naming the file at
// fault.
RecordedRun ReadRecordedRun(const std::string& folder);

// Throws InputError unless frames have the size of those that the run was calibrated by.
void RequireCameraOfFrames(const RecordedRun& run, const std::string& folder,
                           const PinholeCamera& frames);

// Files that the judge of views (EvaluateViews()) writes into the folder of a run by default:
// tables and at most kMostViewPictures pictures. `rank` is 0 for the worst view.
inline constexpr int kMostViewPictures = 100;
std::string ViewPictureName(int rank);
std::vector<std::string> ViewFileNames();

}  // namespace surfit
