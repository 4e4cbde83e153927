#pragma once

#include <string>
#include <vector>

#include "surfit/core/atomic_file.h"
#include "surfit/frame/frame_source.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/slam/slam.h"

namespace surfit {

// All that a run may write into its output folder.
std::vector<std::string> RunFileNames();

// Owns the poses that a run writes: trajectory.txt, and trajectory_online.txt with each pose as it
// was at its time. Both files grow with every frame. They are in the convention of the sequence.
class RunTrajectory {
 public:
  // Throws InputError naming the file.
  RunTrajectory(const std::string& folder, bool mirrored);

  // Adds the pose of a frame, and of the frame before if this frame has confirmed it.
  void Add(const FrameReport& report);
  // Replaces the poses of all frames. Fewer poses drop the last frames.
  void Replace(Trajectory corrected);
  // Writes trajectory.txt again if poses were replaced.
  void Finish() const;

  const Trajectory& poses() const { return poses_; }
  // Index of the frame of each pose, ascending.
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

// frames.csv: one row per frame.
class FrameTable {
 public:
  // Throws InputError naming the file.
  explicit FrameTable(const std::string& folder);

  void Add(const FrameReport& report, double decode_ms, double frame_ms);
  // Adds a frame that could not be read.
  void AddSkipped(const ReadResult& result, double frame_ms);

 private:
  AppendedFile file_;
};

}  // namespace surfit
