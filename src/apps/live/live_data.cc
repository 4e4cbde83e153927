#include "apps/live/live_data.h"

#include <chrono>
#include <cmath>

#include "io/images/image_files.h"
#include "output/output_files.h"

namespace surfit {
namespace {

std::size_t PlaceOf(Shown what) { return static_cast<std::size_t>(what); }

std::int64_t Now_ms() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
}

Json ToJson(const std::vector<Advice>& all) {
  Json json = Json::array();
  for (const Advice& advice : all) json.push_back({{"kind", advice.kind}, {"text", advice.text}});
  return json;
}

// Appends the three coordinates, rounded to millimetres.
template <typename Vector>
void AppendPosition(const Vector& place, Json* json) {
  for (int i = 0; i < 3; ++i) {
    json->push_back(static_cast<std::int64_t>(std::llround(1000. * place[i])));
  }
}

template <typename T>
void AppendBytes(const T* values, std::size_t count, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

}  // namespace

template <typename Act>
bool LiveData::Give(bool must, const Act& act) {
  std::unique_lock<std::mutex> lock(mutex_, std::defer_lock);
  if (must) lock.lock();
  if (!must && !lock.try_lock()) return false;
  act();
  return true;
}

void LiveData::Number(Shown what) { items_[PlaceOf(what)] = {++number_, nullptr}; }

bool LiveData::UpdateState(const ShownState& state, bool must) {
  return Give(must, [&] {
    state_ = state;
    Number(Shown::kState);
  });
}

bool LiveData::UpdatePath(const LivePath& path, bool must) {
  return Give(must, [&] {
    path_ = path;
    Number(Shown::kPath);
  });
}

bool LiveData::UpdatePictures(const std::map<Shown, Image<Rgb8>>& pictures, bool must) {
  return Give(must, [&] {
    ++number_;
    for (const auto& [which, picture] : pictures) {
      pictures_[PlaceOf(which)] = picture;
      items_[PlaceOf(which)] = {number_, nullptr};
    }
  });
}

std::optional<bool> LiveData::UpdateMap(const SurfelMap& map, std::size_t slots) {
  std::optional<bool> is_whole;
  Give(/*must=*/false, [&] {
    is_whole = sample_.Update(map, slots);
    Number(Shown::kMap);
    if (*is_whole) dust_ = sample_.Dust();
  });
  return is_whole;
}

void LiveData::ResetMap(const SurfelMap& map) {
  const std::lock_guard<std::mutex> lock(mutex_);
  sample_.Reset(map);
  Number(Shown::kMap);
  dust_ = sample_.Dust();
}

bool LiveData::IsRequested(Shown what) const {
  constexpr std::int64_t kLately_ms = 8000;  // longer than HttpLimits::hold_s
  const std::int64_t asked_ms = asked_ms_[PlaceOf(what)];
  return asked_ms > 0 && Now_ms() - asked_ms < kLately_ms;
}

void LiveData::RecordRequest(Shown what) { asked_ms_[PlaceOf(what)] = Now_ms(); }

std::string LiveData::StateJson(bool is_paused) const {
  const SlamRunProgress& progress = state_.progress;
  Json json = {{"number", number_.load()},
               {"status", state_.status},
               {"frame_state", ToString(state_.frame_state)},
               {"frames_done", progress.frames_done},
               {"frames_total", progress.frames_total},
               {"elapsed_s", progress.elapsed_s},
               {"frames_per_second", state_.frames_per_second},
               {"map_points", progress.map_points},
               {"shown", sample_.shown()},
               {"dust", dust_},
               {"paused", is_paused},
               {"at_result", state_.is_at_result},
               {"done", state_.is_done},
               {"advice", ToJson(state_.advice)},
               {"camera", CameraToJson(state_.camera)},
               {"loops", state_.loops}};
  json["pose"] = state_.world_from_camera ? ToJson(*state_.world_from_camera) : Json();
  json["last_loop"] =
      state_.last_loop ? Json{state_.last_loop->first, state_.last_loop->second} : Json();
  const auto number = [&](Shown what) { return items_[PlaceOf(what)].number; };
  json["numbers"] = {{"map", number(Shown::kMap)},
                     {"path", number(Shown::kPath)},
                     {"frame", number(Shown::kFrame)},
                     {"model", number(Shown::kModel)},
                     {"normals", number(Shown::kNormals)}};
  return json.dump();
}

LiveData::Text LiveData::StateAfter(std::uint32_t number, bool is_paused) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Item& item = items_[PlaceOf(Shown::kState)];
  const std::uint32_t now = number_;
  if (now <= number) return nullptr;
  if (!item.text || item.number != now) {
    item = {now, std::make_shared<std::string>(StateJson(is_paused))};
  }
  return item.text;
}

LiveData::Text LiveData::Path() {
  const std::lock_guard<std::mutex> lock(mutex_);
  Item& item = items_[PlaceOf(Shown::kPath)];
  if (item.number == 0 || item.text) return item.text;
  Json positions = Json::array(), loops = Json::array();
  for (const Eigen::Vector3f& place : path_.positions) AppendPosition(place, &positions);
  for (const LoopSegment& loop : path_.loops) {
    AppendPosition(loop.a, &loops);
    AppendPosition(loop.b, &loops);
  }
  const Json json = {{"number", item.number}, {"positions", positions}, {"loops", loops}};
  item.text = std::make_shared<std::string>(json.dump());
  return item.text;
}

// Encodes the picture without holding the lock, so that the run is not blocked.
LiveData::Text LiveData::Picture(Shown which, std::uint32_t asked) {
  constexpr int kQuality = 80;
  Image<Rgb8> picture;
  std::uint32_t number = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const Item& item = items_[PlaceOf(which)];
    if (asked != 0 && item.number != asked) return nullptr;
    if (item.number == 0 || item.text) return item.text;
    picture = pictures_[PlaceOf(which)];
    number = item.number;
  }
  Text text = std::make_shared<std::string>(EncodeJpeg(picture, kQuality));
  const std::lock_guard<std::mutex> lock(mutex_);
  Item& item = items_[PlaceOf(which)];
  if (item.number == number) item.text = text;
  return text;
}

LiveData::Text LiveData::Map(const SamplePlace& place, std::size_t most) {
  SampleChanges changes;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    changes = sample_.ChangesFrom(place, most);
  }
  const std::array<std::uint32_t, 6> head = {
      changes.epoch,   changes.level, changes.slots,
      changes.version, changes.next,  static_cast<std::uint32_t>(changes.slot.size())};
  const auto bytes = std::make_shared<std::string>();
  bytes->reserve(sizeof(head) +
                 changes.slot.size() * (sizeof(std::uint32_t) + sizeof(PackedSurfel)));
  AppendBytes(head.data(), head.size(), bytes.get());
  AppendBytes(changes.slot.data(), changes.slot.size(), bytes.get());
  AppendBytes(changes.surfel.data(), changes.surfel.size(), bytes.get());
  return bytes;
}

}  // namespace surfit
