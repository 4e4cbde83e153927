#pragma once

#include <string>
#include <vector>

#include "surfit/geometry/trajectory.h"

namespace surfit {

// The files of one frame.
struct FrameFiles {
  double stamp_s = 0;
  std::string depth_path;
  std::string color_path;  // empty where the sequence has no colour
};

// What a folder of images holds. Whether the images can be read shows when they are.
struct SequenceFiles {
  std::vector<FrameFiles> frames;
  Trajectory ground_truth;  // as the files have it
};

// Each throws InputError naming the file, and the line, that is missing or malformed.

// associations.txt, or else rgb.txt and depth.txt paired by time (depth.txt alone: no colour).
// Ground truth from groundtruth.txt or *.gt.freiburg.
SequenceFiles ListTumSequence(const std::string& folder);

// The same, or without such lists rgb/N.png and depth/N.png. Stamps are the frame numbers N, for
// so they stand in *.gt.freiburg.
SequenceFiles ListIclNuimSequence(const std::string& folder);

// frame-N.{color.png|color.jpg, depth.png, pose.txt}; stamps are N / frames_per_second.
SequenceFiles ListSevenScenesSequence(const std::string& folder, double frames_per_second);

// Numbered images in depth/ and color/, rgb/ or image/ (or no colour), poses in trajectory.log;
// stamps are position / frames_per_second, and the log's first number is that position.
SequenceFiles ListRedwoodSequence(const std::string& folder, double frames_per_second);

// results/frameN.jpg and results/depthN.png with poses in traj.txt, as rendered for NICE-SLAM;
// stamps are N / frames_per_second, a pose's N is its line.
SequenceFiles ListReplicaSequence(const std::string& folder, double frames_per_second);

}  // namespace surfit
