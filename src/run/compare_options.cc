#include <cmath>

#include "run/given_poses.h"
#include "run/solver_combinations.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

void Require(bool holds, const char* option, double value, const char* constraint) {
  if (!holds) throw InputError(Concat(option, " is ", value, ", must be ", constraint));
}

void RequireSource(const CompareOptions& options) {
  const bool clouds = !options.source.empty() || !options.target.empty();
  const int sources = (options.synthetic_points != 0 ? 1 : 0) +
                      (options.sequence.path.empty() ? 0 : 1) + (clouds ? 1 : 0) +
                      (options.replay.empty() ? 0 : 1);
  if (sources != 1) {
    throw InputError(Concat("synthetic_points, sequence, source with target, and replay: ", sources,
                            " of them are set, must be one"));
  }
  if (clouds && (options.source.empty() || options.target.empty())) {
    throw InputError("source and target are two clouds: both must be set");
  }
}

void RequireGrid(const char* option, const std::vector<double>& sizes, double max) {
  if (sizes.empty()) throw InputError(Concat(option, " is empty, must have a number"));
  for (const double size : sizes) {
    if (!(size >= 0 && size <= max)) {
      throw InputError(Concat(option, " has ", size, ", must be from 0 to ", max));
    }
  }
}

}  // namespace

void CompareOptions::Validate() const {
  RequireSource(*this);
  if (output.empty()) throw InputError("output is empty, must name a folder");
  Require(synthetic_points == 0 || (synthetic_points >= 10 && synthetic_points <= 100'000'000),
          "synthetic_points", synthetic_points, "from 10 to 100000000");
  Require(noise_m >= 0 && std::isfinite(noise_m), "noise_m", noise_m, "zero or positive");
  if (!sequence.path.empty()) sequence.Validate();
  Require(pairs >= (slam ? 0 : 1), "pairs", pairs, slam ? "zero or positive" : "positive");
  if (slam && sequence.path.empty()) throw InputError("slam is set, must have a sequence");
  Require(gap >= 1, "gap", gap, "positive");
  if (!truth.empty()) {
    ParsePose("truth", truth);
    if (source.empty())
      throw InputError(Concat("truth is '", truth, "', must be empty without source and target"));
  }
  RequireGrid("rotations_deg", rotations_deg, 180);
  RequireGrid("translations_m", translations_m, 100);
  Require(max_rotation_error_deg > 0, "max_rotation_error_deg", max_rotation_error_deg, "positive");
  Require(max_translation_error_m > 0, "max_translation_error_m", max_translation_error_m,
          "positive");
  if (threads.empty()) throw InputError("threads is empty, must have a number");
  for (const int count : threads) {
    if (count < 1 || count > 1024) {
      throw InputError(Concat("threads has ", count, ", must be from 1 to 1024"));
    }
  }
  preprocess.Validate();
  icp.Validate();
  SolverCombinations(*this);  // throws where names or combinations are impossible
}

}  // namespace surfit
