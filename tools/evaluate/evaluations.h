#pragma once

#include "common/modes.h"

namespace surfit::tools {

// Modes of surfit_evaluate: errors of trajectories, maps and rendered views, and poses of revisited
// places.
Mode TrajectoryEvaluationMode();
Mode MapEvaluationMode();
Mode ViewEvaluationMode();
Mode RevisitEvaluationMode();

}  // namespace surfit::tools
