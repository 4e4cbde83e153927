#pragma once

#include <string>

#include "surfit/slam/slam.h"

namespace surfit {

// A registration as tracking did it, to be done again elsewhere.
struct TrackingDump {
  int frame = 0;
  FramePyramid source, target;
  Rigid3d target_from_source_initial;
  IcpOptions icp;
  std::string termination;  // of the registration
};

// Writes a lost frame into a folder, made if missing: source.ply and target.ply, the finest levels
// as clouds of all pixels row by row, (0, 0, 0) where one is missing, and frame.json with cameras,
// initial pose, options and outcome. Coarser levels follow from these, so that the registration can
// be repeated bit for bit. Throws InputError naming the file that cannot be written.
void WriteTrackingDump(const LostFrame& lost, const SlamOptions& options,
                       const std::string& folder);

// Throws InputError naming the file and what is wrong with it.
TrackingDump ReadTrackingDump(const std::string& folder);

}  // namespace surfit
