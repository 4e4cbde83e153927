#include "loop_closure/keyframe_view.h"

#include <memory>
#include <mutex>
#include <utility>

namespace surfit {
namespace {

// Made by whoever asks first; what it is made from goes then. Nobody waits for another thread,
// which may have less priority: both make it then.
class MadeView {
 public:
  MadeView(ColoredView source, const PlaceViewOptions& options)
      : source_(std::make_shared<ColoredView>(std::move(source))), options_(options) {}

  PlaceView Get() {
    std::shared_ptr<const ColoredView> source;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!source_) return view_;
      source = source_;
    }
    PlaceView view = MakePlaceView(source->pyramid, source->color, options_);
    const std::lock_guard<std::mutex> lock(mutex_);
    view_ = view;
    source_.reset();
    return view;
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<const ColoredView> source_;
  PlaceViewOptions options_;
  PlaceView view_;
};

}  // namespace

ViewOfKeyframe ViewOf(ColoredView source, const PlaceViewOptions& options) {
  auto made = std::make_shared<MadeView>(std::move(source), options);
  return [made] { return made->Get(); };
}

}  // namespace surfit
