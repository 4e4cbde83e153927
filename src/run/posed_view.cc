#include "run/posed_view.h"

#include <memory>
#include <utility>

#include "surfit/core/error.h"

namespace surfit {

PosedView ReadPosedView(const SequenceOptions& options, int index,
                        const PreprocessOptions& preprocess) {
  SequenceOptions sequence = options;
  sequence.first = sequence.last = index;
  sequence.stride = 1;
  const std::unique_ptr<FrameSource> source = OpenSequence(sequence);
  std::optional<ReadResult> result = source->Next();
  if (!result) throw InputError(Concat(sequence.path, ": there is no frame ", index));
  if (!result->frame) throw InputError(result->error);
  PosedView posed;
  posed.view.pyramid = PreprocessDepth(result->frame->depth_m, source->info().pinhole, preprocess);
  posed.view.color = std::move(result->frame->color);
  posed.world_from_camera = InterpolatePose(source->info().ground_truth, result->stamp_s);
  return posed;
}

}  // namespace surfit
