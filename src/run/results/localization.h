#pragma once

#include <string>
#include <vector>

#include "surfit/core/atomic_file.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// Writes localization.csv: state, pose and standard deviations of each frame. Standard deviations
// are from the registration covariance, in the least certain direction. A lost frame that the next
// frame confirms gets a second row with the state "confirmed".
class LocalizationFile {
 public:
  // `mirrored` is SequenceInfo::mirrored. Throws InputError with the path if writing fails.
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
