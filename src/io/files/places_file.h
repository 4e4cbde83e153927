#pragma once

#include <string>
#include <vector>

#include "surfit/loop_closure/keyframe.h"
#include "surfit/optimization/pose_graph.h"
#include "surfit/poses/pose_store.h"

namespace surfit {

// What a run knows of where it was, to be joined to other runs.
struct RunPlaces {
  std::vector<PosedFrame> frames;    // all with a pose, by ascending index
  std::vector<Keyframe> keyframes;   // with their views; their poses are the frames'
  std::vector<PoseGraphEdge> edges;  // between keyframes, by their positions: odometry and loops
};

// Writes a file of binary little endian values, compressed by zlib, atomically. Throws InputError
// naming the file if it cannot be written.
void WritePlaces(const RunPlaces& places, const std::string& path);

// Which parts of a file are wanted.
enum class PlacesPart { kAll, kFeatures };  // of the views: images and features, or these alone

// Throws InputError naming the file if it cannot be read, or is no such file. What it takes in
// memory is bounded by the file's size.
RunPlaces ReadPlaces(const std::string& path, PlacesPart part = PlacesPart::kAll);

}  // namespace surfit
