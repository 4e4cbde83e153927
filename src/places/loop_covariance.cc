#include "places/loop_covariance.h"

namespace surfit {
namespace {

constexpr double kSharing = 25;  // points that share their noise: the depth filter's window
// In simulated rooms all loops are within three sigmas of it, most far within; a real Kinect's
// loops differ from each other by about as much.
constexpr double kFloorRad = 0.002, kFloorM = 0.004;

}  // namespace

Matrix6d LoopCovariance(const Matrix6d& covariance, double disagreement_rad,
                        double disagreement_m) {
  Matrix6d realistic = kSharing * covariance;
  realistic.diagonal().head<3>().array() +=
      kFloorRad * kFloorRad + disagreement_rad * disagreement_rad;
  realistic.diagonal().tail<3>().array() += kFloorM * kFloorM + disagreement_m * disagreement_m;
  return realistic;
}

}  // namespace surfit
