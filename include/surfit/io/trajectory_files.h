#pragma once

#include <string>
#include <vector>

#include "surfit/core/atomic_file.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Trajectory files of the TUM RGB-D benchmark, and .gt.freiburg of ICL-NUIM. Each line is a
// camera-to-world pose: `timestamp tx ty tz qx qy qz qw`, in seconds and metres. Lines that begin
// with # are comments.

// Reads a trajectory and sorts it by time. Columns are separated by spaces, tabs or commas.
// Quaternions are normalised; their norm must be 1 within 1 %. Poses with equal timestamps keep
// their order. Numbers must be finite, and coordinates at most 1e9 m. A file without poses gives an
// empty trajectory. Throws InputError that names the file, and the line of an error.
Trajectory ReadTumTrajectory(const std::string& path);

// Reads the first column of a trajectory, or of an image list such as rgb.txt: timestamps in s,
// sorted. Throws InputError that names the file, and the line of an error.
std::vector<double> ReadTumStamps(const std::string& path);

// Writes a trajectory atomically, with single spaces, 6 decimals for timestamps and 9 for poses.
// Throws InputError that names the file if it cannot be written. Throws on numbers that are not
// finite.
void WriteTumTrajectory(const Trajectory& trajectory, const std::string& path);

// Writes such a file pose by pose. Not thread-safe.
class TumTrajectoryWriter {
 public:
  // Creates or replaces the file. Throws InputError that names the file if it cannot be written.
  explicit TumTrajectoryWriter(const std::string& path);
  // Appends one line. A regular file consists of complete lines at any time, even if the disk is
  // full. Throws InputError that names the file if it cannot be written. Throws on numbers that are
  // not finite.
  void Append(const StampedPose& pose);

 private:
  AppendedFile file_;
};

// Writes the poses atomically in the format of the KITTI odometry benchmark, in metres with 9
// decimals. Each line has the upper 3 x 4 of a camera-to-world matrix, row by row. The format has
// no timestamps. Throws InputError that names the file if it cannot be written. Throws on numbers
// that are not finite.
void WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path);

}  // namespace surfit
