#pragma once

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/live/live_run.h"
#include "apps/live/map_sample.h"
#include "surfit/core/image.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Kinds of data of the web page: kFrame is the input image, kModel and kNormals are views of the
// map.
enum class Shown { kState, kMap, kPath, kFrame, kModel, kNormals };
constexpr std::size_t kShownCount = 6;

// State of a run for the page.
struct ShownState {
  std::string status;
  FrameState frame_state = FrameState::kFirst;
  SlamRunProgress progress;
  double frames_per_second = 0;
  bool is_at_result = false, is_done = false;  // as in LiveRun
  std::vector<Advice> advice;
  std::optional<Rigid3d> world_from_camera;  // last pose; std::nullopt: none yet
  PinholeCamera camera;
  std::size_t loops = 0;
  std::optional<std::pair<int, int>> last_loop;  // frame indices; std::nullopt: none
};

// Camera positions and loop closures in the world frame, m.
struct LivePath {
  std::vector<Eigen::Vector3f> positions;
  std::vector<LoopSegment> loops;
};

// The thread of the run writes, the server thread reads. Without `must`, an update is skipped if
// the server has the lock, so that the run does not wait. Updates have increasing numbers. Number 0
// means no data.
class LiveData {
 public:
  explicit LiveData(std::size_t max_surfels) : sample_(max_surfels) {}

  // Functions for the run. Return false if the update was skipped. `must`: waits for the lock.
  bool UpdateState(const ShownState& state, bool must);
  bool UpdatePath(const LivePath& path, bool must);
  // Pictures of the same frame get the same number.
  bool UpdatePictures(const std::map<Shown, Image<Rgb8>>& pictures, bool must);
  // Returns the result of MapSample::Update(); std::nullopt if the update was skipped.
  std::optional<bool> UpdateMap(const SurfelMap& map, std::size_t slots);
  // Replaces the sample by the final map. Waits for the lock.
  void ResetMap(const SurfelMap& map);
  // Returns whether a page has requested this kind of data in the last 8 s.
  bool IsRequested(Shown what) const;

  // Functions for the server. They wait for the lock. Texts stay valid after updates.
  using Text = std::shared_ptr<const std::string>;
  // JSON; null if the state is not newer than `number`.
  Text StateAfter(std::uint32_t number, bool is_paused);
  // JSON; null before the first path.
  Text Path();
  // JPEG; null without picture, and if the picture does not have the number `asked`. 0: any number.
  Text Picture(Shown which, std::uint32_t asked);
  // SampleChanges, little endian: epoch, level, slots, version, next and count as uint32, then
  // `count` slots as uint32, then `count` PackedSurfel.
  Text Map(const SamplePlace& place, std::size_t most);
  // Call for each request, so that IsRequested() is true for 8 s.
  void RecordRequest(Shown what);
  void MarkChanged() { ++number_; }

 private:
  struct Item {
    std::uint32_t number = 0;
    Text text;  // encoded at the first request
  };
  // Calls act() with the lock. Returns false if the update is skipped.
  template <typename Act>
  bool Give(bool must, const Act& act);
  void Number(Shown what);
  std::string StateJson(bool is_paused) const;

  std::mutex mutex_;  // guards all members that are not atomic
  ShownState state_;
  LivePath path_;
  std::array<Image<Rgb8>, kShownCount> pictures_;
  std::array<Item, kShownCount> items_;
  MapSample sample_;
  std::uint8_t dust_ = 0;
  std::atomic<std::uint32_t> number_{0};
  // Time of the last request; 0: never.
  std::array<std::atomic<std::int64_t>, kShownCount> asked_ms_{};
};

}  // namespace surfit
