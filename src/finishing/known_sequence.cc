#include "finishing/known_sequence.h"

#include <algorithm>
#include <utility>

#include "tracking/moving_regions.h"

namespace surfit {

namespace {

// Ranges of a sequence, one after the other.
class RangesOfSequence final : public FrameSource {
 public:
  RangesOfSequence(const SequenceOptions& sequence, const std::vector<FrameRange>& ranges)
      : sequence_(sequence), ranges_(ranges) {
    Open();
    info_ = source_->info();
    info_.frame_count = 0;
    for (const FrameRange& range : ranges) {
      info_.frame_count += (range.last - range.first) / sequence.stride + 1;
    }
  }

  const SequenceInfo& info() const override { return info_; }
  std::optional<ReadResult> Next() override {
    std::optional<ReadResult> read = source_->Next();
    while (!read && ++at_ < ranges_.size()) {
      Open();
      read = source_->Next();
    }
    return read;
  }

 private:
  // Its frames are those of the whole sequence with that stride.
  void Open() {
    SequenceOptions part = sequence_;
    const int past = ranges_[at_].first - sequence_.first;
    part.first = sequence_.first + (past + part.stride - 1) / part.stride * part.stride;
    part.last = std::max(part.first, ranges_[at_].last);
    source_ = OpenSequence(part);
  }

  SequenceOptions sequence_;
  std::vector<FrameRange> ranges_;
  std::size_t at_ = 0;
  std::unique_ptr<FrameSource> source_;
  SequenceInfo info_;
};

}  // namespace

std::unique_ptr<FrameSource> OpenAgain(const SequenceOptions& sequence,
                                       const std::vector<FrameRange>& ranges) {
  constexpr int kReadAhead = 4;
  if (ranges.empty()) return ReadAhead(OpenSequence(sequence), kReadAhead);
  return ReadAhead(std::make_unique<RangesOfSequence>(sequence, ranges), kReadAhead);
}

bool ReadKnownFrames(const KnownSequence& known, FrameSource* source,
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

}  // namespace surfit
