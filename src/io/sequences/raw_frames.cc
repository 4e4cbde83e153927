#include "io/sequences/raw_frames.h"

#include <utility>

#include "core/trace.h"
#include "io/sequences/image_sequence.h"
#include "surfit/core/error.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {
namespace {

// Prepares what is read.
class ImageSource : public FrameSource {
 public:
  explicit ImageSource(RawSequence sequence) : sequence_(std::move(sequence)) {}

  const SequenceInfo& info() const override { return sequence_.info; }

  std::optional<ReadResult> Next() override {
    std::optional<RawFrame> raw = sequence_.frames->Next();
    if (!raw) return std::nullopt;
    ReadResult result = std::move(raw->head);
    const RgbdCamera& camera = info().camera;
    const FrameStamps moments = MomentsOf(raw->stamps, camera);
    result.stamp_s = moments.depth_s;
    if (!result.error.empty()) return result;
    try {
      const StageTimer timer("decode", result.index, &result.decode_ms);
      result.frame =
          MakeFrame(camera, sequence_.preparer, sequence_.frames->Read(), result.index, moments);
    } catch (const InputError& error) {
      result.error = error.what();
      return result;
    }
    if (!sequence_.field.IsZero())
      CorrectDepth(info().pinhole, sequence_.field, &result.frame->depth_m);
    return result;
  }

 private:
  RawSequence sequence_;
};

}  // namespace

RawSequence Complete(SequenceInfo info, std::unique_ptr<RawFrames> frames,
                     const SequenceOptions& options) {
  FramePreparer preparer = CompleteInfo(frames->FirstImages(), options.prepare, &info);
  InverseDepthField field = ReadDepthField(options, info.format);
  return {std::move(info), std::move(frames), std::move(preparer), field};
}

std::unique_ptr<FrameSource> Prepared(RawSequence sequence) {
  return std::make_unique<ImageSource>(std::move(sequence));
}

}  // namespace surfit
