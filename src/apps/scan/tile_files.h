#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "apps/scan/scan_plan.h"
#include "finishing/known_sequence.h"
#include "surfit/slam/backend.h"

namespace surfit {

// A cube of the world, and the frames that see something in it.
struct ScanTile {
  std::string name;
  Eigen::AlignedBox3f box;
  std::vector<std::vector<FrameRange>> frames;  // of each recording
};

// How many frames come before each recording, if the frames of all are counted on: by their ranges
// in the plan.
std::vector<int> FirstFrames(const ScanPlan& plan);

// Where the graph's results of a recording are, in its folder: NAME_R.ENDING.
std::string RecordingFile(const std::string& name, std::size_t recording,
                          const std::string& ending);

// All throw InputError naming the file.
void WriteTiles(const std::vector<ScanTile>& tiles, const std::string& path);
std::vector<ScanTile> ReadTiles(const std::string& path);

// Index, stamp and pose of each frame, a line each, without loss.
void WriteFramePoses(const std::vector<PosedFrame>& frames, const std::string& path);
std::vector<PosedFrame> ReadFramePoses(const std::string& path);

}  // namespace surfit
