#pragma once

#include <string>
#include <vector>

#include "surfit/core/atomic_file.h"
#include "surfit/frame/frame_source.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Names of all files that a run may write into its output folder.
std::vector<std::string> RunFileNames();

// Poses of a run. Appends each pose to trajectory.txt and trajectory_online.txt, in the convention
// of the sequence. Corrections change trajectory.txt only.
class RunTrajectory {
 public:
  // `mirrored` is SequenceInfo::mirrored. Throws InputError naming the file.
  RunTrajectory(const std::string& folder, bool mirrored);

  // Adds the pose of a frame, and the confirmed pose of the frame before. The confirmed pose is not
  // in trajectory_online.txt.
  void Add(const FrameReport& report);
  // Replaces the poses of all frames. If the counts differ, drops the last poses or frames.
  void Replace(Trajectory corrected);
  // Writes trajectory.txt again if poses were replaced.
  void Finish() const;

  const Trajectory& poses() const { return poses_; }
  // Frame index of each pose, ascending.
  const std::vector<int>& frames() const { return frames_; }

 private:
  void Append(int index, const StampedPose& pose);
  StampedPose InSourceConvention(StampedPose pose) const;

  bool mirrored_;
  bool is_replaced_ = false;
  std::string path_;
  TumTrajectoryWriter file_, online_;
  Trajectory poses_;
  std::vector<int> frames_;
};

// Writes frames.csv, one row per frame.
class FrameTable {
 public:
  // Throws InputError naming the file.
  explicit FrameTable(const std::string& folder);

  void Add(const FrameReport& report, double read_ms, double frame_ms);
  // Adds the row of a frame that could not be read.
  void AddSkipped(const ReadResult& result, double frame_ms);

 private:
  AppendedFile file_;
};

}  // namespace surfit
