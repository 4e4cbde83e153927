#pragma once

#include <string>
#include <vector>

#include "surfit/loop_closure/keyframe.h"
#include "surfit/optimization/pose_graph.h"
#include "surfit/poses/pose_store.h"

namespace surfit {

// Poses, keyframes and pose graph of a run, for merging runs. Poses are camera-to-world in the
// world frame of the run, m.
struct RunPlaces {
  std::vector<PosedFrame> frames;    // all frames with a pose, by ascending index
  std::vector<Keyframe> keyframes;   // with views; poses are equal to those in `frames`
  std::vector<PoseGraphEdge> edges;  // odometry and loop closures; a and b: indices of `keyframes`
};

// Writes a binary file atomically: little-endian values, images compressed with zlib. Throws
// InputError with the path if writing fails.
void WritePlaces(const RunPlaces& places, const std::string& path);

enum class PlacesPart { kAll, kFeatures };

// Throws InputError with the path if the file cannot be read or is invalid. A damaged file cannot
// exhaust the memory. The limit of this function is 4 GiB. With kFeatures, views have no images.
// Timestamps and features are not checked.
RunPlaces ReadPlaces(const std::string& path, PlacesPart part = PlacesPart::kAll);

}  // namespace surfit
