#include "surfit/slam/loop_options.h"

#include "surfit/core/error.h"

namespace surfit {
namespace {

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (!holds) throw InputError(Concat(field, " is ", value, ", must be ", constraint));
}

}  // namespace

void EdgeNoise::Validate() const {
  Require(shared_points >= 1, "shared_points", shared_points, "at least 1");
  Require(odometry_m > 0, "odometry_m", odometry_m, "positive");
  Require(odometry_rad > 0, "odometry_rad", odometry_rad, "positive");
  Require(odometry_share >= 0, "odometry_share", odometry_share, "zero or positive");
  Require(loop_m > 0, "loop_m", loop_m, "positive");
  Require(loop_rad > 0, "loop_rad", loop_rad, "positive");
}

void LoopOptions::Validate() const {
  keyframes.Validate();
  views.Validate();
  places.Validate();
  find.Validate();
  relocalize.Validate();
  noise.Validate();
  graph.Validate();
  Require(delay_frames >= 1, "delay_frames", delay_frames, "at least 1");
  Require(active_frames >= 0, "active_frames", active_frames, "zero (no limit) or positive");
  Require(frames_apart >= 1, "frames_apart", frames_apart, "at least 1");
  Require(min_correction_m >= 0, "min_correction_m", min_correction_m, "zero or positive");
  Require(new_map_after >= 0, "new_map_after", new_map_after, "zero (never) or positive");
}

}  // namespace surfit
