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

// What pages can ask for.
enum class Shown { kState, kMap, kPath, kFrame, kModel, kNormals };
constexpr std::size_t kShownCount = 6;

// How far a run is, as pages are told.
struct ShownState {
  std::string status;
  FrameState frame_state = FrameState::kFirst;
  SlamRunProgress progress;
  double frames_per_second = 0;
  bool is_at_result = false, is_done = false;
  std::vector<Advice> advice;
  std::optional<Rigid3d> world_from_camera;  // of the last frame that has a pose
  PinholeCamera camera;
  std::size_t loops = 0;
  std::optional<std::pair<int, int>> last_loop;
};

// The path and the loops, of a bounded size.
struct ShownPath {
  std::vector<Eigen::Vector3f> places;
  std::vector<LoopSegment> loops;
};

// What is shown of a run, between its thread, which gives, and the server's, which takes. The run
// never waits: where the server is just looking, it gives nothing this time. All that is given has
// a number, larger each time.
class ShownRun {
 public:
  explicit ShownRun(std::size_t max_surfels) : sample_(max_surfels) {}

  // The run's side: whether it has been given. `must` waits: for what the run has come to.
  bool GiveState(const ShownState& state, bool must);
  bool GivePath(const ShownPath& path, bool must);
  // Of one moment: they get one number.
  bool GivePictures(const std::map<Shown, Image<Rgb8>>& pictures, bool must);
  // MapSample's: whether all has been looked at; nothing where it was not given.
  std::optional<bool> UpdateMap(const SurfelMap& map, std::size_t slots);
  void ResetMap(const SurfelMap& map);
  // Whether somebody has asked for it within the last seconds.
  bool IsWanted(Shown what) const;

  // The server's side. JSON; nothing where the state is not newer than `number`.
  using Text = std::shared_ptr<const std::string>;
  Text StateAfter(std::uint32_t number, bool is_paused);
  // JSON; nothing where none has been given yet.
  Text Path();
  // A JPEG, if it has this number still; 0: whichever it has.
  Text Picture(Shown which, std::uint32_t asked);
  // SampleChanges, little endian: epoch, level, slots, version, next and count as uint32, as many
  // slots as uint32, and as many ShownSurfel.
  Text Map(const SamplePlace& place, std::size_t most);
  void Want(Shown what);
  // The state is another one, without being given.
  void Renew() { ++number_; }

 private:
  struct Item {
    std::uint32_t number = 0;
    Text text;  // made when it is asked for
  };
  // Calls act() with the mutex. Without `must`: false if the server has it.
  template <typename Act>
  bool Give(bool must, const Act& act);
  void Number(Shown what);
  std::string StateJson(bool is_paused) const;

  std::mutex mutex_;  // of all but what is atomic
  ShownState state_;
  ShownPath path_;
  std::array<Image<Rgb8>, kShownCount> pictures_;
  std::array<Item, kShownCount> items_;
  MapSample sample_;
  std::uint8_t dust_ = 0;  // MapSample's
  std::atomic<std::uint32_t> number_{0};
  std::array<std::atomic<std::int64_t>, kShownCount> asked_ms_{};  // 0: never
};

}  // namespace surfit
