#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "apps/scan/job_files.h"
#include "apps/scan/link_file.h"
#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "apps/scan/tile_files.h"
#include "browser/page.h"
#include "core/files.h"
#include "output/output_files.h"
#include "output/pictures/pictures.h"
#include "run/results/result_files.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/point_cloud.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {
namespace {

namespace fs = std::filesystem;

std::vector<JobReceipt> ReadReceipts(const std::string& scan, const std::set<std::string>& jobs) {
  std::vector<JobReceipt> receipts;
  for (const std::string& path : FilesIn(scan + "/jobs", ".json")) {
    if (jobs.count(fs::path(path).stem()) > 0) receipts.push_back(ReadReceipt(path));
  }
  return receipts;
}

std::string Hex(const Fnv1a& hash) {
  std::ostringstream text;
  text << std::hex << std::setw(16) << std::setfill('0') << hash.hash();
  return text.str();
}

// Uniform sample of the map with at most about kMaxSurfels surfels. Larger radii preserve the
// covered area.
SurfelMap ThinnedMap(const std::vector<std::string>& paths) {
  constexpr std::size_t kMaxSurfels = 2000000;
  constexpr std::uintmax_t kBytesOfSurfel = 43;  // record size of WriteSurfelPly()
  std::uintmax_t count = 0;
  for (const std::string& path : paths) count += fs::file_size(path) / kBytesOfSurfel;
  const std::size_t step = count / kMaxSurfels + 1;
  const float growth = std::sqrt(static_cast<float>(step));
  SurfelMap map;
  for (const std::string& path : paths) {
    std::vector<Surfel> surfels = ReadSurfelPly(path), kept;
    for (std::size_t i = 0; i < surfels.size(); i += step) {
      surfels[i].radius_m *= growth;
      kept.push_back(surfels[i]);
    }
    map.Append(kept);
  }
  return map;
}

ScannedRecording RecordingFrom(const Json& json) {
  ScannedRecording recording;
  json.at("sequence").get_to(recording.sequence);
  json.at("frames_total").get_to(recording.frames_total);
  json.at("frames").get_to(recording.frames);
  if (!json.at("ate_rmse_m").is_null()) recording.ate_rmse_m = json.at("ate_rmse_m");
  return recording;
}

class ScanReporter {
 public:
  explicit ScanReporter(const std::string& scan) : scan_(scan), plan_(ReadScanPlan(scan)) {
    std::set<std::string> jobs = {"candidates", "graph"};
    for (std::size_t r = 0; r < plan_.recordings.size(); ++r) jobs.insert(Concat("camera_", r));
    for (const ScanFragment& fragment : plan_.fragments) jobs.insert("fragment_" + fragment.name);
    for (const std::string& pair : FilesIn(scan + "/candidates", ".json")) {
      const std::string name = fs::path(pair).stem();
      pairs_.push_back(name);
      jobs.insert("link_" + name);
    }
    if (fs::exists(scan + "/graph/graph.json")) {
      graph_ = ReadJson(scan + "/graph/graph.json");
      for (const ScanTile& tile : ReadTiles(scan + "/graph/tiles.json")) {
        tiles_.insert(tile.name);
        jobs.insert("tile_" + tile.name);
      }
    }
    receipts_ = ReadReceipts(scan, jobs);
  }

  ScanSummary Run() {
    RemoveFormerFiles();
    Fnv1a digest;
    ScanSummary summary;
    summary.fragments = static_cast<int>(plan_.fragments.size());
    if (!graph_.is_null()) {
      for (std::size_t r = 0; r < plan_.recordings.size(); ++r) {
        const std::string trajectory = ReadFile(GraphFile("trajectory", r, "txt"));
        digest.Add(trajectory.data(), trajectory.size());
        WriteFileAtomically(Concat(scan_, "/", TrajectoryName(r)),
                            [&](std::ostream& file) { file << trajectory; });
        summary.recordings.push_back(RecordingFrom(graph_.at("recordings").at(r)));
      }
      graph_.at("frames_total").get_to(summary.frames_total);
      graph_.at("frames").get_to(summary.frames);
      graph_.at("links_accepted").get_to(summary.links_accepted);
      if (!graph_.at("ate_rmse_m").is_null()) summary.ate_rmse_m = graph_.at("ate_rmse_m");
    }
    const std::vector<std::string> paths = FilesIn(scan_ + "/tiles", ".ply");
    summary.tiles = static_cast<int>(paths.size());
    for (const std::string& path : paths) {
      const std::string bytes = ReadFile(path);
      digest.Add(bytes.data(), bytes.size());
    }
    summary.digest = Hex(digest);
    for (const JobReceipt& receipt : receipts_) {
      if (receipt.exit != 0) summary.failed.push_back(receipt.job + ": " + receipt.error);
    }
    if (DrawsMap()) {
      const SurfelMap map = ThinnedMap(paths);
      const Trajectory path = Path();
      WriteMapPictures(map, path, scan_, FindUpright(ReliableSurfels(map), path).world);
    }
    WritePage(summary);
    WriteSummary(summary);
    return summary;
  }

 private:
  void RemoveFormerFiles() const {
    std::set<std::string> trajectories;
    for (std::size_t r = 0; r < plan_.recordings.size(); ++r)
      trajectories.insert(TrajectoryName(r));
    for (const std::string& path : FilesIn(scan_, ".txt")) {
      const std::string name = fs::path(path).filename();
      if (name.rfind("trajectory", 0) == 0 && trajectories.count(name) == 0) fs::remove(path);
    }
    for (const std::string& path : FilesIn(scan_ + "/tiles", ".ply")) {
      if (tiles_.count(fs::path(path).stem()) == 0) fs::remove(path);
    }
  }

  std::string GraphFile(const std::string& name, std::size_t recording,
                        const std::string& ending) const {
    return Concat(scan_, "/graph/", RecordingFile(name, recording, ending));
  }

  std::string TrajectoryName(std::size_t recording) const {
    if (plan_.recordings.size() == 1) return "trajectory.txt";
    return RecordingFile("trajectory", recording, "txt");
  }

  Trajectory Path() const {
    Trajectory path;
    for (std::size_t r = 0; r < plan_.recordings.size(); ++r) {
      for (const PosedFrame& frame : ReadFramePoses(GraphFile("poses", r, "txt"))) {
        path.push_back({frame.stamp_s, frame.world_from_camera});
      }
    }
    return path;
  }

  void WriteSummary(const ScanSummary& summary) const {
    WriteJson({{"digest", summary.digest},
               {"ate_rmse_m", summary.ate_rmse_m ? Json(*summary.ate_rmse_m) : Json(nullptr)},
               {"frames_total", summary.frames_total},
               {"frames", summary.frames},
               {"fragments", summary.fragments},
               {"links_accepted", summary.links_accepted},
               {"links_rejected", graph_.is_null() ? Json(0) : graph_.at("links_rejected")},
               {"worst_link", graph_.is_null() ? Json(nullptr) : graph_.at("worst_link")},
               {"worst_loop", graph_.is_null() ? Json(nullptr) : graph_.at("worst_loop")},
               {"tiles", summary.tiles},
               {"recordings", graph_.is_null() ? Json::array() : graph_.at("recordings")},
               {"failed", summary.failed}},
              scan_ + "/summary.json");
  }

  void WritePage(const ScanSummary& summary) const {
    PlainPage page;
    page.Paragraph(Concat(summary.frames, " of ", summary.frames_total, " frames have a pose. ",
                          summary.fragments, " fragments, ", summary.links_accepted, " links, ",
                          summary.tiles, " tiles."));
    if (summary.ate_rmse_m) {
      page.Paragraph(
          Concat("ATE: ", Fixed(1000 * *summary.ate_rmse_m, 1), " mm",
                 plan_.recordings.size() > 1 ? ", with one alignment of all recordings" : ""));
    }
    AddWorst("link between fragments", "worst_link", &page);
    AddWorst("loop within a fragment", "worst_loop", &page);
    page.Section("Failed jobs");
    if (summary.failed.empty()) page.Paragraph("None.");
    for (const std::string& failed : summary.failed) page.Paragraph(failed);
    if (!graph_.is_null()) {
      page.Section("Map and path");
      if (DrawsMap()) page.Picture("map_color.png");
      for (std::size_t r = 0; r < plan_.recordings.size(); ++r) {
        page.Picture("graph/" + RecordingFile("trajectory", r, "png"));
      }
    }
    if (plan_.recordings.size() > 1) AddRecordings(summary, &page);
    AddFragments(&page);
    AddLinks(&page);
    AddCosts(&page);
    const std::size_t others = plan_.recordings.size() - 1;
    page.Write(Concat("Scan of ", plan_.recordings.front().path,
                      others > 0 ? Concat(" and ", others, " more") : ""),
               scan_ + "/report.html");
  }

  bool DrawsMap() const { return plan_.pictures && !graph_.is_null(); }

  static void AddRecordings(const ScanSummary& summary, PlainPage* page) {
    std::vector<std::vector<PlainPage::Cell>> rows = {
        {"recording", "sequence", "frames", "with a pose", "ATE (mm), separate alignment"}};
    for (std::size_t r = 0; r < summary.recordings.size(); ++r) {
      const ScannedRecording& recording = summary.recordings[r];
      rows.push_back({Concat(r), recording.sequence, Concat(recording.frames_total),
                      Concat(recording.frames),
                      recording.ate_rmse_m ? Fixed(1000 * *recording.ate_rmse_m, 1) : ""});
    }
    page->Section("Recordings");
    page->Table(rows);
  }

  void AddWorst(const std::string& what, const std::string& key, PlainPage* page) const {
    if (graph_.is_null() || graph_.at(key).is_null()) return;
    const Json& worst = graph_.at(key);
    page->Paragraph(Concat("Largest ground-truth error of a ", what, ": ",
                           Fixed(1000 * worst.at("translation_m").get<double>(), 1), " mm, ",
                           Fixed(worst.at("rotation_deg"), 2), " degrees"));
  }

  void AddFragments(PlainPage* page) const {
    std::map<std::string, const JobReceipt*> receipts;
    for (const JobReceipt& receipt : receipts_) receipts[receipt.job] = &receipt;
    std::vector<std::vector<PlainPage::Cell>> rows = {{"fragment", "recording", "first", "last",
                                                       "state", "frames with a pose", "keyframes",
                                                       "s", "MB"}};
    for (std::size_t i = 0; i < plan_.fragments.size(); ++i) {
      const ScanFragment& fragment = plan_.fragments[i];
      std::vector<PlainPage::Cell> row = {fragment.name, Concat(fragment.recording),
                                          Concat(fragment.first), Concat(fragment.last)};
      if (graph_.is_null()) {
        row.insert(row.end(), 3, "");
      } else {
        const Json& json = graph_.at("fragments").at(i);
        row.emplace_back(json.at("state").get<std::string>());
        row.emplace_back(Concat(json.at("frames").get<int>()));
        row.emplace_back(Concat(json.at("keyframes").get<int>()));
      }
      const auto receipt = receipts.find("fragment_" + fragment.name);
      const bool known = receipt != receipts.end();
      row.emplace_back(known ? Fixed(receipt->second->seconds, 1) : "");
      row.emplace_back(known ? Fixed(receipt->second->peak_mb, 0) : "");
      rows.push_back(row);
    }
    page->Section("Fragments");
    page->Table(rows);
  }

  void AddLinks(PlainPage* page) const {
    struct Residuals {
      int accepted = 0, left_out = 0;
      double most_m = 0, most_rad = 0;
    };
    std::map<std::string, Residuals> residuals;
    if (!graph_.is_null()) {
      for (const Json& link : graph_.at("links")) {
        const std::string target = link.at("target"), source = link.at("source");
        Residuals& of_pair = residuals[Concat(target, "_", source)];
        ++(link.at("left_out").get<bool>() ? of_pair.left_out : of_pair.accepted);
        if (link.at("left_out").get<bool>() || link.at("residual_m").is_null()) continue;
        of_pair.most_m = std::max<double>(of_pair.most_m, link.at("residual_m"));
        of_pair.most_rad = std::max<double>(of_pair.most_rad, link.at("residual_rad"));
      }
    }
    std::vector<std::vector<PlainPage::Cell>> rows = {{"fragments", "verified", "accepted",
                                                       "outliers", "largest residual (mm)", "(deg)",
                                                       "rejected"}};
    for (const std::string& pair : pairs_) {
      const std::string path = Concat(scan_, "/links/", pair, ".json");
      if (!fs::exists(path)) continue;
      std::map<std::string, int> refused;
      const std::vector<ScanLink> links = ReadLinks(path).links;
      for (const ScanLink& link : links) {
        if (!link.verdict.accepted()) ++refused[ToString(link.verdict.reason)];
      }
      std::string reasons;
      for (const auto& [reason, count] : refused) {
        reasons += Concat(reasons.empty() ? "" : ", ", count, " ", reason);
      }
      const Residuals& fit = residuals[pair];
      rows.push_back({pair, Concat(links.size()), Concat(fit.accepted), Concat(fit.left_out),
                      fit.accepted > 0 ? Fixed(1000 * fit.most_m, 1) : "",
                      fit.accepted > 0 ? Fixed(fit.most_rad / kRadPerDeg, 2) : "", reasons});
    }
    page->Section("Links");
    page->Table(rows);
  }

  void AddCosts(PlainPage* page) const {
    struct Cost {
      int jobs = 0;
      double seconds = 0, longest = 0, peak_mb = 0;
    };
    std::map<std::string, Cost> costs;
    for (const JobReceipt& receipt : receipts_) {
      Cost& cost = costs[receipt.Rule()];
      ++cost.jobs;
      cost.seconds += receipt.seconds;
      cost.longest = std::max(cost.longest, receipt.seconds);
      cost.peak_mb = std::max(cost.peak_mb, receipt.peak_mb);
    }
    std::vector<std::vector<PlainPage::Cell>> rows = {
        {"rule", "jobs", "total (s)", "longest (s)", "peak (MB)"}};
    for (const auto& [rule, cost] : costs) {
      rows.push_back({rule, Concat(cost.jobs), Fixed(cost.seconds, 1), Fixed(cost.longest, 1),
                      Fixed(cost.peak_mb, 0)});
    }
    page->Section("Time and memory");
    page->Table(rows);
  }

  const std::string& scan_;
  ScanPlan plan_;
  std::vector<std::string> pairs_;  // fragment pairs: A_B
  Json graph_;                      // null: no graph
  std::set<std::string> tiles_;
  std::vector<JobReceipt> receipts_;
};

}  // namespace

ScanSummary ReadScanSummary(const std::string& scan) {
  const std::string path = scan + "/summary.json";
  const Json json = ReadJson(path);
  ScanSummary summary;
  try {
    json.at("digest").get_to(summary.digest);
    json.at("frames_total").get_to(summary.frames_total);
    json.at("frames").get_to(summary.frames);
    json.at("fragments").get_to(summary.fragments);
    json.at("links_accepted").get_to(summary.links_accepted);
    json.at("tiles").get_to(summary.tiles);
    if (!json.at("ate_rmse_m").is_null()) summary.ate_rmse_m = json.at("ate_rmse_m");
    for (const Json& recording : json.at("recordings")) {
      summary.recordings.push_back(RecordingFrom(recording));
    }
    json.at("failed").get_to(summary.failed);
  } catch (const Json::exception& error) {
    throw InputError(path, ": invalid scan summary: ", error.what());
  }
  return summary;
}

ScanSummary ReportScan(const ScanReportOptions& options) {
  Validate(options);
  try {
    return ScanReporter(options.scan).Run();
  } catch (const Json::exception& error) {
    throw InputError(options.scan, "/graph/graph.json: ", error.what());
  }
}

}  // namespace surfit
