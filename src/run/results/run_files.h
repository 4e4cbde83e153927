#pragma once

#include <string>
#include <vector>

#include "surfit/core/atomic_file.h"
#include "surfit/frame/frame_source.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Names of all files that a run or EvaluateViews() may write into the output folder of the run,
// relative to this folder.
std::vector<std::string> RunFileNames();

// Poses of a run. Appends each pose to trajectory.txt and trajectory_online.txt, in TUM format.
// Corrections change trajectory.txt only. Poses of mirrored frames are mirrored back in the files,
// see SequenceInfo::mirrored. The constructor, Add() and Finish() throw InputError that names a
// file if it cannot be written.
class RunTrajectory {
 public:
  // Creates or replaces both files. `mirrored` is SequenceInfo::mirrored.
  RunTrajectory(const std::string& folder, bool mirrored);

  // Adds the pose of a frame. A lost frame has no pose and adds nothing. FrameReport::confirmed,
  // the pose of the frame before, is added first, but not to trajectory_online.txt.
  void Add(const FrameReport& report);
  // Replaces the poses of all frames(), in this order. If `corrected` has a different size, for
  // example after a failed frame, drops the surplus poses or frames at the end.
  void Replace(Trajectory corrected);
  // Writes trajectory.txt again if poses were replaced.
  void Finish() const;

  // Poses of the frames as the run processed them: mirrored if `mirrored` is true.
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

// Writes frames.csv, one row per frame. All functions throw InputError that names the file if it
// cannot be written.
class FrameTable {
 public:
  // Creates or replaces the file.
  explicit FrameTable(const std::string& folder);

  // `frame_ms` is the time from the completion of the previous frame to that of this frame.
  void Add(const FrameReport& report, double read_ms, double frame_ms);
  // Adds the row of a frame that could not be read.
  void AddSkipped(const ReadResult& result, double frame_ms);

 private:
  AppendedFile file_;
};

}  // namespace surfit
