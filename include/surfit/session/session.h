#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "surfit/geometry/sensor.h"
#include "surfit/loop_closure/loop_closure.h"
#include "surfit/slam/backend.h"

namespace surfit {

// A session is a folder with the state of SLAM, of one or more runs:
//   session.db  SQLite database in WAL mode: runs, frame poses, keyframes with their views,
//               the pose graph, the calibration, and the list of map tiles
//   tiles/      the map, one file per 2 m cube with surfels: X_Y_Z.N.tile, written by save N
//               and never changed
// A save writes the changed tiles, then commits all other changes in one transaction. Tiles without
// reference are deleted later. So the folder has a complete last save, even after a crash.
// Checksums protect all rows and tiles.
//
// Frame indices of a session increase over all its runs.

// Recording in a session.
struct SessionRun {
  std::string sequence;  // absolute path of the sequence
  std::string format;    // SequenceInfo::format
  int first = 0, stride = 1;
  // Session index of a frame minus its index in the recording.
  int shift = 0;
  bool mirrored = false;  // SequenceInfo::mirrored
  bool ended = false;     // saved completely; false during the run and after a crash
};

// Row counts and file size of a session.
struct SessionCounts {
  std::int64_t runs = 0, frames = 0, keyframes = 0, views = 0, edges = 0, loops = 0, tiles = 0;
  std::int64_t surfels = 0;
  std::int64_t submaps = 0;
  std::int64_t saves = 0;
  std::int64_t bytes = 0;  // size of all files
};

// Content of a session.
struct Session {
  std::vector<SessionRun> runs;
  DepthSensor sensor;  // input sensor; its prior is not saved
  SlamState state;
  std::int64_t saves = 0;
};

// Read a session, its runs, or its counts. They open the session read-only. Throw
// InputError with the file if the folder is no session of this version, or if another program has
// locked it. For damaged data, the message names table and row.
Session ReadSession(const std::string& folder);
std::vector<SessionRun> ReadSessionRuns(const std::string& folder);
SessionCounts CountSession(const std::string& folder);

// Gap between the last frame index of a session and the first index of a new recording. Because of
// the gap, no surfels of both merge before a loop closure.
int SessionGap(const LoopOptions& options);

// True if the folder has a session, of any version and state.
bool HasSession(const std::string& folder);

// Throws InputError with the folder if the sensor of a session (`kept`) and `given` differ in
// camera, noise or readout.
void RequireSameSensor(const std::string& folder, const DepthSensor& kept,
                       const DepthSensor& given);

// Checks the database, the checksums of rows and tiles, and the consistency of all rows. Returns
// one sentence per error; empty: intact. Throws InputError if there is no readable database of this
// version, or if another program has locked it.
std::vector<std::string> CheckSession(const std::string& folder);

}  // namespace surfit
