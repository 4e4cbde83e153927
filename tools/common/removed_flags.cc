#include "common/removed_flags.h"

#include <array>

#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

struct RemovedFlag {
  const char *program, *flag, *replacement;
};

// Flags of version 0.1. Version 0.3 drops this table.
constexpr std::array kRemovedFlags = {
    RemovedFlag{"surfit_align", "initialize", "start"},
    RemovedFlag{"surfit_align", "source", "source_frame"},
    RemovedFlag{"surfit_align", "target", "target_frame"},
    RemovedFlag{"surfit_compare_solvers", "threads", "thread_counts"},
    RemovedFlag{"surfit_evaluate", "frames", "frame_list"},
    RemovedFlag{"surfit_evaluate", "max_angle_deg", "revisit_angle_deg"},
    RemovedFlag{"surfit_evaluate", "max_distance_m", "revisit_distance_m"},
    RemovedFlag{"surfit_evaluate", "min_gap", "revisit_gap"},
    RemovedFlag{"surfit_evaluate", "pictures", "view_pictures"},
    RemovedFlag{"surfit_optimize", "max_iterations", "max_graph_iterations"},
    RemovedFlag{"surfit_record", "frames", "max_frames"},
    RemovedFlag{"surfit_refine", "linear_solver", "refinement_linear_solver"},
    RemovedFlag{"surfit_refine", "solver", "refinement_solver"},
};

}  // namespace

std::string Replacement(const std::string& program, const std::string& flag) {
  for (const RemovedFlag& removed : kRemovedFlags) {
    if (program != removed.program || flag != removed.flag) continue;
    return Concat("--", flag, " was removed in 0.2: use --", removed.replacement);
  }
  return "";
}

}  // namespace surfit::tools
