#include "io/corrected_source.h"

#include <utility>

#include "surfit/frame/correct_depth.h"

namespace surfit {
namespace {

class Corrected : public FrameSource {
 public:
  Corrected(std::unique_ptr<FrameSource> source, const InverseDepthField& field)
      : source_(std::move(source)), field_(field) {}

  const SequenceInfo& info() const override { return source_->info(); }

  std::optional<ReadResult> Next() override {
    std::optional<ReadResult> result = source_->Next();
    if (result && result->frame) {
      CorrectDepth(source_->info().pinhole, field_, &result->frame->depth_m);
    }
    return result;
  }

 private:
  std::unique_ptr<FrameSource> source_;
  InverseDepthField field_;
};

}  // namespace

std::unique_ptr<FrameSource> CorrectedSource(std::unique_ptr<FrameSource> source,
                                             const InverseDepthField& field) {
  if (field.IsZero()) return source;
  return std::make_unique<Corrected>(std::move(source), field);
}

}  // namespace surfit
