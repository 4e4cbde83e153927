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

// The files that grow with every frame: trajectory.txt, trajectory_online.txt and frames.csv.
class RunFiles {
 public:
  // Poses are written back in the source's convention. Throws InputError naming the file.
  RunFiles(const std::string& folder, bool mirrored);

  // A frame that was processed; a lost one has no trajectory line.
  void Write(const FrameReport& report, double decode_ms, double frame_ms);
  // A frame that could not be read.
  void WriteSkipped(const ReadResult& result, double frame_ms);

  // Writes trajectory.txt anew, as the last that is done.
  void Rewrite(Trajectory corrected) const;

 private:
  bool mirrored_;
  std::string trajectory_path_;
  TumTrajectoryWriter trajectory_, online_;
  AppendedFile csv_;
};

}  // namespace surfit
