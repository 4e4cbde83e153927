#include "simulation/turn.h"

namespace surfit {

// Alone in its file because Eigen's function brings a singular value decomposition along, which
// takes sanitizer builds long to compile.
Eigen::Quaterniond TurnZInto(const Eigen::Vector3d& direction) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction);
}

}  // namespace surfit
