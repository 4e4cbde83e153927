#pragma once

#include <string>
#include <vector>

#include "finishing/posed_sequence.h"
#include "surfit/core/atomic_file.h"
#include "surfit/frame/frame_source.h"
#include "surfit/io/trajectory_files.h"
#include "surfit/slam/slam.h"

namespace surfit {

// Names of all files that a run or EvaluateViews() may write into the output folder.
std::vector<std::string> RunFileNames();

// Writes the poses of a run in TUM format to trajectory.txt and trajectory_online.txt. Corrections
// change trajectory.txt only. Poses of mirrored frames are mirrored back. Constructor, Add() and
// Finish() throw InputError with the path if writing fails. Files are complete after each frame,
// except for corrections.
class RunTrajectory {
 public:
  // Creates or replaces both files. `mirrored`: SequenceInfo::mirrored.
  RunTrajectory(const std::string& folder, bool mirrored);

  // Adds the pose of a frame; a lost frame adds nothing. FrameReport::confirmed is added first, and
  // only to trajectory.txt.
  void Add(const FrameReport& report);
  // Replaces the poses of all frames(), in this order. After a failed frame, the sizes differ:
  // drops surplus poses or frames at the end.
  void Replace(Trajectory corrected);
  // Adds poses of lost frames, which were found after the run.
  void Insert(const std::vector<PoseBetween>& found);
  // Writes trajectory.txt again if Replace() or Insert() was called.
  void Finish() const;

  // Poses in the convention of the run: mirrored if `mirrored` is true.
  const Trajectory& poses() const { return poses_; }
  // Frame index of each pose.
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

// Writes frames.csv, one row per frame. All functions throw InputError with the path if writing
// fails. Times are in ms. `keyframe` and cov_00 to cov_55 are FrameReport::keyframe and the upper
// triangle of FrameReport::covariance, in the order rotation (rad), translation (m). They are empty
// if they are unknown.
class FrameTable {
 public:
  // Creates or replaces frames.csv in the folder.
  explicit FrameTable(const std::string& folder);

  // `frame_ms`: time between the completions of the previous frame and this frame.
  void Add(const FrameReport& report, double read_ms, double frame_ms);
  // Adds an unreadable frame.
  void AddSkipped(const ReadResult& result, double frame_ms);
  // Replaces the state "lost" of these frames by "between", and writes the file again. `frames`:
  // indices of lost frames, ascending. Does nothing on a device or pipe.
  void MarkFound(const std::vector<int>& frames);

 private:
  std::string path_;
  AppendedFile file_;
};

}  // namespace surfit
