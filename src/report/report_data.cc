#include "report/report_data.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>

#include "core/read_file.h"
#include "run/output_files.h"
#include "surfit/core/error.h"
#include "surfit/io/point_cloud.h"

namespace surfit {
namespace {

std::size_t ReverseBits(std::size_t value, int bits) {
  std::size_t reversed = 0;
  for (int bit = 0; bit < bits; ++bit) reversed = reversed << 1 | (value >> bit & 1);
  return reversed;
}

// 0, ..., count - 1, so that the first few are evenly spread however many they are: numbers with
// their bits reversed (J. G. van der Corput's sequence).
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

// A column of the table: `size` values of type T of each surfel.
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

float MedianRadius(const std::vector<Surfel>& surfels) {
  if (surfels.empty()) return 0;
  std::vector<float> radii;
  for (const Surfel& surfel : surfels) radii.push_back(surfel.radius_m);
  const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
  std::nth_element(radii.begin(), middle, radii.end());
  return *middle;
}

// Each view's `files` become `pictures`: the same names, with what the files hold.
void EmbedPictures(const std::string& folder, Json* views) {
  for (Json& view : *views) {
    const Json files = view.at("files");  // a copy: setting a key moves the view's values
    for (const auto& [name, file] : files.items()) {
      const std::string bytes = ReadFile(folder + "/" + file.get<std::string>());
      view["pictures"][name] = "data:image/jpeg;base64," + EncodeBase64(bytes);
    }
    view.erase("files");
  }
}

}  // namespace

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
  Array3 low = Array3::Zero(), high = Array3::Zero();
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const Array3 position = shown[i].position_in_world.array();
    low = i == 0 ? position : low.min(position).eval();
    high = i == 0 ? position : high.max(position).eval();
  }
  const Array3 extent = (high - low).max(1e-6f);
  return {
      {"points", surfels.size()},
      {"shown", shown.size()},
      {"origin", {low[0], low[1], low[2]}},
      {"extent", {extent[0], extent[1], extent[2]}},
      {"radius", MedianRadius(shown)},
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
      {"confidence", Column<float>(shown, 1, [](const Surfel& s) { return &s.confidence; })},
      {"first_seen", Column<std::int32_t>(shown, 1, [](const Surfel& s) { return &s.first_seen; })},
      {"last_seen", Column<std::int32_t>(shown, 1, [](const Surfel& s) { return &s.last_seen; })}};
}

Json ReadRun(const std::string& folder, std::size_t max_points) {
  Json run;
  run["label"] = folder;
  run["summary"] = ReadJson(folder + "/summary.json");
  const std::string judged_views = folder + "/views.json";
  if (std::filesystem::exists(judged_views)) {
    run["summary"]["judged_views"] = ReadJson(judged_views);
  }
  run["frames"] = ReadFile(folder + "/frames.csv");
  const std::string poses = folder + "/poses.json";
  run["poses"] = ReadJson(poses);
  try {
    EmbedPictures(folder, &run["poses"].at("views"));
  } catch (const Json::exception& error) {
    throw InputError(Concat(poses, ": incomplete: ", error.what()));
  }
  run["map"] = PackMap(ReadSurfelPly(folder + "/map.ply"), max_points);
  return run;
}

}  // namespace surfit
