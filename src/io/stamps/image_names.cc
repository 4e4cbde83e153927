#include "io/stamps/image_names.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <functional>
#include <map>
#include <set>
#include <string_view>

#include "io/stamps/time_words.h"

namespace surfit {
namespace {

constexpr const char* kNumerals = "0123456789";

struct NameInteger {
  std::string_view digits;
  long value = 0;
  bool touches_letter = false;   // a letter before or after the digits
  bool precedes_letter = false;  // a letter after the digits
};

bool IsLetterAt(std::string_view text, std::size_t at) {
  return at < text.size() && std::isalpha(static_cast<unsigned char>(text[at])) != 0;
}

std::string_view Stem(std::string_view name) { return name.substr(0, name.rfind('.')); }

// Integers of a file name without its ending. Numbers that exceed `long` are left out.
std::vector<NameInteger> IntegersIn(const std::string& name) {
  const std::string_view stem = Stem(name);
  std::vector<NameInteger> integers;
  for (std::size_t begin = 0; (begin = stem.find_first_of(kNumerals, begin)) != stem.npos;) {
    const std::size_t end = std::min(stem.find_first_not_of(kNumerals, begin), stem.size());
    NameInteger integer;
    integer.digits = stem.substr(begin, end - begin);
    integer.precedes_letter = IsLetterAt(stem, end);
    integer.touches_letter = integer.precedes_letter || (begin > 0 && IsLetterAt(stem, begin - 1));
    const auto result = std::from_chars(stem.data() + begin, stem.data() + end, integer.value);
    if (result.ec == std::errc()) integers.push_back(integer);
    begin = end;
  }
  return integers;
}

// Names with the same number of integers.
struct Alike {
  std::vector<const std::string*> names;
  std::vector<std::vector<NameInteger>> integers;  // of each name

  std::vector<long> Column(std::size_t k) const {
    std::vector<long> column;
    column.reserve(integers.size());
    for (const auto& of_name : integers) column.push_back(of_name[k].value);
    return column;
  }
};

// Index of the integer of a single name that is the most likely number.
std::size_t LikelyNumber(const std::vector<NameInteger>& integers) {
  const auto is_free = [](const NameInteger& integer) { return !integer.touches_letter; };
  const auto is_last = [](const NameInteger& integer) { return !integer.precedes_letter; };
  auto at = std::find_if(integers.begin(), integers.end(), is_free);
  if (at == integers.end()) at = std::find_if(integers.begin(), integers.end(), is_last);
  return at == integers.end() ? 0 : static_cast<std::size_t>(at - integers.begin());
}

std::size_t NumberColumn(const Alike& alike) {
  std::size_t best = 0, most = 0;
  for (std::size_t k = 0; k < alike.integers[0].size(); ++k) {
    const std::vector<long> column = alike.Column(k);
    const std::size_t different = std::set<long>(column.begin(), column.end()).size();
    if (different > most) {
      most = different;
      best = k;
    }
  }
  return most == 1 ? LikelyNumber(alike.integers[0]) : best;
}

// The next integer that ascends with the number and has intervals of a camera in ms, us or ns.
std::optional<std::size_t> TimeColumn(const Alike& alike, std::size_t number) {
  std::vector<std::size_t> order(alike.names.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return alike.integers[a][number].value < alike.integers[b][number].value;
  });
  for (std::size_t k = number + 1; k < alike.integers[0].size(); ++k) {
    std::vector<double> times;
    for (const std::size_t i : order)
      times.push_back(static_cast<double>(alike.integers[i][k].value));
    const bool ascends =
        std::adjacent_find(times.begin(), times.end(), std::greater_equal<double>()) == times.end();
    if (ascends && DetectTimeUnit(times).value_or(0) != 0) return k;
  }
  return std::nullopt;
}

// Numbering convention: pose number - pose_origin equals frame number - frame_origin, or the
// position of the frame.
struct NumberingTrial {
  long pose_origin = 0, frame_origin = 0;
  bool by_position = false;
};

std::vector<int> TryNumbering(const NumberingTrial& trial, const std::vector<long>& poses,
                              const std::vector<long>& frames) {
  std::map<long, int> index;
  for (std::size_t i = 0; i < frames.size(); ++i)
    index[trial.by_position ? static_cast<long>(i) : frames[i] - trial.frame_origin] =
        static_cast<int>(i);
  std::vector<int> found;
  for (const long pose : poses) {
    const auto at = index.find(pose - trial.pose_origin);
    found.push_back(at == index.end() ? -1 : at->second);
  }
  return found;
}

}  // namespace

std::vector<NamedImage> NumberImages(const std::vector<std::string>& names) {
  std::map<std::size_t, Alike> by_count;
  for (const std::string& name : names) {
    std::vector<NameInteger> integers = IntegersIn(name);
    if (integers.empty()) continue;
    Alike& alike = by_count[integers.size()];
    alike.names.push_back(&name);
    alike.integers.push_back(std::move(integers));
  }
  std::vector<NamedImage> images;
  for (const auto& [count, alike] : by_count) {
    const std::size_t number = NumberColumn(alike);
    const std::optional<std::size_t> time = TimeColumn(alike, number);
    for (std::size_t i = 0; i < alike.names.size(); ++i) {
      const std::vector<NameInteger>& integers = alike.integers[i];
      images.push_back({*alike.names[i], integers[number].value,
                        time ? std::string(integers[*time].digits) : ""});
    }
  }
  std::sort(images.begin(), images.end(),
            [](const NamedImage& a, const NamedImage& b) { return a.name < b.name; });
  return images;
}

std::optional<std::string> TimeInName(const std::string& name) {
  const std::string_view stem = Stem(name);
  const std::size_t point = stem.rfind('.');
  if (point == stem.npos || point + 1 == stem.size() || point == 0) return std::nullopt;
  if (stem.find_first_not_of(kNumerals, point + 1) != stem.npos) return std::nullopt;
  const std::size_t before = stem.find_last_not_of(kNumerals, point - 1);
  const std::size_t first = before == stem.npos ? 0 : before + 1;
  if (first == point || (first > 0 && stem[first - 1] == '.')) return std::nullopt;
  return std::string(stem.substr(first));
}

std::vector<int> FramesOfPoses(const std::vector<long>& poses, const std::vector<long>& frames) {
  if (poses.empty() || frames.empty()) return std::vector<int>(poses.size(), -1);
  const long first_pose = poses.front(), first_frame = frames.front();
  std::vector<NumberingTrial> trials = {{0, 0, false},
                                        {0, 1, false},
                                        {1, 0, false},
                                        {first_pose, first_frame, false},
                                        {first_pose, 0, true}};
  if (first_pose == 0 && first_frame == 1 && poses.back() != frames.back())
    std::swap(trials[0], trials[1]);
  std::vector<int> best;
  std::ptrdiff_t fewest = 0;
  for (const NumberingTrial& trial : trials) {
    std::vector<int> found = TryNumbering(trial, poses, frames);
    const std::ptrdiff_t missing = std::count(found.begin(), found.end(), -1);
    if (!best.empty() && missing >= fewest) continue;
    fewest = missing;
    best = std::move(found);
  }
  return best;
}

}  // namespace surfit
