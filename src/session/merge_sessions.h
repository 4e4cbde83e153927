#pragma once

#include <string>
#include <vector>

#include "surfit/session/session.h"
#include "surfit/slam/slam.h"

namespace surfit {

struct MergeSummary {
  std::size_t sessions = 0;
  std::size_t loops_between = 0;  // verified loop closures between sessions, without outliers
  std::vector<std::string>
      apart;  // folders of sessions that are not connected to the first session
  std::size_t frames = 0, keyframes = 0, surfels = 0;
  std::size_t merged_duplicates = 0;  // merged duplicate surfels
};

// Merges sessions of the same sensor into a new session. Loops are found between each keyframe and
// all earlier sessions. The joint pose graph is optimised with outlier rejection, and duplicate
// surfels are merged. The first calibration of the sessions is used. The input sessions do not
// change. Sessions without a loop closure become disconnected submaps. Throws InputError like
// ReadSession() and SessionWriter, and for different sensors. `folders` must not be empty, and each
// session needs a frame. Enables loops in the options. `output` must not have a session.
MergeSummary MergeSessions(const std::vector<std::string>& folders, const SlamOptions& options,
                           const std::string& output);

// Removes unused tile files and unused space in the database. Throws InputError with the path if
// the session is missing or damaged, or if another program writes to it.
void CompactSession(const std::string& folder);

}  // namespace surfit
