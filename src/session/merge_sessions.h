#pragma once

#include <string>
#include <vector>

#include "surfit/session/session.h"
#include "surfit/slam/slam.h"

namespace surfit {

struct MergeSummary {
  std::size_t sessions = 0;
  std::size_t loops_between = 0;   // accepted loop closures between sessions
  std::vector<std::string> apart;  // sessions that are not connected to the first session
  std::size_t frames = 0, keyframes = 0, surfels = 0;
  std::size_t merged_duplicates = 0;  // surfels that were merged as duplicates
};

// Merges sessions of the same sensor into a new session. Each keyframe is compared with the
// keyframes of the sessions before it, and a joint pose graph is optimised with outlier rejection.
// Then the maps are corrected and duplicate surfels are merged. The calibration is the one of the
// first session with a calibration. Frames get new indices. The input sessions are not changed;
// sessions without a loop closure stay disconnected submaps. Throws InputError in the cases of
// ReadSession() and SessionWriter, and for different sensors.
MergeSummary MergeSessions(const std::vector<std::string>& folders, const SlamOptions& options,
                           const std::string& output);

// Removes unused tile files and unused space in the database. Throws InputError with the path if
// the session is missing or damaged, or another program writes to it.
void CompactSession(const std::string& folder);

}  // namespace surfit
