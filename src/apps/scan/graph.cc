#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <tuple>
#include <utility>

#include "apps/scan/job_files.h"
#include "apps/scan/link_file.h"
#include "apps/scan/link_truth.h"
#include "apps/scan/scan_graph.h"
#include "apps/scan/tile_files.h"
#include "finishing/posed_sequence.h"
#include "io/files/output_folder.h"
#include "output/output_files.h"
#include "output/pictures/pictures.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/io/trajectory_files.h"

namespace surfit {
namespace {

std::vector<std::optional<RunPlaces>> AllPlaces(const std::string& scan, const ScanPlan& plan) {
  std::vector<std::optional<RunPlaces>> all;
  for (const ScanFragment& fragment : plan.fragments) {
    all.push_back(PlacesOf(scan, fragment, PlacesPart::kFeatures));
    if (!all.back()) continue;
    for (Keyframe& keyframe : all.back()->keyframes) keyframe.view = PlaceView();
  }
  return all;
}

class LinkReader {
 public:
  LinkReader(const ScanPlan& plan, const std::vector<std::optional<RunPlaces>>& places) {
    for (std::size_t i = 0; i < plan.fragments.size(); ++i) {
      Fragment& fragment = fragments_[plan.fragments[i].name];
      fragment.position = i;
      if (!places[i]) continue;
      for (std::size_t k = 0; k < places[i]->keyframes.size(); ++k) {
        fragment.keyframes[places[i]->keyframes[k].frame_index] = static_cast<int>(k);
      }
    }
  }

  std::vector<GraphLink> Read(const std::vector<std::string>& paths) const {
    std::vector<GraphLink> links;
    for (const std::string& path : paths) {
      const FragmentLinks pair = ReadLinks(path);
      for (const ScanLink& link : pair.links) {
        if (!link.verdict.accepted()) continue;
        GraphLink accepted;
        std::tie(accepted.source, accepted.source_keyframe) =
            Find(path, pair.source, link.source_frame);
        std::tie(accepted.target, accepted.target_keyframe) =
            Find(path, pair.target, link.target_frame);
        accepted.target_from_source = link.verdict.target_from_source;
        accepted.information = link.verdict.information;
        accepted.overlap_ratio = link.verdict.overlap_ratio;
        links.push_back(accepted);
      }
    }
    return links;
  }

 private:
  struct Fragment {
    std::size_t position = 0;
    std::map<int, int> keyframes;  // keyframe index by frame index
  };

  std::pair<std::size_t, int> Find(const std::string& path, const std::string& name,
                                   int frame) const {
    const auto fragment = fragments_.find(name);
    ThrowIf(fragment == fragments_.end(), path, ": fragment '", name, "' is not in the plan");
    const auto keyframe = fragment->second.keyframes.find(frame);
    ThrowIf(keyframe == fragment->second.keyframes.end(), path, ": frame ", frame,
            " is not a keyframe of fragment ", name);
    return {fragment->second.position, keyframe->second};
  }

  std::map<std::string, Fragment> fragments_;
};

class TileFinder {
 public:
  TileFinder(double tile_m, std::size_t recordings) : tile_m_(tile_m), recordings_(recordings) {}

  void Add(const RunPlaces& places, const std::vector<Rigid3d>& world_from_camera,
           std::size_t recording) {
    for (std::size_t k = 0; k < places.keyframes.size(); ++k) {
      const int first =
          k > 0 ? places.keyframes[k - 1].frame_index + 1 : places.frames.front().index;
      const int last = k + 1 < places.keyframes.size() ? places.keyframes[k + 1].frame_index - 1
                                                       : places.frames.back().index;
      for (const auto& [cell, count] : Seen(places.keyframes[k].view, world_from_camera[k])) {
        Tile& tile = tiles_[cell];
        tile.points += count;
        tile.frames.resize(recordings_);
        tile.frames[recording].push_back({first, last});
      }
    }
  }

  std::vector<ScanTile> Tiles() const {
    std::vector<ScanTile> tiles;
    for (const auto& [cell, found] : tiles_) {
      if (found.points < kLeastPoints) continue;
      ScanTile tile;
      tile.name = Concat(cell[0], "_", cell[1], "_", cell[2]);
      const Eigen::Vector3d corner = tile_m_ * Eigen::Vector3d(cell[0], cell[1], cell[2]);
      tile.box = {corner.cast<float>(),
                  (corner + Eigen::Vector3d::Constant(tile_m_)).cast<float>()};
      for (const std::vector<FrameRange>& ranges : found.frames) {
        tile.frames.push_back(Merged(ranges));
      }
      tiles.push_back(tile);
    }
    return tiles;
  }

 private:
  using Cell = std::array<int, 3>;
  struct Tile {
    int points = 0;
    std::vector<std::vector<FrameRange>> frames;  // per recording
  };
  static constexpr int kStep = 4;          // pixels
  static constexpr int kLeastPoints = 10;  // fewer points are noise

  std::map<Cell, int> Seen(const PlaceView& view, const Rigid3d& world_from_camera) const {
    std::map<Cell, int> seen;
    const PinholeCamera& camera = view.camera;
    for (int v = 0; v < view.depth.height(); v += kStep) {
      for (int u = 0; u < view.depth.width(); u += kStep) {
        const double z = view.depth(u, v) / PlaceView::kDepthUnitsPerMetre;
        if (!(z > 0)) continue;
        const Eigen::Vector3d point =
            world_from_camera *
            Eigen::Vector3d((u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z);
        ++seen[{static_cast<int>(std::floor(point.x() / tile_m_)),
                static_cast<int>(std::floor(point.y() / tile_m_)),
                static_cast<int>(std::floor(point.z() / tile_m_))}];
      }
    }
    return seen;
  }

  static std::vector<FrameRange> Merged(std::vector<FrameRange> ranges) {
    std::sort(ranges.begin(), ranges.end(),
              [](const FrameRange& a, const FrameRange& b) { return a.first < b.first; });
    std::vector<FrameRange> merged;
    for (const FrameRange& range : ranges) {
      if (!merged.empty() && range.first <= merged.back().last + 1) {
        merged.back().last = std::max(merged.back().last, range.last);
      } else {
        merged.push_back(range);
      }
    }
    return merged;
  }

  double tile_m_;
  std::size_t recordings_;
  std::map<Cell, Tile> tiles_;
};

std::vector<ScanTile> FindTiles(const std::string& scan, const ScanPlan& plan,
                                const ScanGraph& graph, double tile_m) {
  TileFinder finder(tile_m, plan.recordings.size());
  for (std::size_t i = 0; i < plan.fragments.size(); ++i) {
    if (!graph.fragments()[i] || graph.IsDisconnected(i)) continue;
    const auto places = PlacesOf(scan, plan.fragments[i], PlacesPart::kAll);
    if (!places) continue;
    finder.Add(*places, graph.fragments()[i]->solved,
               static_cast<std::size_t>(plan.fragments[i].recording));
  }
  return finder.Tiles();
}

struct RecordingResult {
  std::vector<PosedFrame> frames;
  SequenceInfo info;
  Trajectory trajectory;
  std::vector<MatchedPose> matched;
  std::optional<AbsoluteTrajectoryError> ate;

  RecordingResult(std::vector<PosedFrame> of_frames, const SequenceOptions& sequence)
      : frames(std::move(of_frames)), info(OpenSequence(sequence)->info()) {
    for (const PosedFrame& frame : frames) {
      trajectory.push_back({frame.stamp_s, frame.world_from_camera});
    }
    if (!info.ground_truth.empty()) {
      matched = MatchPoses(info.ground_truth, trajectory, MatchOptions());
    }
    ate = ComputeAbsoluteTrajectoryError(matched);
  }

  void Write(const std::string& folder, std::size_t recording) const {
    const auto path = [&](const char* name, const char* ending) {
      return Concat(folder, "/", RecordingFile(name, recording, ending));
    };
    Trajectory shown = trajectory, given = trajectory;
    for (StampedPose& pose : shown) {
      if (ate) pose.world_from_camera = ate->alignment.target_from_source * pose.world_from_camera;
    }
    for (StampedPose& pose : given) {
      if (info.mirrored) pose.world_from_camera = Mirrored(pose.world_from_camera);
    }
    WriteTrajectoryPicture(shown, info.ground_truth, path("trajectory", "png"));
    WriteFramePoses(frames, path("poses", "txt"));
    WriteTumTrajectory(given, path("trajectory", "txt"));
  }
};

Json ToJson(const ScanPlan& plan, const std::vector<RecordingResult>& results) {
  Json recordings = Json::array();
  for (std::size_t r = 0; r < results.size(); ++r) {
    const auto& ate = results[r].ate;
    recordings.push_back({{"sequence", plan.recordings[r].path},
                          {"frames_total", results[r].info.frame_count},
                          {"frames", results[r].frames.size()},
                          {"ate_rmse_m", ate ? Json(ate->translation_m.rmse) : Json(nullptr)}});
  }
  return recordings;
}

// Error of a link against the ground truth. std::nullopt for links between two recordings, whose
// ground truths may have different world frames.
std::optional<PoseError> ErrorOf(const ScanPlan& plan, const ScanGraph& graph,
                                 const std::vector<RecordingResult>& results,
                                 const GraphLink& link) {
  const int recording = plan.fragments[link.source].recording;
  if (plan.fragments[link.target].recording != recording) return std::nullopt;
  return ErrorOfLink(results[recording].info.ground_truth, graph.fragments()[link.source]->places,
                     link.source_keyframe, graph.fragments()[link.target]->places,
                     link.target_keyframe, link.target_from_source);
}

void FindWorst(const ScanPlan& plan, const ScanGraph& graph,
               const std::vector<RecordingResult>& results, GraphResult* result) {
  for (const GraphLink& link : graph.links()) {
    if (!link.is_rejected) UpdateMaximum(ErrorOf(plan, graph, results, link), &result->worst_link);
  }
  for (std::size_t i = 0; i < plan.fragments.size(); ++i) {
    const std::optional<GraphFragment>& fragment = graph.fragments()[i];
    if (!fragment) continue;
    const Trajectory& truth = results[plan.fragments[i].recording].info.ground_truth;
    for (const PoseGraphEdge& edge : fragment->kept_loops) {
      UpdateMaximum(ErrorOfLink(truth, fragment->places, static_cast<int>(edge.b), fragment->places,
                                static_cast<int>(edge.a), edge.a_from_b),
                    &result->worst_loop);
    }
  }
}

Json ToJson(const std::optional<PoseError>& error) {
  if (!error) return nullptr;
  return {{"translation_m", error->translation_m}, {"rotation_deg", error->rotation_deg}};
}

Json ToJson(const ScanPlan& plan, const ScanGraph& graph,
            const std::vector<RecordingResult>& results, const GraphResult& result) {
  Json fragments = Json::array();
  for (std::size_t i = 0; i < plan.fragments.size(); ++i) {
    const auto& fragment = graph.fragments()[i];
    fragments.push_back({{"name", plan.fragments[i].name},
                         {"recording", plan.fragments[i].recording},
                         {"state", !fragment                 ? "missing"
                                   : graph.IsDisconnected(i) ? "disconnected"
                                                             : "joined"},
                         {"frames", fragment ? fragment->places.frames.size() : 0},
                         {"keyframes", fragment ? fragment->places.keyframes.size() : 0}});
  }
  Json cuts = Json::array();
  for (const FragmentCut& cut : graph.cuts()) {
    cuts.push_back({{"fragment", plan.fragments[cut.fragment].name},
                    {"before_frame", cut.before},
                    {"after_frame", cut.after},
                    {"links", cut.links}});
  }
  Json links = Json::array();
  for (const GraphLink& link : graph.links()) {
    const auto frame = [&](std::size_t fragment, int keyframe) {
      return graph.fragments()[fragment]->places.keyframes[keyframe].frame_index;
    };
    const std::optional<Rigid3d> residual = graph.Residual(link);
    links.push_back(
        {{"source", plan.fragments[link.source].name},
         {"target", plan.fragments[link.target].name},
         {"source_frame", frame(link.source, link.source_keyframe)},
         {"target_frame", frame(link.target, link.target_keyframe)},
         {"left_out", link.is_rejected},
         {"residual_m", residual ? Json(residual->translation.norm()) : Json(nullptr)},
         {"residual_rad", residual ? Json(RotationAngle(residual->rotation)) : Json(nullptr)},
         {"error", ToJson(ErrorOf(plan, graph, results, link))}});
  }
  return {{"frames", result.frames},
          {"frames_total", result.frames_total},
          {"keyframes", result.keyframes},
          {"links_accepted", result.links_accepted},
          {"links_rejected", result.links_rejected},
          {"ate_rmse_m", result.ate_rmse_m ? Json(*result.ate_rmse_m) : Json(nullptr)},
          {"worst_link", ToJson(result.worst_link)},
          {"worst_loop", ToJson(result.worst_loop)},
          {"fragments", fragments},
          {"cuts", cuts},
          {"links", links}};
}

void WarnOfCuts(const ScanPlan& plan, const ScanGraph& graph) {
  for (const FragmentCut& cut : graph.cuts()) {
    LOG(WARNING) << "fragment " << plan.fragments[cut.fragment].name
                 << " is cut between the frames " << cut.before << " and " << cut.after
                 << ": its tracked motion contradicts " << cut.links
                 << " verified links, and poses between these frames may be wrong";
  }
}

// Paths of the link files of current candidates. Link files of an earlier plan are excluded.
std::vector<std::string> LinkFiles(const std::string& scan) {
  std::vector<std::string> paths;
  for (const std::string& pair : FilesIn(scan + "/candidates", ".json")) {
    const std::string path = scan + "/links/" + std::filesystem::path(pair).filename().string();
    if (std::filesystem::exists(path)) paths.push_back(path);
  }
  return paths;
}

// Files of earlier graph jobs.
std::vector<std::string> GraphFiles(const std::string& folder) {
  std::vector<std::string> names = {"graph.json", "tiles.json"};
  for (const char* const ending : {".txt", ".png"}) {
    for (const std::string& path : FilesIn(folder, ending)) {
      const std::string name = std::filesystem::path(path).filename();
      if (name.rfind("trajectory", 0) == 0 || name.rfind("poses", 0) == 0) names.push_back(name);
    }
  }
  return names;
}

}  // namespace

GraphResult BuildScanGraph(const GraphOptions& options) {
  Validate(options);
  const ScanPlan plan = ReadScanPlan(options.scan);
  std::vector<std::optional<RunPlaces>> places = AllPlaces(options.scan, plan);
  std::vector<GraphLink> links = LinkReader(plan, places).Read(LinkFiles(options.scan));
  std::vector<int> recordings;
  for (const ScanFragment& fragment : plan.fragments) recordings.push_back(fragment.recording);
  ScanGraph graph(std::move(places), std::move(recordings), std::move(links), plan.run.slam.loops);
  ThrowIf(!graph.Solve(), options.scan, ": the pose graph cannot be solved");
  const OutputFolder owned(options.output, GraphFiles(options.output));
  GraphResult result;
  for (std::size_t i = 0; i < plan.fragments.size(); ++i) {
    ++result.fragments;
    result.missing += !graph.fragments()[i];
    result.apart += graph.IsDisconnected(i);
    if (graph.fragments()[i]) {
      result.keyframes += static_cast<int>(graph.fragments()[i]->solved.size());
    }
  }
  WarnOfCuts(plan, graph);
  for (const GraphLink& link : graph.links()) {
    ++(link.is_rejected ? result.links_rejected : result.links_accepted);
  }
  std::vector<RecordingResult> results;
  std::vector<MatchedPose> matched;
  for (std::size_t r = 0; r < plan.recordings.size(); ++r) {
    const RecordingResult& of_recording =
        results.emplace_back(graph.Frames(static_cast<int>(r)), plan.recordings[r]);
    of_recording.Write(options.output, r);
    result.frames += static_cast<int>(of_recording.frames.size());
    result.frames_total += of_recording.info.frame_count;
    matched.insert(matched.end(), of_recording.matched.begin(), of_recording.matched.end());
  }
  if (const auto ate = ComputeAbsoluteTrajectoryError(matched)) {
    result.ate_rmse_m = ate->translation_m.rmse;
  }
  FindWorst(plan, graph, results, &result);
  const std::vector<ScanTile> tiles = FindTiles(options.scan, plan, graph, plan.tile_m);
  result.tiles = static_cast<int>(tiles.size());
  WriteTiles(tiles, options.output + "/tiles.json");
  Json json = ToJson(plan, graph, results, result);
  json["recordings"] = ToJson(plan, results);
  WriteJson(json, options.output + "/graph.json");
  return result;
}

}  // namespace surfit
