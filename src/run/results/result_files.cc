#include "run/results/result_files.h"

#include <array>
#include <map>
#include <ostream>

#include "core/shared_options.h"
#include "output/output_files.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

Json ToJson(const TimeStatistics& times) {
  return {{"mean", times.mean_ms}, {"median", times.median_ms}, {"p95", times.p95_ms}};
}

void SetErrors(const SlamRunSummary& summary, Json* json) {
  Json& j = *json;
  for (const char* key :
       {"ate_rmse_m", "ate_coverage", "rpe_translation_rmse_m", "rpe_rotation_rmse_deg",
        "ate_without_latency_rmse_m", "estimated_time_offset_s",
        "ate_at_estimated_time_offset_rmse_m", "ate_fit_mount_rmse_m", "mount_m"}) {
    j[key] = nullptr;
  }
  const std::optional<TrajectoryEvaluation>& evaluation = summary.evaluation;
  if (!evaluation) return;
  j["ate_coverage"] = evaluation->coverage;
  if (evaluation->ate) j["ate_rmse_m"] = evaluation->ate->translation_m.rmse;
  if (evaluation->rpe) {
    j["rpe_translation_rmse_m"] = evaluation->rpe->translation_m.rmse;
    j["rpe_rotation_rmse_deg"] = evaluation->rpe->rotation_deg.rmse;
  }
  if (summary.ate_without_latency) {
    j["ate_without_latency_rmse_m"] = summary.ate_without_latency->translation_m.rmse;
  }
  if (summary.mount) {
    j["ate_fit_mount_rmse_m"] = summary.mount->ate.translation_m.rmse;
    j["mount_m"] = summary.mount->true_body_in_estimated_m;
  }
  if (summary.time_offset) {
    j["estimated_time_offset_s"] = summary.time_offset->offset_s;
    j["ate_at_estimated_time_offset_rmse_m"] = summary.time_offset->ate.translation_m.rmse;
  }
}

Json ToJson(const CalibrationRecord& record) {
  const RefinementSummary& s = record.summary;
  return {{"frame", record.frame},
          {"keyframes", record.keyframes},
          {"last_keyframe", record.begun_frame},
          {"termination", ToString(s.termination)},
          {"as_given", s.calibration_kept},
          {"found", ToJson(s.calibration)},
          {"standard_deviations", CalibrationSigmasToJson(s.calibration_covariance)},
          {"squared_distance", s.calibration_distance},
          {"limit", s.calibration_limit},
          {"half_gains", s.half_gains},
          {"held_out_gains", s.held_out_gains},
          {"gain_limit", s.gain_limit},
          {"color_latency_s", record.color_latency.latency_s},
          {"color_latency_standard_deviation", record.color_latency.sigma_s}};
}

// Writes one row per frame. A JSON tree of a long run would need too much memory.
void WritePoses(const RunPoses& run, std::ostream& out) {
  out << '[';
  for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
    const StampedPose& pose = run.trajectory[i];
    const Eigen::Vector3d& t = pose.world_from_camera.translation;
    const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
    const Json row = {run.frames[i], pose.stamp_s, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
    out << (i > 0 ? "," : "") << row;
  }
  out << ']';
}

Json TruthOf(const RunPoses& run, const Rigid3d& estimated_from_true) {
  Json truth = Json::array();
  for (const StampedPose& pose : run.truth) {
    const Eigen::Vector3d t = estimated_from_true * pose.world_from_camera.translation;
    truth.push_back({pose.stamp_s, t.x(), t.y(), t.z()});
  }
  return truth;
}

Json ErrorsOf(const RunPoses& run, const Rigid3d& estimated_from_true) {
  std::map<double, int> frame_at;
  for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
    frame_at[run.trajectory[i].stamp_s] = run.frames[i];
  }
  Json errors = Json::array();
  for (const MatchedPose& pose : MatchPoses(run.truth, run.largest_piece, MatchOptions())) {
    const Eigen::Vector3d truth = estimated_from_true * pose.ground_truth.translation;
    errors.push_back({frame_at.at(pose.stamp_s), (truth - pose.estimate.translation).norm()});
  }
  return errors;
}

// Both trajectories are in the order of their timestamps.
Json FramesOfLargestPiece(const RunPoses& run) {
  if (run.largest_piece.size() == run.trajectory.size()) return nullptr;
  Json frames = Json::array();
  auto pose = run.largest_piece.begin();
  for (std::size_t i = 0; i < run.trajectory.size() && pose != run.largest_piece.end(); ++i) {
    if (run.trajectory[i].stamp_s != pose->stamp_s) continue;
    frames.push_back(run.frames[i]);
    ++pose;
  }
  return frames;
}

template <typename Kept>
Json ToJson(const std::vector<KeptView>& kept) {
  Json views = Json::array();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const KeptView& view = kept[i];
    Json files = Json::object();
    for (const KeptView::Picture& picture : view.pictures) {
      files[picture.name] = Kept::FileName(static_cast<int>(i), picture.name);
    }
    views.push_back(
        {{"index", view.index}, {"stamp_s", view.stamp_s}, {"why", view.why}, {"files", files}});
  }
  return views;
}

Json ToJson(const std::vector<KeyframeLink>& keyframes) {
  Json rows = Json::array();
  for (const KeyframeLink& link : keyframes) {
    rows.push_back({link.frame, link.parent_frame, link.submap});
  }
  return rows;
}

constexpr char kLoopColumns[] =
    "source,target,similarity,prior,reason,matches,agreeing_features,inlier_ratio,rmse_m,"
    "overlap_ratio,free_space_violation_ratio,value_correlation,detail_correlation,score_margin,"
    "sigma_m,sigma_rad,disagreement_m,disagreement_rad,tx,ty,tz,qx,qy,qz,qw";

void WriteColumns(const LoopRecord& loop, const std::string& reason, std::ostream& file) {
  const GlobalRegistrationResult& v = loop.attempt.verdict;
  const Eigen::Vector3d& t = v.target_from_source.translation;
  const Eigen::Quaterniond& q = v.target_from_source.rotation;
  file << loop.source_frame << ',' << loop.target_frame << ',' << loop.attempt.proposal.similarity
       << ',' << loop.attempt.proposal.target_from_source_prior.has_value() << ',' << reason << ','
       << v.matches << ',' << v.agreeing_features << ',' << v.inlier_ratio << ',' << v.rmse_m << ','
       << v.overlap_ratio << ',' << v.free_space_violation_ratio << ',' << v.value_correlation
       << ',' << v.detail_correlation << ',' << v.score_margin << ',' << v.sigma_m << ','
       << v.sigma_rad << ',' << v.disagreement_m << ',' << v.disagreement_rad << ',' << t.x() << ','
       << t.y() << ',' << t.z() << ',' << q.x() << ',' << q.y() << ',' << q.z() << ',' << q.w();
}

// Reason of the verification; "contradicts_others": verified loop that is an outlier of the pose
// graph.
std::string ReasonOf(const LoopRecord& loop) {
  const GlobalRegistrationResult& verdict = loop.attempt.verdict;
  return verdict.accepted() && !loop.in_graph ? "contradicts_others" : ToString(verdict.reason);
}

// Up direction in the world frame.
std::array<double, 3> UpIn(const Rigid3d& upright_from_world) {
  const Eigen::Vector3d up = upright_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  return {up.x(), up.y(), up.z()};
}

std::array<double, 3> NumbersOf(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

Json ToJson(const ImuReport& imu) {
  Json bridges = Json::array();
  for (const ImuBridge& bridge : imu.bridges) {
    bridges.push_back({{"frame", bridge.frame},
                       {"seconds", bridge.seconds},
                       {"predicted", ToJson(bridge.world_from_camera)},
                       {"sigma_m", bridge.sigma_m},
                       {"sigma_deg", bridge.sigma_rad / kRadPerDeg},
                       {"correction_m", bridge.correction_m},
                       {"correction_deg", bridge.correction_rad / kRadPerDeg}});
  }
  Json j = {{"read_from", imu.read_from},
            {"off_reason", imu.off_reason.empty() ? Json() : Json(imu.off_reason)},
            {"frames_predicted_by_gyroscope", imu.gyro_frames},
            {"frames_predicted_by_both", imu.full_frames},
            {"starts", imu.starts},
            {"bridges", bridges},
            {"gyro_bias_rad_per_s", NumbersOf(imu.bias.gyro_rad_per_s)},
            {"gyro_bias_sigma_rad_per_s", imu.gyro_bias_sigma_rad_per_s},
            {"accel_bias_m_per_s2", NumbersOf(imu.bias.accel_m_per_s2)},
            {"time_offset_s", imu.calibration.time_offset_s},
            {"time_offset_sigma_s", imu.calibration.time_offset_sigma_s},
            {"camera_from_imu", nullptr},
            {"up_in_world", nullptr}};
  if (imu.rotation_is_known) {
    j["camera_from_imu"] = ToJson(imu.calibration.camera_from_imu);
    j["rotation_sigma_deg"] = imu.calibration.rotation_sigma_rad / kRadPerDeg;
    j["translation_sigma_m"] = imu.calibration.translation_sigma_m;
  }
  if (imu.up_in_world) {
    j["up_in_world"] = NumbersOf(*imu.up_in_world);
    j["up_sigma_deg"] = imu.up_sigma_rad / kRadPerDeg;
  }
  return j;
}

Json ToJson(const NoiseReport& noise) {
  return {{"start", noise.start},    {"measured", noise.measured ? Json(*noise.measured) : Json()},
          {"used", noise.used},      {"is_applied", noise.is_applied},
          {"frames", noise.frames},  {"pairs", noise.pairs},
          {"samples", noise.samples}};
}

}  // namespace

void WriteSummaryJson(const SlamRunSummary& s, const SlamRunOptions& options,
                      const std::string& path) {
  Json j;
  j["frames_total"] = s.frames_total;
  j["frames_tracked"] = s.frames_tracked;
  j["frames_with_pose"] = s.frames_with_pose;
  j["frames_lost"] = s.frames_lost;
  j["frames_with_motion"] = s.frames_with_motion;
  j["frames_confirmed"] = s.frames_confirmed;
  j["frames_lost_in_motion"] = s.frames_lost_in_motion;
  j["frames_degenerate"] = s.frames_degenerate;
  j["frames_with_two_motions"] = s.frames_with_two_motions;
  j["frames_fused"] = s.frames_fused;
  j["held_out_frames"] = s.held_out_frames;
  j["frames_skipped"] = s.frames_skipped;
  j["frames_dropped"] = s.frames_dropped;
  j["frames_with_longer_map_period"] = s.frames_with_longer_map_period;
  j["longest_map_period"] = s.longest_map_period;
  j["pauses"] = s.pauses;
  j["paused_s"] = s.paused_s;
  j["frames_without_intensities"] = s.frames_without_intensities;
  j["interrupted"] = s.interrupted;
  j["failure"] = s.failure.empty() ? Json() : Json(s.failure);
  j["keyframes"] = s.loops.keyframes;
  j["loop_candidates"] = s.loops.loop_candidates;
  j["loops_accepted"] = s.loops.loops_accepted;
  j["loops_rejected"] = s.loops.loops_rejected;
  j["map_corrections"] = s.loops.corrections;
  j["relocalisations"] = s.loops.relocalisations;
  j["submaps"] = s.loops.submaps;
  j["disconnected_submaps"] = s.loops.disconnected_submaps;
  j["pieces"] = Json::array();
  for (const TrajectoryPiece& piece : s.pieces) {
    const auto& evaluation = piece.evaluation;
    const bool has_ate = evaluation && evaluation->ate;
    j["pieces"].push_back(
        {{"first_frame", piece.first_frame},
         {"last_frame", piece.last_frame},
         {"frames", piece.frames},
         {"ate_rmse_m", has_ate ? Json(evaluation->ate->translation_m.rmse) : Json()}});
  }
  j["backend_waits"] = s.loops.waits;
  j["keyframe_views_removed"] = s.loops.removed_views;
  j["session_waits"] = s.session_waits;
  j["localization"] = nullptr;
  if (const auto& found = s.localization) {
    j["localization"] = {{"frames", found->frames},
                         {"relocalisations", found->relocalisations},
                         {"longest_loss_s", found->longest_loss_s},
                         {"median_sigma_m", found->median_sigma_m},
                         {"median_sigma_rad", found->median_sigma_rad}};
  }
  j["prior_poses"] = nullptr;
  if (const auto& prior = s.prior_poses) {
    Json rejected = Json::array();
    for (const auto& [from_s, to_s] : prior->rejected) rejected.push_back({from_s, to_s});
    j["prior_poses"] = {{"frames_compared", prior->frames_compared},
                        {"frames_without", prior->frames_without},
                        {"frames_used", prior->frames_used},
                        {"frames_rejected", prior->frames_rejected},
                        {"rejected_s", rejected},
                        {"body_from_camera", ToJson(prior->body_from_camera)},
                        {"sigma_m", prior->sigma_m},
                        {"sigma_rad", prior->sigma_rad}};
  }
  j["calibration_warning"] = s.calibration_warning.empty() ? Json() : Json(s.calibration_warning);
  j["calibrations"] = Json::array();
  for (const CalibrationRecord& record : s.calibrations)
    j["calibrations"].push_back(ToJson(record));
  j["depth_noise"] = ToJson(s.noise);
  j["refinement"] = nullptr;
  if (s.refinement) {
    j["refinement"] = ToJson(s.refinement->record);
    j["refinement"]["held_out_gain"] = s.refinement->held_out_gain;
    j["refinement"]["is_applied"] = s.refinement->is_applied;
    j["refinement"]["rounds"] = s.refinement->record.summary.rounds.size();
    j["refinement"]["seconds"] = s.refinement->seconds;
  }
  j["input_points"] = s.input_points;
  j["input_points_valid"] = s.input_points_valid;
  j["surfels_updated"] = s.updated;
  j["surfels_added"] = s.added;
  j["surfels_removed"] = s.removed;
  j["surfels_refused"] = s.refused;
  j["surfels_merged_by_loops"] = s.merged_duplicates;
  j["map_points"] = s.map_points;
  j["compression_ratio"] = s.compression_ratio;
  j["match_ratio"] = {{"last", s.match_ratio_last}, {"median", s.match_ratio_median}};
  j["sensor_latency_s"] = s.sensor_latency_s;
  SetErrors(s, &j);
  j["gravity"] = {{"up_in_world", nullptr}, {"reason", s.gravity_unknown}};
  if (s.gravity) {
    j["gravity"] = {{"up_in_world", UpIn(s.gravity->upright_from_world)},
                    {"sigma_deg", s.gravity->sigma_rad / kRadPerDeg},
                    {"source", "floor and walls of the map"},
                    {"upright_from_world", ToJson(s.gravity->upright_from_world)}};
  }
  if (s.imu) j["imu"] = ToJson(*s.imu);
  if (!s.gravity && s.imu && s.imu->up_in_world) {
    j["gravity"] = {{"up_in_world", NumbersOf(*s.imu->up_in_world)},
                    {"sigma_deg", s.imu->up_sigma_rad / kRadPerDeg},
                    {"source", "accelerometer"},
                    {"upright_from_world", nullptr}};
  }
  j["total_s"] = s.total_s;
  j["final_map_s"] = s.final_map_s ? Json(*s.final_map_s) : Json();
  j["frame_ms"] = ToJson(s.frame);
  j["pose_latency_ms"] = options.OffersFrames() ? ToJson(s.pose_latency) : Json();
  j["latency_ms"] = options.OffersFrames() ? ToJson(s.latency) : Json();
  j["stage_ms"] = Json::object();
  for (const StageStatistics& stage : s.stages) {
    j["stage_ms"][stage.name] = ToJson(stage.times);
    j["stage_ms"][stage.name]["share"] = stage.share;
  }
  j["peak_rss_bytes"] = s.peak_rss_bytes;
  j["residual"] = options.slam.icp.residual;
  j["association"] = options.slam.icp.association;
  j["solver"] = options.slam.icp.solver;
  SlamRunOptions recorded = options;
  j["options"] = RecordedValues(TableOf(&recorded));
  j["digest"] = s.digest;
  WriteJson(j, path);
}

std::map<std::string, std::string> RecordedFlags(const std::string& summary_json) {
  const Json json = ReadJson(summary_json);
  if (!json.contains("options") || !json["options"].is_object()) {
    throw InputError(summary_json + " is not the summary.json of a run: it has no key 'options'");
  }
  std::map<std::string, std::string> flags;
  for (const auto& [name, value] : json["options"].items()) {
    if (!value.is_string()) {
      throw InputError(
          Concat(summary_json, ": options: ", name, " is ", value.dump(), ", must be a string"));
    }
    flags[PresentName(name)] = value;
  }
  return flags;
}

void WritePosesJson(const RunPoses& run, const std::string& path) {
  Json j;
  j["camera"] = CameraToJson(run.camera);
  j["calibration"] = run.found.calibration ? ToJson(*run.found.calibration) : Json();
  j["color_latency_s"] = run.found.color_latency_s;
  j["truth"] = nullptr;
  j["errors_m"] = nullptr;
  if (run.evaluation && run.evaluation->ate) {
    const Rigid3d estimated_from_true = run.evaluation->ate->alignment.target_from_source.Inverse();
    j["truth"] = TruthOf(run, estimated_from_true);
    j["errors_m"] = ErrorsOf(run, estimated_from_true);
  }
  j["largest_piece"] = FramesOfLargestPiece(run);
  j["up"] = nullptr;
  if (run.upright) j["up"] = UpIn(run.upright->upright_from_world);
  j["views"] = ToJson<KeptViews>(run.views);
  j["thumbnails"] = ToJson<Thumbnails>(run.thumbnails);
  j["keyframes"] = ToJson(run.keyframes);
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << '{';
    for (const auto& [key, value] : j.items()) {
      out << Json(key) << ':' << value.dump(-1, ' ', false, Json::error_handler_t::replace) << ',';
    }
    out << "\"poses\":";
    WritePoses(run, out);
    out << "}\n";
  });
}

void WriteLoopsCsv(const std::vector<LoopRecord>& loops, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << kLoopColumns << '\n';
    for (const LoopRecord& loop : loops) {
      if (loop.is_kept) continue;
      WriteColumns(loop, ReasonOf(loop), file);
      file << '\n';
    }
  });
}

}  // namespace surfit
