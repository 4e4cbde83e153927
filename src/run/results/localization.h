#pragma once

#include <string>
#include <vector>

#include "surfit/core/atomic_file.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// Writes where a camera was found in a map that stays as it is, frame by frame, and how sure that
// is: the standard deviations of position and turn, along the direction where they are largest, as
// the registration to the map tells. A frame that was lost when it came has another row once the
// next has confirmed it.
class LocalizationFile {
 public:
  // Throws InputError naming the file if it cannot be written.
  LocalizationFile(const std::string& path, bool mirrored);

  void Add(const FrameReport& report);
  Localization Summary() const;

 private:
  std::string TextOf(const Rigid3d& world_from_camera) const;

  AppendedFile file_;
  bool mirrored_;
  std::vector<double> sigmas_m_, sigmas_rad_;
  Localization summary_;
  bool is_lost_ = false;
  double lost_since_s_ = 0;
};

}  // namespace surfit
