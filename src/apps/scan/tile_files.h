#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "apps/scan/scan_plan.h"
#include "finishing/posed_sequence.h"
#include "surfit/slam/backend.h"

namespace surfit {

// Cube of the map, and the frames that observe it.
struct ScanTile {
  std::string name;
  Eigen::AlignedBox3f box;
  std::vector<std::vector<FrameRange>> frames;  // per recording
};

// Offset of the frame indices of each recording, for unique indices over all recordings.
std::vector<int> FirstFrames(const ScanPlan& plan);

// File NAME_R.ENDING of recording R in the graph folder.
std::string RecordingFile(const std::string& name, std::size_t recording,
                          const std::string& ending);

// All functions throw InputError with the name of the file.
void WriteTiles(const std::vector<ScanTile>& tiles, const std::string& path);
std::vector<ScanTile> ReadTiles(const std::string& path);

// One line per frame: index, timestamp and pose, without loss of precision.
void WriteFramePoses(const std::vector<PosedFrame>& frames, const std::string& path);
std::vector<PosedFrame> ReadFramePoses(const std::string& path);

}  // namespace surfit
