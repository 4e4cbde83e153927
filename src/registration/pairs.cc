#include "surfit/registration/pairs.h"

namespace surfit {

Correspondences Moved(Correspondences pairs, const Rigid3d& motion) {
  for (int i = 0; i < pairs.size; ++i) {
    const Eigen::Vector3d p = motion * pairs.p(i), m = motion.rotation * pairs.m(i);
    pairs.px[i] = p.x(), pairs.py[i] = p.y(), pairs.pz[i] = p.z();
    pairs.mx[i] = m.x(), pairs.my[i] = m.y(), pairs.mz[i] = m.z();
  }
  return pairs;
}

}  // namespace surfit
