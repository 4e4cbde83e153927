#pragma once

#include <string>
#include <vector>

#include "surfit/session/session.h"
#include "surfit/slam/slam.h"

namespace surfit {

// What came of sessions that were made one.
struct MergeSummary {
  std::size_t sessions = 0;
  std::size_t loops_between = 0;   // keyframes of two sessions that show one place, consistently
  std::vector<std::string> apart;  // sessions that nothing joins to the first: they stand beside it
  std::size_t frames = 0, keyframes = 0, surfels = 0;
  std::size_t merged_doubles = 0;  // surfels of one session that became part of another's
};

// Makes one session of several of the same sensor: each keyframe is looked for in the sessions
// before its own, one pose graph is solved, wrong loops left out, the maps follow, and surfaces
// that two have seen become one. The calibration is that of the first that has one. Those that are
// read stay as they are; frames get new indices. Throws InputError as ReadSession() and
// SessionWriter do, and for sessions of different sensors.
MergeSummary MergeSessions(const std::vector<std::string>& folders, const SlamOptions& options,
                           const std::string& output);

// Gives back the room on disk that is of no use any more. Throws InputError naming the folder if it
// holds no session, or another program writes into it.
void CompactSession(const std::string& folder);

}  // namespace surfit
