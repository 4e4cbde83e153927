#pragma once

#include <deque>
#include <exception>
#include <memory>
#include <optional>
#include <utility>

#include "surfit/frame/frame_source.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// Source that can read its first frames ahead to measure the depth noise. Frames, and an exception
// of the source, are returned in their order.
class MeasuredSource final : public FrameSource {
 public:
  explicit MeasuredSource(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  const SequenceInfo& info() const override { return source_->info(); }
  std::optional<ReadResult> Next() override;

  // Reads MeasuredNoise::kFrames frames, and logs a warning if their noise contradicts the starting
  // value. Call before Next(). Does not measure frames of live sources and frames at a fixed
  // rate: they cannot wait. The measured noise is not applied with
  // SequenceOptions::inverse_depth_sigma, and in a session, whose runs have the same sensor.
  NoiseReport Measure(const SlamRunOptions& options);

 private:
  void ReadFirstFrames();

  std::unique_ptr<FrameSource> source_;
  std::deque<ReadResult> first_;  // frames that are read, but not returned
  std::exception_ptr error_;      // thrown by the source after these frames
};

}  // namespace surfit
