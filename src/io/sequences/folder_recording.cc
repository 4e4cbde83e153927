#include "io/sequences/folder_recording.h"

#include <utility>

#include "io/images/image_files.h"
#include "io/sequences/confidence.h"

namespace surfit {
namespace {

class FolderRecording : public Recording {
 public:
  explicit FolderRecording(std::vector<FrameFiles> frames) : frames_(std::move(frames)) {}
  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override { return frames_[index].stamps; }
  FrameImages Read(int index) const override { return ReadFrameFiles(frames_[index]); }

 private:
  std::vector<FrameFiles> frames_;
};

}  // namespace

FrameImages ReadFrameFiles(const FrameFiles& files) {
  FrameImages images;
  images.depth_name = files.depth_path;
  images.color_name = files.color_path;
  images.depth = ReadDepthImage(files.depth_path);
  if (!files.confidence_path.empty()) RemoveLowConfidence(files, &images);
  if (!files.color_path.empty()) images.color = ReadColorImage(files.color_path);
  return images;
}

std::unique_ptr<Recording> MakeFolderRecording(std::vector<FrameFiles> frames) {
  return std::make_unique<FolderRecording>(std::move(frames));
}

}  // namespace surfit
