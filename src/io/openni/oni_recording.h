#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/openni/openni_device.h"
#include "io/sequences/recording.h"
#include "surfit/io/sequence.h"

namespace surfit {

// A name for a file that nothing in this process has while this lives: devices of one name share a
// position in the file.
class PlayerName {
 public:
  // Throws InputError where OpenNI2 holds no name of that length.
  explicit PlayerName(const std::string& path);
  ~PlayerName();
  PlayerName(const PlayerName&) = delete;
  PlayerName& operator=(const PlayerName&) = delete;

  const std::string& text() const { return text_; }

 private:
  int number_;
  std::string text_;
};

// A recording of OpenNI2 (.oni), played image by image. Depth and colour are paired by their
// stamps, as images of TUM folders are.
class OniRecording : public Recording {
 public:
  // Plays all of it once, for its stamps. Throws InputError naming the file.
  explicit OniRecording(const SequenceOptions& options);

  int frame_count() const override { return static_cast<int>(frames_.size()); }
  FrameStamps stamps(int index) const override { return frames_[index].stamps; }
  // Quick for one frame after the other; for an earlier one the rest of the file is played first.
  FrameImages Read(int index) const override;

  RgbdCamera Camera() const { return device_.Camera(options_); }
  const std::vector<std::string>& warnings() const { return warnings_; }
  int unpaired_images() const { return unpaired_images_; }  // OpenedRecording

 private:
  // Numbers of images in the file; color is 0 without one.
  struct Frame {
    FrameStamps stamps;
    int depth = 0, color = 0;
  };
  struct StampedNumber {
    double stamp_s = 0;
    int number = 0;
  };
  struct Images {
    std::vector<StampedNumber> depth, color;  // in order of their stamps
  };

  Images ListImages();
  void Pair(const Images& images);
  // How many images are played in some rounds of the file.
  int ImagesInRounds() const;

  SequenceOptions options_;
  PlayerName name_;
  mutable OpenNiDevice device_;
  mutable std::optional<DeviceImage> depth_, color_;  // the last ones that were played
  std::vector<Frame> frames_;
  std::vector<std::string> warnings_;
  int unpaired_images_ = 0;
};

}  // namespace surfit
