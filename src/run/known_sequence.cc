#include "run/known_sequence.h"

#include <algorithm>
#include <utility>

#include "slam/moving_regions.h"

namespace surfit {

std::unique_ptr<FrameSource> OpenAgain(const SequenceOptions& sequence) {
  constexpr int kReadAhead = 4;
  return ReadAhead(OpenSequence(sequence), kReadAhead);
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
