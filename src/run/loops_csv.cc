#include "run/loops_csv.h"

#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

// Of the verdict, or that the pose graph has overruled it.
std::string ReasonOf(const LoopRecord& loop) {
  const LoopVerdict& verdict = loop.attempt.verdict;
  return verdict.accepted() && !loop.in_graph ? "contradicts_others" : ToString(verdict.reason);
}

}  // namespace

void WriteLoopsCsv(const std::vector<LoopRecord>& loops, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << "source_frame,target_frame,similarity,reason,agreeing_features,inlier_share,rmse_m,"
            "overlap_share,free_space_share,lead,sigma_m,sigma_rad\n";
    for (const LoopRecord& loop : loops) {
      const LoopVerdict& v = loop.attempt.verdict;
      file << loop.source_frame << ',' << loop.target_frame << ','
           << loop.attempt.proposal.similarity << ',' << ReasonOf(loop) << ','
           << v.agreeing_features << ',' << v.inlier_share << ',' << v.rmse_m << ','
           << v.overlap_share << ',' << v.free_space_share << ',' << v.lead << ',' << v.sigma_m
           << ',' << v.sigma_rad << '\n';
    }
  });
}

}  // namespace surfit
