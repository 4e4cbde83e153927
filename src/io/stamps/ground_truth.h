#pragma once

#include <string>
#include <utility>
#include <vector>

#include "io/files/text.h"
#include "io/stamps/time_words.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Collects poses, and counts poses that are not finite or not rigid, instead of rejecting the
// recording.
class GroundTruthPoses {
 public:
  explicit GroundTruthPoses(std::string source) : source_(std::move(source)) {}

  // Adds a pose, or counts an invalid pose.
  void Add(double stamp_s, const ParsedRigid& parsed);
  // Counts a pose that belongs to no frame.
  void AddWithoutFrame() { ++without_frame_; }

  // Returns the valid poses in ascending order of time. Adds warnings with the counts of omitted
  // poses. Call once, at the end.
  Trajectory Take(std::vector<std::string>* warnings);

 private:
  std::string source_;
  Trajectory poses_;
  int invalid_ = 0, without_frame_ = 0;
  std::string first_error_;
};

// Reads a TUM trajectory as ground truth of a sequence with these timestamps, see
// ParseTruthTimes(). Throws InputError naming the line that is not eight numbers; poses may be nan
// or inf.
Trajectory ReadGroundTruth(const std::string& path, const Times& images,
                           std::vector<std::string>* warnings);

}  // namespace surfit
