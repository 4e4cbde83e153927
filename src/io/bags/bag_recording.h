#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/bags/bag_topics.h"
#include "io/bags/message_log.h"
#include "io/bags/messages.h"
#include "io/sequences/recording.h"
#include "surfit/geometry/sensor.h"
#include "surfit/io/sequence.h"

namespace surfit {

// The frames of a ROS bag: messages of depth and colour paired by their stamps, as images of TUM
// folders are.
class BagRecording : public Recording {
 public:
  // Throws InputError naming the file, and the topic or option at fault.
  BagRecording(const SequenceOptions& options, const std::string& format, bool is_folder);

  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override { return frames_[index].stamps; }
  FrameImages Read(int index) const override;

  const std::vector<std::string>& warnings() const { return warnings_; }
  int unpaired_images() const { return unpaired_images_; }  // OpenedRecording

  // What the options tell of the camera, so that the bag need not.
  struct Known {
    bool depth = false, color = false, color_from_depth = false;
  };
  // The camera by CameraInfo and tf, at 1000 counts a metre (REP 118) and with the latency 0.
  // Throws InputError naming what the bag does not tell and the options to give.
  RgbdCamera Camera(const Known& known) const;

 private:
  struct Stamped {
    std::int64_t stamp_ns = 0;
    MessagePlace place;
  };
  struct Frame {
    FrameStamps stamps;
    MessagePlace depth, color;
  };

  std::vector<Stamped> InOrder(const Topic& topic);
  void Pair();
  ImageMessage ReadImage(const Topic& topic, const MessagePlace& place,
                         const std::string& name) const;
  // Nothing where no CameraInfo is of these images.
  std::optional<PinholeCamera> Pinhole(const ImageTopic& image) const;
  Rigid3d ColorFromDepth(bool is_known) const;

  std::unique_ptr<MessageLog> log_;
  BagTopics topics_;
  std::vector<Frame> frames_;
  std::vector<std::string> warnings_;
  int unpaired_images_ = 0;
};

}  // namespace surfit
