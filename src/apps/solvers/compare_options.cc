#include "apps/solvers/pose_problem.h"
#include "core/shared_options.h"
#include "run/posed_views.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

void RequireSource(const CompareOptions& options) {
  const bool clouds = !options.source.empty() || !options.target.empty();
  const int sources = (options.synthetic_points != 0 ? 1 : 0) +
                      (options.sequence.path.empty() && options.run.empty() ? 0 : 1) +
                      (clouds ? 1 : 0) + (options.replay.empty() ? 0 : 1);
  ThrowIf(sources != 1,
          "synthetic_points, sequence or run, source with target, and replay: ", sources,
          " of these inputs are set, must be one");
  ThrowIf(!options.run.empty() && options.sequence.path.empty(), "run is '", options.run,
          "', requires its sequence");
  ThrowIf(clouds && (options.source.empty() || options.target.empty()),
          "source or target is missing, both must be set");
}

void RequireGrid(const char* option, const std::vector<double>& sizes, double max) {
  ThrowIf(sizes.empty(), option, " is empty, must contain a number");
  for (const double size : sizes) {
    ThrowIf(!(size >= 0 && size <= max), option, " contains ", size, ", must be from 0 to ", max);
  }
}

void CheckTogether(const CompareOptions& options) {
  RequireSource(options);
  const int points = options.synthetic_points;
  ThrowIf(points != 0 && (points < 10 || points > 100'000'000), "synthetic_points is ", points,
          ", must be from 10 to 100000000");
  ThrowIf(options.pairs == 0 && !options.slam, "pairs is 0, must be positive");
  ThrowIf(options.slam && options.sequence.path.empty(), "slam is set, requires a sequence");
  ThrowIf(options.slam && !options.run.empty(), "slam is set, cannot be combined with run, '",
          options.run, "'");
  if (!options.truth.empty()) {
    ParsePose("truth", options.truth);
    ThrowIf(options.source.empty(), "truth is '", options.truth,
            "', must be empty without source and target");
  }
  RequireGrid("rotations_deg", options.rotations_deg, 180);
  RequireGrid("translations_m", options.translations_m, 100);
  ThrowIf(options.max_keyframes == 1, "max_keyframes is 1, must be 0 (no limit) or at least 2");
  ThrowIf(options.threads.empty(), "threads is empty, must contain a number");
  for (const int count : options.threads) {
    ThrowIf(count < 1 || count > 1024, "threads contains ", count, ", must be from 1 to 1024");
  }
  SolverCombinations(options);  // throws for invalid names or combinations
}

}  // namespace

void CompareOptions::Visit(OptionVisitor& v) {
  v.Group("problem");
  v.Add(synthetic_points, "synthetic_points",
        "compare on this number of random points with known correspondences, without robust kernel",
        ZeroIs("none"));
  v.Add(noise_m, "noise_m",
        "standard deviation of the coordinates of the random points, also in the error model; 0: "
        "exact points",
        AtLeast(0));
  v.AddPart(sequence, "sequence", "compare on frames of a sequence", WithoutFlags({"stride"}),
            OptionalPart());
  v.Add(pairs, "pairs",
        "number of frame pairs, evenly spread over the sequence; 0: none, requires slam",
        AtLeast(0));
  v.Add(gap, "gap", "number of frames from source to target of a pair", AtLeast(1));
  v.Add(slam, "slam", "also run SLAM on the sequence with each combination, and compare the maps",
        Everyday());
  v.Add(source, SharedOption("source", Everyday()));
  v.Add(target, SharedOption("target", Everyday()));
  v.Add(truth, "truth",
        "true target_from_source of the clouds as tx,ty,tz,qx,qy,qz,qw; empty: unknown", AsFlag());
  v.Add(replay, "replay",
        "compare on a failed registration: a folder frame-XXXXXX of surfit_slam --dump_failures, "
        "with its initial pose and registration options",
        AsFlag());
  v.Add(run, SharedOption("run", Everyday()));
  v.Add(max_keyframes, SharedOption("max_keyframes"));
  v.Group("comparison");
  v.Add(output, SharedOption("output", Required(), Everyday()));
  v.Add(solvers, "solvers",
        "pose solvers (with run: reduced, ceres), comma-separated; empty: all, but ceres_per_point "
        "only with synthetic_points",
        AsFlag("solver"), Everyday());
  v.Add(linear_solvers, "linear_solvers",
        "linear solvers of ceres_per_point (with run: of ceres); empty: all",
        AsFlag("linear_solver"));
  v.Add(residuals, "residuals", "residuals (with run: planes, planes_and_textures); empty: all",
        AsFlag("residual"), Everyday());
  v.Add(associations, "associations", "data associations; empty: all that the input allows",
        AsFlag("association"));
  v.Add(threads, "threads", "numbers of threads, comma-separated; one row per number", AsFlag(),
        Everyday());
  v.Add(rotations_deg, "rotations_deg", "rotations of the initial poses relative to the truth",
        AsFlag());
  v.Add(translations_m, "translations_m",
        "translations of the initial poses relative to the truth, combined with each rotation",
        AsFlag());
  v.Add(seed, SharedOption("seed"));
  v.AddPart(preprocess, "preprocess", "depth preprocessing");
  v.AddPart(icp, "icp", "registration, except the compared options",
            WithoutFlags({"solver", "residual", "association"}));
  v.Check([this] { CheckTogether(*this); });
}

}  // namespace surfit
