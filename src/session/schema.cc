#include "session/schema.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>

#include "io/files/packed_view.h"

namespace surfit {
namespace {

constexpr std::int64_t kApplicationId = 0x73726674;  // "srft"
constexpr std::int64_t kVersion = 2;

void PutPose(const Rigid3d& pose, Row* row) {
  for (const double number : pose.translation) row->emplace_back(number);
  for (const double number : pose.rotation.coeffs()) row->emplace_back(number);
}

std::int64_t AsInteger(bool flag) { return flag ? 1 : 0; }

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
          " is no session: its application_id is another one");
  const std::int64_t version = database->Number("PRAGMA user_version");
  ThrowIf(version != kVersion, database->path(), " is a session of version ", version, ", must be ",
          kVersion, " for this program");
}

Row RowOf(const SessionRow& session) {
  const PinholeCamera& camera = session.sensor.camera;
  Row row = {std::int64_t{1}, std::int64_t{camera.width}, std::int64_t{camera.height}};
  for (const double number : {camera.fx, camera.fy, camera.cx, camera.cy,
                              session.sensor.noise.inverse_depth_sigma, session.sensor.readout_s}) {
    row.emplace_back(number);
  }
  row.emplace_back(AsInteger(session.calibration.has_value()));
  const DepthCalibration found = session.calibration.value_or(DepthCalibration());
  for (const double number :
       {found.camera.fx, found.camera.fy, found.camera.cx, found.camera.cy, found.readout_s}) {
    row.emplace_back(number);
  }
  for (const double number : found.field.coefficients) row.emplace_back(number);
  row.emplace_back(session.color_latency_s);
  for (const std::int64_t count :
       {session.runs, session.frames, session.keyframes, session.views, session.calibration_frames,
        session.edges, session.tiles, session.settled_keyframes, session.saves}) {
    row.emplace_back(count);
  }
  return row;
}

SessionRow TakeSession(RowReader* row) {
  SessionRow session;
  if (row->TakeInt() != 1) row->Fail("must have the key 1");
  PinholeCamera& camera = session.sensor.camera;
  camera.width = row->TakeInt();
  camera.height = row->TakeInt();
  for (double* number : {&camera.fx, &camera.fy, &camera.cx, &camera.cy,
                         &session.sensor.noise.inverse_depth_sigma, &session.sensor.readout_s}) {
    *number = row->TakeNumber();
  }
  const bool is_calibrated = row->TakeFlag();
  DepthCalibration found;
  found.camera.width = camera.width;
  found.camera.height = camera.height;
  for (double* number :
       {&found.camera.fx, &found.camera.fy, &found.camera.cx, &found.camera.cy, &found.readout_s}) {
    *number = row->TakeNumber();
  }
  for (double& number : found.field.coefficients) number = row->TakeNumber();
  if (is_calibrated) session.calibration = found;
  session.color_latency_s = row->TakeNumber();
  for (std::int64_t* count : {&session.runs, &session.frames, &session.keyframes, &session.views,
                              &session.calibration_frames, &session.edges, &session.tiles,
                              &session.settled_keyframes, &session.saves}) {
    *count = row->Take<std::int64_t>();
  }
  session.sensor.camera.Validate(row->from());
  if (is_calibrated) session.calibration->camera.Validate(row->from());
  return session;
}

Row RowOf(std::int64_t key, const SessionRun& run) {
  return {key,
          run.sequence,
          run.format,
          std::int64_t{run.first},
          std::int64_t{run.stride},
          std::int64_t{run.shift},
          AsInteger(run.mirrored),
          AsInteger(run.ended)};
}

SessionRun TakeRun(RowReader* row) {
  SessionRun run;
  row->TakeInt();
  run.sequence = row->Take<std::string>();
  run.format = row->Take<std::string>();
  run.first = row->TakeInt();
  run.stride = row->TakeInt();
  run.shift = row->TakeInt();
  run.mirrored = row->TakeFlag();
  run.ended = row->TakeFlag();
  return run;
}

Row RowOf(const PosedFrame& frame) {
  Row row = {std::int64_t{frame.index}, frame.stamp_s};
  PutPose(frame.world_from_camera, &row);
  row.emplace_back(std::int64_t{frame.keyframe});
  row.emplace_back(std::int64_t{frame.stretch});
  return row;
}

PosedFrame TakeFrame(RowReader* row) {
  PosedFrame frame;
  frame.index = row->TakeInt();
  frame.stamp_s = row->TakeNumber();
  frame.world_from_camera = row->TakePose();
  frame.keyframe = row->TakeInt();
  frame.stretch = row->TakeInt();
  return frame;
}

Row RowOf(std::int64_t key, const KeyframeLink& keyframe) {
  return {key, std::int64_t{keyframe.frame}, std::int64_t{keyframe.parent_frame},
          std::int64_t{keyframe.submap}};
}

KeyframeLink TakeKeyframe(RowReader* row) {
  KeyframeLink keyframe;
  row->TakeInt();
  keyframe.frame = row->TakeInt();
  keyframe.parent_frame = row->TakeInt();
  keyframe.submap = row->TakeInt();
  return keyframe;
}

Row RowOf(std::int64_t key, const PlaceView& view) {
  Packer packer;
  PutView(view, &packer);
  return {key, Blob{packer.bytes()}};
}

PlaceView TakeKeptView(RowReader* row) {
  row->TakeInt();
  Unpacker unpacker(row->Take<Blob>().bytes, row->from());
  PlaceView view = TakeView(PlacesPart::kAll, &unpacker);
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
    if (!(z >= 0) || !std::isfinite(z)) row->Fail("has a depth that is none");
  }
  if (!frame.color.empty() && frame.color.size() != frame.depth_m.size()) {
    row->Fail("has colours of another size than its depth");
  }
  return frame;
}

Row RowOf(std::int64_t key, const KeptEdge& kept) {
  const PoseGraphEdge& edge = kept.edge;
  Row row = {key, static_cast<std::int64_t>(edge.a), static_cast<std::int64_t>(edge.b)};
  PutPose(edge.a_from_b, &row);
  Packer packer;
  for (const double number : edge.information.reshaped()) packer.Put(number);
  row.emplace_back(Blob{packer.bytes()});
  row.emplace_back(AsInteger(edge.loop));
  row.emplace_back(AsInteger(kept.in_graph));
  return row;
}

KeptEdge TakeEdge(RowReader* row) {
  KeptEdge kept;
  row->TakeInt();
  kept.edge.a = static_cast<std::size_t>(row->TakeInt());
  kept.edge.b = static_cast<std::size_t>(row->TakeInt());
  kept.edge.a_from_b = row->TakePose();
  Unpacker unpacker(row->Take<Blob>().bytes, row->from());
  for (double& number : kept.edge.information.reshaped()) number = unpacker.Take<double>();
  unpacker.End();
  kept.edge.loop = row->TakeFlag();
  kept.in_graph = row->TakeFlag();
  if (!IsInformation(kept.edge.information)) row->Fail("has an information that is none");
  return kept;
}

Row RowOf(const TileRow& tile) { return {tile.key, tile.save, tile.bytes, tile.crc, tile.surfels}; }

TileRow TakeTile(RowReader* row) {
  TileRow tile;
  for (std::int64_t* number : {&tile.key, &tile.save, &tile.bytes, &tile.crc, &tile.surfels}) {
    *number = row->Take<std::int64_t>();
  }
  return tile;
}

double RowReader::TakeNumber() {
  const double number = Take<double>();
  if (!std::isfinite(number)) Fail(Concat("has no finite number in column ", at_));
  return number;
}

int RowReader::TakeInt() {
  const std::int64_t number = Take<std::int64_t>();
  using Limits = std::numeric_limits<int>;
  if (number < Limits::min() || number > Limits::max()) {
    Fail(Concat("has ", number, " in column ", at_, ", which is too large"));
  }
  return static_cast<int>(number);
}

Rigid3d RowReader::TakePose() {
  Rigid3d pose;
  for (double& number : pose.translation) number = TakeNumber();
  for (double& number : pose.rotation.coeffs()) number = TakeNumber();
  if (!(std::abs(pose.rotation.norm() - 1) < 1e-6)) Fail("has a rotation that is none");
  return pose;
}

}  // namespace surfit
