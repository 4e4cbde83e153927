// Searches loop closures in a sequence, and prints verification results, CPU times and errors.
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>

#include "benchmarks/loop_search.h"

namespace surfit::testing {
namespace {

void Print(const LoopSearchResult& result) {
  std::map<GlobalRegistrationReason, int> counts;
  for (const FoundLoop& loop : result.loops) ++counts[loop.attempt.verdict.reason];
  for (const GlobalRegistrationReason reason : GlobalRegistrationReasons()) {
    std::printf("%-24s %5d loops\n", ToString(reason).c_str(), counts[reason]);
  }
  std::printf(
      "%d frames (%d without pose or depth), %zu keyframes, %.1f MB of views (%d given up)\n"
      "CPU time: %.2f ms per view, %.2f ms per query, %.2f ms per verification\n",
      result.frames, result.left_out, result.keyframes.size(), 1e-6 * result.view_bytes,
      result.given_up, result.view_ms, result.query_ms, result.verify_ms);
  if (!result.evaluation) return;
  const LoopEvaluation& e = *result.evaluation;
  std::printf(
      "%d of %d revisiting frames are linked; %d wrong loops accepted, %d of them disputed; "
      "largest "
      "errors of accepted loops: %.1f cm, %.2f deg\n",
      e.linked, e.revisiting, e.wrong, e.disputed, 100 * e.worst_m, e.worst_rad * 180 / M_PI);
}

}  // namespace
}  // namespace surfit::testing

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::cerr << "usage: loop_search_time SEQUENCE [TRAJECTORY]\n";
    return 1;
  }
  surfit::testing::LoopSearchOptions options;
  options.sequence.path = argv[1];
  options.trajectory = argc > 2 ? argv[2] : options.sequence.path + "/groundtruth.txt";
  surfit::testing::Print(surfit::testing::SearchLoops(options));
  return 0;
} catch (const std::exception& error) {
  std::cerr << "error: " << error.what() << std::endl;
  return 1;
}
