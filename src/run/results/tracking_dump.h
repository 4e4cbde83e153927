#pragma once

#include <string>

#include "surfit/slam/slam.h"

namespace surfit {

// Input and result of one registration, to repeat it in another program.
struct TrackingDump {
  int frame = 0;
  FramePyramid source, target;
  Rigid3d target_from_source_initial;  // m; maps source to target camera coordinates
  IcpOptions icp;
  std::string termination;  // result of the registration in the run, as ToString()
};

// Writes the registration of a lost frame into a folder, which is created if missing.
//   source.ply, target.ply  all pixels of the finest level, row by row; (0, 0, 0): invalid pixel
//   frame.json              cameras, initial pose, options, termination
// Coarser levels are computed from the finest level, so the input of a repeated registration is
// bitwise identical. The ICP options are LostFrame::icp_options. Throws InputError naming the file
// that cannot be written.
void WriteTrackingDump(const LostFrame& lost, const SlamOptions& options,
                       const std::string& folder);

// Reads a folder of WriteTrackingDump(). Throws InputError with the path and the error.
TrackingDump ReadTrackingDump(const std::string& folder);

}  // namespace surfit
