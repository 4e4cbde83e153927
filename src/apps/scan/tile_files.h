#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "apps/scan/scan_plan.h"
#include "finishing/posed_sequence.h"
#include "surfit/slam/backend.h"

namespace surfit {

// Cube of the map with the frames that observe it.
struct ScanTile {
  std::string name;
  Eigen::AlignedBox3f box;                      // half-open, in the frame of the map, m
  std::vector<std::vector<FrameRange>> frames;  // per recording: ascending and disjoint
};

// Offsets that make the frame indices of all recordings unique, one per recording. Add the offset
// to the index of a frame of this recording.
std::vector<int> FirstFrames(const ScanPlan& plan);

// File name NAME_R.ENDING of recording R.
std::string RecordingFile(const std::string& name, std::size_t recording,
                          const std::string& ending);

// The following functions throw InputError with the file name.
void WriteTiles(const std::vector<ScanTile>& tiles, const std::string& path);
std::vector<ScanTile> ReadTiles(const std::string& path);

// Text file with one line per frame: index, timestamp, pose. Lossless. ReadFramePoses() requires
// ascending indices, and does not check the poses. Keyframes and segments are not stored.
void WriteFramePoses(const std::vector<PosedFrame>& frames, const std::string& path);
std::vector<PosedFrame> ReadFramePoses(const std::string& path);

}  // namespace surfit
