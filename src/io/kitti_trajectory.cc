#include "surfit/io/kitti_trajectory.h"

#include <iomanip>
#include <locale>

#include "surfit/core/atomic_file.h"

namespace surfit {

void WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.imbue(std::locale::classic());
    out << std::fixed << std::setprecision(9);
    for (const StampedPose& pose : trajectory) {
      const Eigen::Matrix3d rotation = pose.world_from_camera.rotation.toRotationMatrix();
      const Eigen::Vector3d& translation = pose.world_from_camera.translation;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out << rotation(i, j) << ' ';
        out << translation[i] << (i < 2 ? ' ' : '\n');
      }
    }
  });
}

}  // namespace surfit
