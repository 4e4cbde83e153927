#include "output/report/report_data.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>

#include "core/files.h"
#include "output/output_files.h"
#include "output/report/compare_runs.h"
#include "surfit/core/error.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

std::size_t ReverseBits(std::size_t value, int bits) {
  std::size_t reversed = 0;
  for (int bit = 0; bit < bits; ++bit) reversed = reversed << 1 | (value >> bit & 1);
  return reversed;
}

// Indices 0, ..., count - 1, sorted by reversed bits (van der Corput sequence). Every prefix is
// evenly distributed.
std::vector<std::size_t> SpreadOrder(std::size_t count) {
  int bits = 0;
  while (std::size_t{1} << bits < count) ++bits;
  std::vector<std::size_t> order;
  order.reserve(count);
  for (std::size_t i = 0; i < std::size_t{1} << bits; ++i) {
    const std::size_t reversed = ReverseBits(i, bits);
    if (reversed < count) order.push_back(reversed);
  }
  return order;
}

template <typename T, typename F>
std::string Column(const std::vector<Surfel>& surfels, int size, const F& values_of) {
  std::vector<T> column;
  column.reserve(surfels.size() * size);
  for (const Surfel& surfel : surfels) {
    const auto values = values_of(surfel);
    for (int k = 0; k < size; ++k) column.push_back(static_cast<T>(values[k]));
  }
  return EncodeBase64(column);
}

float LargestRadius(const std::vector<Surfel>& surfels) {
  float largest = 1e-6f;
  for (const Surfel& surfel : surfels) largest = std::max(largest, surfel.radius_m);
  return largest;
}

// Replaces the key `files` of each view by `pictures`: file contents as data URLs.
void EmbedPictures(const std::string& folder, Json* views) {
  for (Json& view : *views) {
    const Json files = view.at("files");  // copy, because a new key moves the values of the view
    for (const auto& [name, file] : files.items()) {
      const std::string bytes = ReadFile(folder + "/" + file.get<std::string>());
      view["pictures"][name] = "data:image/jpeg;base64," + EncodeBase64(bytes);
    }
    view.erase("files");
  }
}

Json EvenlySpread(const Json& rows, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (rows.size() + most - 1) / most);
  Json some = Json::array();
  for (std::size_t i = 0; i < rows.size(); i += step) some.push_back(rows[i]);
  return some;
}

std::string TextOf(const std::string& file) {
  return std::filesystem::exists(file) ? ReadFile(file) : "";
}

Json ReadPoses(const std::string& folder, std::size_t max_thumbnails) {
  Json poses = ReadJson(folder + "/poses.json");
  EmbedPictures(folder, &poses.at("views"));
  if (poses.contains("thumbnails")) {  // older releases write none
    poses["thumbnails"] = EvenlySpread(poses["thumbnails"], max_thumbnails);
    EmbedPictures(folder, &poses["thumbnails"]);
  }
  return poses;
}

Trajectory TrajectoryOf(const Json& poses) {
  constexpr double kFarthest_m = 1e9;  // keeps sums of squares finite
  Trajectory trajectory;
  for (const Json& row : poses.at("poses")) {
    const auto number = [&](int i) { return row.at(i).get<double>(); };
    const Eigen::Quaterniond rotation(number(8), number(5), number(6), number(7));
    const Eigen::Vector3d position(number(2), number(3), number(4));
    if (!(position.norm() < kFarthest_m)) throw InputError("poses.json: a pose is too far away");
    trajectory.push_back({number(1), {rotation.normalized(), position}});
  }
  return trajectory;
}

std::string Ending(const std::filesystem::path& path, int parts) {
  const std::vector<std::filesystem::path> all(path.begin(), path.end());
  std::filesystem::path ending;
  for (std::size_t i = all.size() - std::min<std::size_t>(parts, all.size()); i < all.size(); ++i) {
    ending /= all[i];
  }
  return ending.string();
}

std::filesystem::path WholePath(const std::string& folder) {
  std::filesystem::path path = std::filesystem::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

std::vector<Surfel> EvenlySpread(const std::vector<Surfel>& surfels, std::size_t max_points) {
  const std::size_t count = std::min(surfels.size(), max_points);
  std::vector<Surfel> some;
  some.reserve(count);
  for (const std::size_t i : SpreadOrder(count)) {
    const Surfel& surfel = surfels[i * surfels.size() / count];
    if (surfel.position_in_world.allFinite()) some.push_back(surfel);
  }
  return some;
}

std::vector<std::string> ShortNames(const std::vector<std::string>& folders) {
  std::vector<std::filesystem::path> paths;
  std::size_t longest = 1;
  for (const std::string& folder : folders) {
    paths.push_back(WholePath(folder));
    longest =
        std::max<std::size_t>(longest, std::distance(paths.back().begin(), paths.back().end()));
  }
  const std::size_t different = std::set<std::filesystem::path>(paths.begin(), paths.end()).size();
  std::vector<std::string> names;
  for (std::size_t parts = 1; parts <= longest; ++parts) {
    names.clear();
    for (const auto& path : paths) names.push_back(Ending(path, static_cast<int>(parts)));
    if (std::set<std::string>(names.begin(), names.end()).size() == different) break;
  }
  return names;
}

std::string PackDistances(const std::vector<float>& distances_m) {
  std::vector<std::uint16_t> tenths;
  tenths.reserve(distances_m.size());
  for (const float distance : distances_m) {
    tenths.push_back(
        static_cast<std::uint16_t>(distance < kFarFromMap ? std::lround(distance * 1e4f) : 65535));
  }
  return EncodeBase64(tenths);
}

std::string EncodeBase64(const unsigned char* bytes, std::size_t count) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((count + 2) / 3 * 4);
  for (std::size_t i = 0; i < count; i += 3) {
    const std::size_t taken = std::min<std::size_t>(3, count - i);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < taken ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= taken ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

Json PackMap(const std::vector<Surfel>& surfels, std::size_t max_points) {
  using Array3 = Eigen::Array3f;
  const std::vector<Surfel> shown = EvenlySpread(surfels, max_points);
  Eigen::AlignedBox3f box;
  for (const Surfel& surfel : shown) box.extend(surfel.position_in_world);
  if (shown.empty()) box.extend(Eigen::Vector3f::Zero());
  const Array3 low = box.min(), extent = box.sizes().array().max(1e-6f);
  const float max_radius = LargestRadius(shown);
  return {
      {"points", surfels.size()},
      {"shown", shown.size()},
      {"origin", {low[0], low[1], low[2]}},
      {"extent", {extent[0], extent[1], extent[2]}},
      {"max_radius", max_radius},
      {"position",
       Column<std::uint16_t>(shown, 3,
                             [&](const Surfel& s) -> Array3 {
                               return (s.position_in_world.array() - low) / extent * 65535.f + 0.5f;
                             })},
      {"normal",
       Column<std::int8_t>(shown, 3,
                           [](const Surfel& s) -> Array3 {
                             return (s.normal_in_world.array() * 127).round().min(127).max(-127);
                           })},
      {"color",
       Column<std::uint8_t>(shown, 3,
                            [](const Surfel& s) {
                              return std::array<std::uint8_t, 3>{s.color.r, s.color.g, s.color.b};
                            })},
      {"radius", Column<std::uint16_t>(shown, 1,
                                       [&](const Surfel& s) {
                                         return std::array<float, 1>{
                                             s.radius_m / max_radius * 65535.f + 0.5f};
                                       })},
      {"confidence", Column<float>(shown, 1, [](const Surfel& s) { return &s.confidence; })},
      {"first_seen", Column<std::int32_t>(shown, 1, [](const Surfel& s) { return &s.first_seen; })},
      {"last_seen", Column<std::int32_t>(shown, 1, [](const Surfel& s) { return &s.last_seen; })}};
}

ReportedRun ReadRun(const std::string& folder, std::size_t max_thumbnails) {
  const std::string summary = folder + "/summary.json", refinement = folder + "/refinement.json";
  const std::string judged_views = folder + "/views.json";
  const bool is_refined = !std::filesystem::exists(summary) && std::filesystem::exists(refinement);
  ReportedRun run;
  run.page["label"] = "";
  run.page["summary"] = ReadJson(is_refined ? refinement : summary);
  if (std::filesystem::exists(judged_views)) {
    run.page["summary"]["judged_views"] = ReadJson(judged_views);
  }
  run.page["frames"] = is_refined ? "" : ReadFile(folder + "/frames.csv");
  run.page["loops"] = TextOf(folder + "/loops.csv");
  try {
    run.page["poses"] = ReadPoses(folder, max_thumbnails);
    run.trajectory = TrajectoryOf(run.page["poses"]);
  } catch (const Json::exception& error) {
    throw InputError(Concat(folder, "/poses.json: incomplete: ", error.what()));
  }
  run.surfels = ReadSurfelPly(folder + "/map.ply");
  return run;
}

}  // namespace surfit
