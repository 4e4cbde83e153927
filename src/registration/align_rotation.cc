#include <algorithm>

#include "registration/joint_descent.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

Rigid3d AlignRotation(const ViewPair& views, const Rigid3d& target_from_source_initial) {
  const auto levels =
      static_cast<int>(std::min(views.source.levels.size(), views.target.levels.size()));
  if (levels == 0) return target_from_source_initial;
  const BrightnessLevel source = CoarseBrightness(views.source_color, levels - 1);
  const BrightnessLevel target = CoarseBrightness(views.target_color, levels - 1);
  DescentOptions descent;
  descent.rotation_only = true;
  descent.use_brightness = !source.value.empty() && !target.value.empty();
  return Descend({views.source.levels[levels - 1], source},
                 {views.target.levels[levels - 1], target}, target_from_source_initial, descent);
}

}  // namespace surfit
