#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "surfit/geometry/sensor.h"
#include "surfit/loop_closure/loop_closure.h"
#include "surfit/slam/backend.h"

namespace surfit {

// A session is a folder that keeps what SLAM knows of a place, over one run or many:
//   session.db  an SQLite database in WAL mode: runs, poses of frames, keyframes with their views,
//               the pose graph, the calibration, and which tiles make up the map
//   tiles/      the map, a file for each cube of 2 m that has surfels: X_Y_Z.N.tile, written by the
//               N-th save and never changed
// A save is one transaction. It commits what has changed since the last, after the tiles that it
// names have been written; tiles that no save names any more are removed later. So whatever ends a
// process, the folder holds the last save as a whole. A row ends in a checksum of its values, and
// the row of a tile has that of the file; the row of the session has the numbers of all others.
//
// Frames have indices of the session: a run's go on from those of the run before.

// A recording that was added to a session.
struct SessionRun {
  std::string sequence;  // its path from the root on
  std::string format;    // SequenceInfo::format
  int first = 0, stride = 1;
  // What is added to an index of the recording to be one of the session.
  int shift = 0;
  bool mirrored = false;  // SequenceInfo::mirrored
  bool ended = false;     // all that it did is in the session; false while it runs, or was killed
};

// How much a session holds.
struct SessionCounts {
  std::int64_t runs = 0, frames = 0, keyframes = 0, views = 0, edges = 0, loops = 0, tiles = 0;
  std::int64_t surfels = 0;
  std::int64_t submaps = 0;
  std::int64_t saves = 0;
  std::int64_t bytes = 0;  // of all files
};

// What a session holds.
struct Session {
  std::vector<SessionRun> runs;
  DepthSensor sensor;  // as given; its prior is not kept
  SlamState state;
  std::int64_t saves = 0;
};

// Throw InputError naming the file, and the table and row, if the folder is no session, is one of
// another version, is locked by another program, or something of it is damaged or missing.
Session ReadSession(const std::string& folder);
std::vector<SessionRun> ReadSessionRuns(const std::string& folder);
SessionCounts CountSession(const std::string& folder);

// From the index of the last frame of a session to that of the first of what is added, if that does
// not follow it: so far apart, surfaces that both see are told apart until they are joined.
int SessionGap(const LoopOptions& options);

// Whether the folder holds a session, of whatever version and state.
bool HasSession(const std::string& folder);

// Throws InputError naming the folder if a session of one sensor is to be used with another.
void RequireSameSensor(const std::string& folder, const DepthSensor& kept,
                       const DepthSensor& given);

// All that is damaged or missing, a sentence each: by SQLite's own check of the database, by the
// checksums of all rows and tiles, and by what rows say of each other. Throws InputError where
// there is no session to check, or another program has locked it.
std::vector<std::string> CheckSession(const std::string& folder);

}  // namespace surfit
