#include "session/schema.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <type_traits>

namespace surfit {
namespace {

constexpr std::int64_t kApplicationId = 0x73726674;  // "srft"
constexpr std::int64_t kVersion = 2;

class RowWriter {
 public:
  template <typename... Ts>
  void Pass(const Ts&... values) {
    (Put(values), ...);
  }
  const Row& row() const { return row_; }

 private:
  template <typename T>
  void Put(const T& value) {
    if constexpr (std::is_integral_v<T>) {
      row_.emplace_back(static_cast<std::int64_t>(value));
    } else {
      row_.emplace_back(value);
    }
  }
  void Put(const Rigid3d& pose) {
    for (const double number : pose.translation) Put(number);
    for (const double number : pose.rotation.coeffs()) Put(number);
  }

  Row row_;
};

// PassColumns() lists the columns of a table for RowWriter and RowReader. Keys that are not members
// of the row type are passed separately.
template <typename Io>
void PassColumns(SessionRow& session, Io* io) {
  PinholeCamera& camera = session.sensor.camera;
  io->Pass(camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
           session.sensor.noise.inverse_depth_sigma, session.sensor.readout_s);
  bool is_calibrated = session.calibration.has_value();
  DepthCalibration found = session.calibration.value_or(DepthCalibration());
  io->Pass(is_calibrated, found.camera.fx, found.camera.fy, found.camera.cx, found.camera.cy,
           found.readout_s);
  for (double& number : found.field.coefficients) io->Pass(number);
  found.camera.width = camera.width;
  found.camera.height = camera.height;
  if (is_calibrated) session.calibration = found;
  io->Pass(session.color_latency_s, session.runs, session.frames, session.keyframes, session.views,
           session.calibration_frames, session.edges, session.tiles, session.settled_keyframes,
           session.saves);
}

template <typename Io>
void PassColumns(SessionRun& run, Io* io) {
  io->Pass(run.sequence, run.format, run.first, run.stride, run.shift, run.mirrored, run.ended);
}

template <typename Io>
void PassColumns(PosedFrame& frame, Io* io) {
  io->Pass(frame.index, frame.stamp_s, frame.world_from_camera, frame.keyframe, frame.segment);
}

template <typename Io>
void PassColumns(KeyframeLink& keyframe, Io* io) {
  io->Pass(keyframe.frame, keyframe.parent_frame, keyframe.submap);
}

template <typename Io>
void PassColumns(StoredEdge& kept, Blob& information, Io* io) {
  io->Pass(kept.edge.a, kept.edge.b, kept.edge.a_from_b, information, kept.edge.loop,
           kept.in_graph);
}

template <typename Io>
void PassColumns(TileRow& tile, Io* io) {
  io->Pass(tile.key, tile.save, tile.bytes, tile.crc, tile.surfels);
}

template <typename... Keys, typename Struct>
Row Written(Struct value, Keys... key) {
  RowWriter writer;
  writer.Pass(key...);
  PassColumns(value, &writer);
  return writer.row();
}

template <typename Struct>
Struct Taken(RowReader* row) {
  Struct value;
  PassColumns(value, row);
  return value;
}

}  // namespace

const TableLayout& LayoutOf(const std::string& table) {
  return *std::find_if(std::begin(kTables), std::end(kTables),
                       [&](const TableLayout& layout) { return layout.name == table; });
}

void MakeDatabase(const std::string& path, const Row& session) {
  const std::string partial = path + ".new";
  std::filesystem::remove(partial);
  {
    Database database(partial, Database::Mode::kCreate);
    database.Transact([&] {
      database.Run(Concat("PRAGMA application_id = ", kApplicationId));
      database.Run(Concat("PRAGMA user_version = ", kVersion));
      for (const TableLayout& table : kTables) {
        database.Run(
            Concat("CREATE TABLE ", table.name, " (", table.columns, ", checksum INTEGER)"));
      }
      database.Put("session", {session});
    });
  }
  std::filesystem::rename(partial, path);
}

void ForEachIntact(Database* database, const char* table,
                   const std::function<void(RowReader*)>& take) {
  database->ForEach(table, LayoutOf(table).count, [&](const Row& row, bool is_intact) {
    RowReader reader(row, Concat(database->path(), ": a row of ", table));
    if (!is_intact) reader.Fail("is damaged: its checksum is wrong");
    take(&reader);
  });
}

void RequireSchema(Database* database) {
  ThrowIf(database->Number("PRAGMA application_id") != kApplicationId, database->path(),
          " is not a session: it has another application_id");
  const std::int64_t version = database->Number("PRAGMA user_version");
  ThrowIf(version != kVersion, database->path(), " is a session of version ", version, ", must be ",
          kVersion, " for this program");
}

Row RowOf(const SessionRow& session) { return Written(session, 1); }

SessionRow TakeSession(RowReader* row) {
  if (row->TakeInt() != 1) row->Fail("must have the key 1");
  const SessionRow session = Taken<SessionRow>(row);
  session.sensor.camera.Validate(row->from());
  if (session.calibration) session.calibration->camera.Validate(row->from());
  return session;
}

Row RowOf(std::int64_t key, const SessionRun& run) { return Written(run, key); }

SessionRun TakeRun(RowReader* row) {
  row->TakeInt();
  return Taken<SessionRun>(row);
}

Row RowOf(const PosedFrame& frame) { return Written(frame); }

PosedFrame TakeFrame(RowReader* row) { return Taken<PosedFrame>(row); }

Row RowOf(std::int64_t key, const KeyframeLink& keyframe) { return Written(keyframe, key); }

KeyframeLink TakeKeyframe(RowReader* row) {
  row->TakeInt();
  return Taken<KeyframeLink>(row);
}

Row RowOf(std::int64_t key, const PlaceView& view) {
  Packer packer;
  PutView(view, &packer);
  PutField(view.field, &packer);
  return {key, Blob{packer.bytes()}};
}

PlaceView TakeStoredView(RowReader* row) {
  row->TakeInt();
  Unpacker unpacker(row->Take<Blob>().bytes, row->from());
  PlaceView view = TakeView(PlacesPart::kAll, &unpacker);
  if (!unpacker.IsAtEnd()) view.field = TakeField(&unpacker);
  unpacker.End();
  return view;
}

Row RowOf(std::int64_t key, const RgbdFrame& calibration_frame) {
  Packer packer;
  packer.Put(calibration_frame.index);
  packer.Put(calibration_frame.stamp_s);
  packer.Put(calibration_frame.color_stamp_s);
  packer.PutImage(calibration_frame.depth_m);
  packer.PutImage(calibration_frame.color);
  return {key, Blob{packer.bytes()}};
}

RgbdFrame TakeCalibrationFrame(RowReader* row) {
  row->TakeInt();
  Unpacker unpacker(row->Take<Blob>().bytes, row->from());
  RgbdFrame frame;
  frame.index = unpacker.Take<int>();
  frame.stamp_s = unpacker.Take<double>();
  frame.color_stamp_s = unpacker.Take<double>();
  frame.depth_m = unpacker.TakeImage<float>();
  frame.color = unpacker.TakeImage<Rgb8>();
  unpacker.End();
  for (const float z : frame.depth_m) {
    if (!(z >= 0) || !std::isfinite(z)) row->Fail("has an invalid depth");
  }
  if (!frame.color.empty() && frame.color.size() != frame.depth_m.size()) {
    row->Fail("has a colour image of another size than the depth image");
  }
  return frame;
}

Row RowOf(std::int64_t key, const StoredEdge& kept) {
  Packer packer;
  for (const double number : kept.edge.information.reshaped()) packer.Put(number);
  Blob information{packer.bytes()};
  StoredEdge edge = kept;
  RowWriter writer;
  writer.Pass(key);
  PassColumns(edge, information, &writer);
  return writer.row();
}

StoredEdge TakeEdge(RowReader* row) {
  StoredEdge kept;
  Blob information;
  row->TakeInt();
  PassColumns(kept, information, row);
  Unpacker unpacker(information.bytes, row->from());
  for (double& number : kept.edge.information.reshaped()) number = unpacker.Take<double>();
  unpacker.End();
  if (!IsInformation(kept.edge.information)) row->Fail("has an invalid information matrix");
  return kept;
}

Row RowOf(const TileRow& tile) { return Written(tile); }

TileRow TakeTile(RowReader* row) { return Taken<TileRow>(row); }

void RowReader::TakeInto(double* value) {
  *value = Take<double>();
  if (!std::isfinite(*value)) Fail(Concat("has no finite number in column ", at_));
}

int RowReader::TakeInt() {
  const std::int64_t number = Take<std::int64_t>();
  using Limits = std::numeric_limits<int>;
  if (number < Limits::min() || number > Limits::max()) {
    Fail(Concat("has ", number, " in column ", at_, ", which is too large"));
  }
  return static_cast<int>(number);
}

void RowReader::TakeInto(Rigid3d* value) {
  for (double& number : value->translation) TakeInto(&number);
  for (double& number : value->rotation.coeffs()) TakeInto(&number);
  if (!(std::abs(value->rotation.norm() - 1) < 1e-6)) Fail("has an invalid rotation");
}

}  // namespace surfit
