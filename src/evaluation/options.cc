// The options of this module.
#include "surfit/core/options.h"

#include <cmath>

#include "surfit/core/error.h"
#include "surfit/evaluation/map_error.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {

using Unit = RelativePoseErrorOptions::Unit;

static std::string OptionToText(const Unit& unit) {
  return unit == Unit::kFrames ? "frames" : "seconds";
}

static void OptionFromText(const std::string& text, Unit* unit) {
  ThrowIf(text != "frames" && text != "seconds", "'frames' or 'seconds'");
  *unit = text == "frames" ? Unit::kFrames : Unit::kSeconds;
}

void MatchOptions::Visit(OptionVisitor& v) {
  v.Add(max_difference_s, "max_difference_s",
        "where no true pose is interpolated, how far away the nearest one may be (evo: 0.01, TUM "
        "scripts: 0.02)",
        Between(0, 1), AsFlag());
  v.Add(max_gap_s, "max_gap_s", "interpolate between true poses at most so far apart",
        Between(0, 1), ZeroIs("take the nearest, as evo and the TUM scripts do"), AsFlag());
}

void RelativePoseErrorOptions::Visit(OptionVisitor& v) {
  v.Add(delta, "delta", "step of the relative pose error", Positive(), AsFlag());
  v.Add(delta_unit, "delta_unit", "unit of delta: frames or seconds", AsFlag());
  v.Check([this] {
    if (delta_unit != Unit::kFrames || (delta == std::floor(delta) && delta < 1e9)) return;
    throw InputError("delta is ", delta, " frames, must be an integer below 1e9");
  });
}

void TrajectoryEvaluationOptions::Visit(OptionVisitor& v) {
  v.AddPart(match, "match", "which poses belong to the same moment");
  v.AddPart(rpe, "rpe", "the relative pose error");
}

void MapErrorOptions::Visit(OptionVisitor& v) {
  v.Add(completeness_distance_m, "completeness_distance_m",
        "a reference point counts as mapped if a map point is at most this far", Positive(),
        AsFlag());
}

}  // namespace surfit
