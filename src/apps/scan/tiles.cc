#include <algorithm>
#include <fstream>
#include <iomanip>
#include <map>
#include <set>
#include <sstream>

#include "apps/scan/scan_jobs.h"
#include "apps/scan/scan_plan.h"
#include "apps/scan/tile_files.h"
#include "finishing/final_map.h"
#include "output/output_files.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/io/point_cloud.h"

namespace surfit {

std::vector<int> FirstFrames(const ScanPlan& plan) {
  std::vector<int> ends(plan.recordings.size(), 0);
  for (const ScanFragment& fragment : plan.fragments) {
    ends[fragment.recording] = std::max(ends[fragment.recording], fragment.last + 1);
  }
  std::vector<int> first = {0};
  for (const int end : ends) first.push_back(first.back() + end);
  first.pop_back();
  return first;
}

std::string RecordingFile(const std::string& name, std::size_t recording,
                          const std::string& ending) {
  return Concat(name, "_", recording, ".", ending);
}

void WriteTiles(const std::vector<ScanTile>& tiles, const std::string& path) {
  Json json = Json::array();
  for (const ScanTile& tile : tiles) {
    Json frames = Json::array();
    for (const std::vector<FrameRange>& ranges : tile.frames) {
      Json of_recording = Json::array();
      for (const FrameRange& range : ranges) of_recording.push_back({range.first, range.last});
      frames.push_back(of_recording);
    }
    const Eigen::Vector3f &from = tile.box.min(), &to = tile.box.max();
    json.push_back({{"name", tile.name},
                    {"min", {from.x(), from.y(), from.z()}},
                    {"max", {to.x(), to.y(), to.z()}},
                    {"frames", frames}});
  }
  WriteJson({{"tiles", json}}, path, -1);
}

std::vector<ScanTile> ReadTiles(const std::string& path) {
  const Json json = ReadJson(path);
  std::vector<ScanTile> tiles;
  try {
    for (const Json& entry : json.at("tiles")) {
      ScanTile tile;
      entry.at("name").get_to(tile.name);
      for (int i = 0; i < 3; ++i) {
        tile.box.min()[i] = entry.at("min").at(i);
        tile.box.max()[i] = entry.at("max").at(i);
      }
      for (const Json& ranges : entry.at("frames")) {
        std::vector<FrameRange>& of_recording = tile.frames.emplace_back();
        for (const Json& range : ranges) of_recording.push_back({range.at(0), range.at(1)});
      }
      tiles.push_back(tile);
    }
  } catch (const Json::exception& error) {
    throw InputError(path, ": invalid tiles of a scan: ", error.what());
  }
  return tiles;
}

void WriteFramePoses(const std::vector<PosedFrame>& frames, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& file) {
    file << "# index stamp tx ty tz qx qy qz qw, camera to world, metres\n"
         << std::setprecision(17);
    for (const PosedFrame& frame : frames) {
      const Eigen::Vector3d& t = frame.world_from_camera.translation;
      const Eigen::Quaterniond& q = frame.world_from_camera.rotation;
      file << frame.index << ' ' << frame.stamp_s << ' ' << t.x() << ' ' << t.y() << ' ' << t.z()
           << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w() << '\n';
    }
  });
}

std::vector<PosedFrame> ReadFramePoses(const std::string& path) {
  std::ifstream file(path);
  ThrowIf(!file, path, ": cannot be read");
  std::vector<PosedFrame> frames;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    PosedFrame frame;
    Eigen::Vector3d& t = frame.world_from_camera.translation;
    Eigen::Quaterniond& q = frame.world_from_camera.rotation;
    std::istringstream text(line);
    text >> frame.index >> frame.stamp_s >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >>
        q.w();
    ThrowIf(!text || (!frames.empty() && frame.index <= frames.back().index), path, ":", number,
            ": invalid frame pose, or index not ascending");
    frames.push_back(frame);
  }
  return frames;
}

namespace {

class PosedRecordings {
 public:
  PosedRecordings(const ScanPlan& plan, const std::string& scan)
      : plan_(plan), trajectories_(plan.recordings.size()), indices_(plan.recordings.size()) {
    for (std::size_t r = 0; r < plan.recordings.size(); ++r) {
      const std::string poses = Concat(scan, "/graph/", RecordingFile("poses", r, "txt"));
      for (const PosedFrame& frame : ReadFramePoses(poses)) {
        trajectories_[r].push_back({frame.stamp_s, frame.world_from_camera});
        indices_[r].push_back(frame.index);
      }
      known_.push_back({plan.recordings[r], plan.run.slam, trajectories_[r], indices_[r], all_stay_,
                        nothing_moves_, EstimatedSensor()});
    }
  }
  PosedRecordings(const PosedRecordings&) = delete;

  std::vector<MapSource> Of(const ScanTile& tile) const {
    const std::vector<int> first = FirstFrames(plan_);
    std::vector<MapSource> sources;
    for (std::size_t r = 0; r < known_.size() && r < tile.frames.size(); ++r) {
      if (!tile.frames[r].empty()) sources.push_back({known_[r], tile.frames[r], first[r]});
    }
    return sources;
  }

 private:
  const ScanPlan& plan_;
  std::vector<Trajectory> trajectories_;
  std::vector<std::vector<int>> indices_;
  std::set<int> all_stay_;
  std::map<int, Image<std::uint8_t>> nothing_moves_;
  std::vector<PosedSequence> known_;  // refers to the members above
};

}  // namespace

std::size_t FuseTile(const TileOptions& options, const std::atomic<bool>& interrupted,
                     const std::function<void(int frames)>& progress) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  const ScanPlan plan = ReadScanPlan(options.scan);
  const std::string tiles_json = options.scan + "/graph/tiles.json";
  const std::vector<ScanTile> tiles = ReadTiles(tiles_json);
  const auto tile = std::find_if(tiles.begin(), tiles.end(),
                                 [&](const ScanTile& each) { return each.name == options.tile; });
  ThrowIf(tile == tiles.end(), tiles_json, ": has no tile '", options.tile, "'");
  const PosedRecordings recordings(plan, options.scan);
  constexpr float kMargin_m = 0.2f;  // fused as well, for complete borders
  const MapPart part = {tile->box, kMargin_m, recordings.Of(*tile)};
  ThrowIf(part.sources.empty(), tiles_json, ": tile ", tile->name,
          " is not observed by any recording");
  const auto map = FusePart(part, interrupted, [&](int frames, std::size_t) { progress(frames); });
  if (!map) throw InputError("interrupted: ", options.output, " is not written");
  WriteSurfelPly(*map, options.output);
  return map->size();
}

}  // namespace surfit
