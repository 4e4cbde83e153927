#include <ostream>

#include "run/results/result_files.h"
#include "surfit/core/atomic_file.h"

namespace surfit {
namespace {

constexpr char kColumns[] =
    "source,target,similarity,prior,reason,matches,agreeing_features,inlier_share,rmse_m,"
    "overlap_share,free_space_share,value_correlation,detail_correlation,lead,sigma_m,sigma_rad,"
    "disagreement_m,disagreement_rad,tx,ty,tz,qx,qy,qz,qw";

void WriteColumns(const LoopRecord& loop, const std::string& reason, std::ostream& file) {
  const FarVerdict& v = loop.attempt.verdict;
  const Eigen::Vector3d& t = v.target_from_source.translation;
  const Eigen::Quaterniond& q = v.target_from_source.rotation;
  file << loop.source_frame << ',' << loop.target_frame << ',' << loop.attempt.proposal.similarity
       << ',' << loop.attempt.proposal.target_from_source_prior.has_value() << ',' << reason << ','
       << v.matches << ',' << v.agreeing_features << ',' << v.inlier_share << ',' << v.rmse_m << ','
       << v.overlap_share << ',' << v.free_space_share << ',' << v.value_correlation << ','
       << v.detail_correlation << ',' << v.lead << ',' << v.sigma_m << ',' << v.sigma_rad << ','
       << v.disagreement_m << ',' << v.disagreement_rad << ',' << t.x() << ',' << t.y() << ','
       << t.z() << ',' << q.x() << ',' << q.y() << ',' << q.z() << ',' << q.w();
}

// Of the verdict, or that the pose graph has overruled it.
std::string ReasonOf(const LoopRecord& loop) {
  const FarVerdict& verdict = loop.attempt.verdict;
  return verdict.accepted() && !loop.in_graph ? "contradicts_others" : ToString(verdict.reason);
}

}  // namespace

void WriteLoopsCsv(const std::vector<LoopRecord>& loops, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << kColumns << '\n';
    for (const LoopRecord& loop : loops) {
      if (loop.is_kept) continue;
      WriteColumns(loop, ReasonOf(loop), file);
      file << '\n';
    }
  });
}

}  // namespace surfit
