#pragma once

#include <string>
#include <vector>

#include "surfit/core/atomic_file.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// Writes localization.csv: state, pose and standard deviations of each frame. Standard deviations
// (m, rad) are from the registration covariance, in the least certain direction, with the factor
// sqrt(EdgeNoise::shared_points). They are empty without a covariance. A lost frame has an empty
// pose. A lost frame that the next frame confirms gets a second row with the state "confirmed".
class LocalizationFile {
 public:
  // `mirrored` is SequenceInfo::mirrored. Throws InputError with the path if writing fails.
  LocalizationFile(const std::string& path, bool mirrored);

  // Call once per frame, in order. Throws InputError with the path if writing fails.
  void Add(const FrameReport& report);
  // Medians are 0 without a covariance.
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
