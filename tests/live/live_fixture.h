#pragma once

#include <atomic>
#include <cmath>

#include "apps/live/live_run.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// Frames of a run: a wall at 2 m, and a map with the surfels added so far.
class LiveFixture {
 public:
  LiveFixture() {
    sensor_.camera = {160, 120, 140, 140, 79.5, 59.5};
    frame_.depth_m = Image<float>(160, 120, 2.f);
    frame_.color = Image<Rgb8>(160, 120, Rgb8{200, 120, 40});
    report_.state = FrameState::kTracked;
    AddRow();
  }

  // Adds a row of surfels.
  void AddRow() {
    for (int i = 0; i < 100; ++i) {
      Surfel surfel;
      surfel.position_in_world = {0.02f * static_cast<float>(i - 50),
                                  0.02f * static_cast<float>(rows_ % 50 - 25), 2};
      surfel.normal_in_world = {0, 0, -1};
      surfel.color = {200, 120, 40};
      surfel.radius_m = 0.015f;
      surfel.confidence = 5;
      map_.Append(surfel);
    }
    ++rows_;
  }

  SlamRunFrame Frame() const { return {frame_, report_, map_, sensor_, nullptr, age_ms_}; }

  SlamRunProgress Progress(const SlamRunFrame* frame) const {
    SlamRunProgress progress;
    progress.frames_done = frame_.index + 1;
    progress.frames_total = 100;
    progress.map_points = map_.size();
    progress.elapsed_s = 0.03 * progress.frames_done;
    progress.frame = frame;
    return progress;
  }

  // Reports the next frame to a run.
  void Tell(LiveRun* run) {
    const SlamRunFrame frame = Frame();
    run->Update(Progress(&frame));
    ++frame_.index;
    ++report_.index;
    report_.stamp_s += 0.03;
  }

  DepthSensor sensor_;
  RgbdFrame frame_;
  FrameReport report_;
  SurfelMap map_;
  double age_ms_ = 0;  // age of frames when they are reported
  std::atomic<bool> interrupted_{false};

 private:
  int rows_ = 0;
};

}  // namespace surfit
