#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "io/recording.h"
#include "io/sequence_files.h"

namespace surfit {

// A frame that came, or was given up.
struct Arrival {
  double stamp_s = 0;
  std::optional<FrameImages> images;
  std::string error;     // why there are none
  double decode_ms = 0;  // time spent reading it
};

// Waits for numbered images, see WatchFolder().
class WatchedFolder {
 public:
  WatchedFolder(std::string path, double frames_per_second, const std::atomic<bool>& stop)
      : path_(std::move(path)), frames_per_second_(frames_per_second), stop_(stop) {}

  // The next frame once it is there, or nothing at the end.
  std::optional<Arrival> Next();

 private:
  using Clock = std::chrono::steady_clock;

  // Adds the frames that are new to those that wait.
  void List();
  // The first frame that waits, if it is whole or is to be given up.
  std::optional<Arrival> TakeFirst(bool ended);

  std::string path_;
  double frames_per_second_;
  const std::atomic<bool>& stop_;
  std::optional<std::string> color_folder_;  // once known; empty: frames without colour
  std::map<long, FrameFiles> waiting_;       // by number
  std::set<long> taken_;
  std::optional<Clock::time_point> first_try_;  // of the first frame that waits
};

}  // namespace surfit
