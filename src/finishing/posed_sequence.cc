#include "finishing/posed_sequence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "surfit/core/error.h"
#include "surfit/frame/rectify_frame.h"
#include "tracking/moving_regions.h"

namespace surfit {
namespace {

class RangesOfSequence final : public FrameSource {
 public:
  RangesOfSequence(const SequenceOptions& sequence, const std::vector<FrameRange>& ranges)
      : sequence_(sequence) {
    int frames = 0;
    for (FrameRange range : ranges) {
      const int past = range.first - sequence.first, stride = sequence.stride;
      range.first = sequence.first + (past + stride - 1) / stride * stride;
      if (range.first > range.last) continue;
      ranges_.push_back(range);
      frames += (range.last - range.first) / stride + 1;
    }
    if (ranges_.empty()) {
      info_ = OpenSequence(sequence)->info();
    } else {
      Open();
      info_ = source_->info();
    }
    info_.frame_count = frames;
  }

  const SequenceInfo& info() const override { return info_; }
  std::optional<ReadResult> Next() override {
    if (!source_) return std::nullopt;
    std::optional<ReadResult> read = source_->Next();
    while (!read && ++at_ < ranges_.size()) {
      Open();
      read = source_->Next();
    }
    return read;
  }

 private:
  void Open() {
    SequenceOptions part = sequence_;
    part.first = ranges_[at_].first;
    part.last = ranges_[at_].last;
    source_ = OpenSequence(part);
  }

  SequenceOptions sequence_;
  std::vector<FrameRange> ranges_;  // they begin at a frame of the stride
  std::size_t at_ = 0;
  std::unique_ptr<FrameSource> source_;
  SequenceInfo info_;
};

}  // namespace

std::unique_ptr<FrameSource> ReopenSequence(const SequenceOptions& sequence,
                                            const std::vector<FrameRange>& ranges) {
  constexpr int kReadAhead = 4;
  if (ranges.empty()) return ReadAhead(OpenSequence(sequence), kReadAhead);
  return ReadAhead(std::make_unique<RangesOfSequence>(sequence, ranges), kReadAhead);
}

bool ReadPosedFrames(const PosedSequence& known, FrameSource* source,
                     const std::atomic<bool>& interrupted,
                     const std::function<void(std::size_t pose, RgbdFrame frame)>& call) {
  while (std::optional<ReadResult> read = source->Next()) {
    if (interrupted) return false;
    const auto at = std::lower_bound(known.frames.begin(), known.frames.end(), read->index);
    if (!read->frame || at == known.frames.end() || *at != read->index) continue;
    RgbdFrame frame = *std::move(read->frame);
    const auto moving = known.moving.find(frame.index);
    if (moving != known.moving.end()) {
      frame.depth_m = Without(std::move(frame.depth_m), moving->second);
    }
    call(static_cast<std::size_t>(at - known.frames.begin()), std::move(frame));
  }
  return true;
}

DepthSensor EstimatedSensor::Of(DepthSensor given) const {
  if (!calibration) return given;
  given.camera = calibration->camera;
  given.readout_s = calibration->readout_s;
  return given;
}

void EstimatedSensor::Correct(RgbdFrame* frame) const {
  if (calibration) CorrectDepth(calibration->camera, calibration->field, &frame->depth_m);
  frame->color_stamp_s -= color_latency_s;
}

std::string CalibrationWarning(const DepthSensor& given, const DepthCalibration& found) {
  constexpr double kLimit = 23.2;
  const PinholeCamera &a = given.camera, &b = found.camera;
  const CalibrationPrior& prior = given.prior;
  double squared_distance = 0;
  const auto add = [&](double difference, double sigma) {
    if (sigma == 0) return;
    squared_distance += difference * difference / (sigma * sigma);
  };
  add(b.fx / a.fx - 1, prior.focal_relative_sigma);
  add(b.fx / b.fy * (a.fy / a.fx) - 1, prior.aspect_relative_sigma);
  add(b.cx - a.cx, prior.center_px);
  add(b.cy - a.cy, prior.center_px);
  for (const double c : found.field.coefficients) add(c, prior.inverse_depth_sigma);
  if (squared_distance <= kLimit) return "";
  return Concat(
      "the estimated calibration contradicts the input camera (squared distance ",
      std::round(squared_distance), ", limit ", kLimit,
      "): the input may belong to another camera, so poses and map may be wrong; check camera, "
      "intrinsics and depth_scale");
}

}  // namespace surfit
