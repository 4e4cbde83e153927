#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "io/files/packed.h"
#include "session/database.h"
#include "surfit/session/session.h"

namespace surfit {

// Files in the folder of a session: the database, and the folder of the tiles.
inline std::string DatabaseOf(const std::string& folder) { return folder + "/session.db"; }
inline std::string TilesOf(const std::string& folder) { return folder + "/tiles"; }

// Columns of a table, without the checksum.
struct TableLayout {
  const char* name;
  const char* columns;
  std::size_t count;  // number of columns
};

inline constexpr TableLayout kTables[] = {
    {"session",
     "id INTEGER PRIMARY KEY, width INTEGER, height INTEGER, fx REAL, fy REAL, cx REAL, cy REAL, "
     "inverse_depth_sigma REAL, readout_s REAL, calibrated INTEGER, calibrated_fx REAL, "
     "calibrated_fy REAL, calibrated_cx REAL, calibrated_cy REAL, calibrated_readout_s REAL, "
     "field0 REAL, field1 REAL, field2 REAL, field3 REAL, field4 REAL, field5 REAL, "
     "color_latency_s REAL, runs INTEGER, frames INTEGER, keyframes INTEGER, views INTEGER, "
     "calibration INTEGER, edges INTEGER, tiles INTEGER, settled_keyframes INTEGER, saves INTEGER",
     31},
    {"runs",
     "id INTEGER PRIMARY KEY, sequence TEXT, format TEXT, first INTEGER, stride INTEGER, shift "
     "INTEGER, mirrored INTEGER, ended INTEGER",
     8},
    {"frames",
     "id INTEGER PRIMARY KEY, stamp_s REAL, tx REAL, ty REAL, tz REAL, qx REAL, qy REAL, qz REAL, "
     "qw REAL, keyframe INTEGER, stretch INTEGER",
     11},
    {"keyframes", "id INTEGER PRIMARY KEY, frame INTEGER, parent_frame INTEGER, submap INTEGER", 4},
    {"views", "id INTEGER PRIMARY KEY, view BLOB", 2},
    {"calibration", "id INTEGER PRIMARY KEY, frame BLOB", 2},
    {"edges",
     "id INTEGER PRIMARY KEY, a INTEGER, b INTEGER, tx REAL, ty REAL, tz REAL, qx REAL, qy REAL, "
     "qz REAL, qw REAL, information BLOB, loop INTEGER, in_graph INTEGER",
     13},
    {"tiles", "id INTEGER PRIMARY KEY, save INTEGER, bytes INTEGER, crc INTEGER, surfels INTEGER",
     5},
};

// Layout of one of kTables. Other names are not checked.
const TableLayout& LayoutOf(const std::string& table);

// Row of table `session`, its only row, with the row counts of all other tables.
struct SessionRow {
  DepthSensor sensor;
  std::optional<DepthCalibration> calibration;
  double color_latency_s = 0;  // colour latency in addition to the input latency
  std::int64_t runs = 0, frames = 0, keyframes = 0, views = 0, calibration_frames = 0, edges = 0,
               tiles = 0;
  std::int64_t settled_keyframes = 0;  // keyframes whose loop search is complete
  std::int64_t saves = 0;              // number of saves so far
};

// `in_graph`: inlier loop closure; false for odometry.
struct StoredEdge {
  PoseGraphEdge edge;
  bool in_graph = false;
};

// Tile of the map, in the file TileName(key, save).
struct TileRow {
  std::int64_t key = 0;    // TileKey()
  std::int64_t save = 0;   // number of the save that wrote the file
  std::int64_t bytes = 0;  // file size
  std::int64_t crc = 0;    // Crc() of the file
  std::int64_t surfels = 0;
};

// Creates a database with an empty session, atomically. Replaces an existing database.
void MakeDatabase(const std::string& path, const Row& session);
// Throws InputError for other databases and versions. Call before reading.
void RequireSchema(Database* database);

// Rows for Database::Put(). The key of a frame is its index, and that of a view or calibration
// frame is its keyframe. Other rows are numbered from 0.
Row RowOf(const SessionRow& session);
Row RowOf(std::int64_t key, const SessionRun& run);
Row RowOf(const PosedFrame& frame);
Row RowOf(std::int64_t key, const KeyframeLink& keyframe);
Row RowOf(std::int64_t key, const PlaceView& view);
Row RowOf(std::int64_t key, const RgbdFrame& calibration_frame);
Row RowOf(std::int64_t key, const StoredEdge& edge);
Row RowOf(const TileRow& tile);

// Reads the values of a row in order. Throws InputError with `from` for a wrong type or value.
// `row` must outlive the reader.
class RowReader {
 public:
  RowReader(const Row& row, std::string from) : row_(row), from_(std::move(from)) {}

  // Next value, which must have the type T. The reference is valid as long as the row.
  template <typename T>
  const T& Take() {
    const T* const value = at_ < row_.size() ? std::get_if<T>(&row_[at_]) : nullptr;
    if (value == nullptr) Fail(Concat("has another type in column ", at_ + 1));
    ++at_;
    return *value;
  }
  // Next value, which must fit into int.
  int TakeInt();
  // Reads several values. Numbers must be finite, and rotations of unit length.
  template <typename... Ts>
  void Pass(Ts&... values) {
    (TakeInto(&values), ...);
  }
  const std::string& from() const { return from_; }
  [[noreturn]] void Fail(const std::string& why) const { throw InputError(from_, " ", why); }

 private:
  template <typename T>
  void TakeInto(T* value) {
    *value = Take<T>();
  }
  void TakeInto(int* value) { *value = TakeInt(); }
  void TakeInto(std::size_t* value) { *value = static_cast<std::size_t>(TakeInt()); }
  void TakeInto(bool* value) { *value = Take<std::int64_t>() != 0; }
  void TakeInto(double* value);
  void TakeInto(Rigid3d* value);

  const Row& row_;
  std::string from_;
  std::size_t at_ = 0;
};

// Calls `take` for each row of a table. Throws InputError at the first damaged row. Rows are in the
// order of their keys.
void ForEachIntact(Database* database, const char* table,
                   const std::function<void(RowReader*)>& take);

// Read the rows of RowOf(). Keys are skipped, except those of frames and tiles. Throw InputError
// for invalid values.
SessionRow TakeSession(RowReader* row);
SessionRun TakeRun(RowReader* row);
PosedFrame TakeFrame(RowReader* row);
KeyframeLink TakeKeyframe(RowReader* row);
PlaceView TakeStoredView(RowReader* row);
RgbdFrame TakeCalibrationFrame(RowReader* row);
StoredEdge TakeEdge(RowReader* row);
TileRow TakeTile(RowReader* row);

}  // namespace surfit
