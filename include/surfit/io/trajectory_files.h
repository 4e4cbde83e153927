#pragma once

#include <string>
#include <vector>

#include "surfit/core/atomic_file.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Trajectory files of the TUM RGB-D benchmark (and ICL-NUIM's .gt.freiburg): one pose a line,
// `timestamp tx ty tz qx qy qz qw`, seconds and metres, camera-to-world; # begins a comment.

// Reads a trajectory and orders it by time. Columns are separated by spaces, tabs or commas;
// quaternions are normalised. A file without poses gives an empty trajectory.
// Throws InputError naming the file, and the line where one is at fault.
Trajectory ReadTumTrajectory(const std::string& path);

// The first column of a trajectory, or of a list of images such as rgb.txt: stamps in s, ascending.
// Throws InputError naming the file, and the line where one is at fault.
std::vector<double> ReadTumStamps(const std::string& path);

// Writes a trajectory as a whole or not at all: single spaces, stamps with 6 and poses with 9
// decimals. Throws InputError naming the file if it cannot be written.
void WriteTumTrajectory(const Trajectory& trajectory, const std::string& path);

// Writes such a file pose by pose.
class TumTrajectoryWriter {
 public:
  // Begins a new file. Throws InputError naming the file if it cannot be written.
  explicit TumTrajectoryWriter(const std::string& path);
  // Adds one line, so that the file is complete whatever happens later, also where the disk is
  // full. Throws InputError naming the file if it cannot be written.
  void Append(const StampedPose& pose);

 private:
  AppendedFile file_;
};

// Writes the poses as KITTI's odometry benchmark has them, atomically: a line a pose, the upper 3 x
// 4 of the camera-to-world matrix row by row, metres, 9 decimals. The format has no stamps. Throws
// InputError naming the file if it cannot be written.
void WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path);

}  // namespace surfit
