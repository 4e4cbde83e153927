#include "io/files/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "core/files.h"
#include "surfit/core/error.h"

namespace surfit {

void ForEachTextRow(const std::string& path, const std::function<void(const TextRow&)>& call) {
  const std::string file = ReadFile(path);
  const std::string_view text = WithoutByteOrderMark(file);
  std::size_t begin = 0;
  for (int number = 1; begin < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line(text.substr(begin, end - begin));
    begin = end + 1;
    std::replace(line.begin(), line.end(), ',', ' ');
    TextRow row{Concat(path, ":", number), {}};
    std::istringstream columns(line);
    for (std::string column; columns >> column;) row.columns.push_back(column);
    if (!row.columns.empty() && row.columns[0][0] != '#') call(row);
  }
}

std::vector<TextRow> ReadTextRows(const std::string& path) {
  std::vector<TextRow> rows;
  ForEachTextRow(path, [&](const TextRow& row) { rows.push_back(row); });
  return rows;
}

std::string_view WithoutByteOrderMark(std::string_view file) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return file.substr(0, kMark.size()) == kMark ? file.substr(kMark.size()) : file;
}

std::string_view WithoutPlus(std::string_view word) {
  const bool has_plus = word.size() > 1 && word[0] == '+' && word[1] != '+' && word[1] != '-';
  return has_plus ? word.substr(1) : word;
}

double AnyNumber(std::string_view word) {
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto [parsed, error] = std::from_chars(WithoutPlus(word).data(), end, value);
  ThrowIf(error != std::errc() || parsed != end, "'", word, "' is not a finite number");
  return value;
}

double FiniteNumber(std::string_view word) {
  const double value = AnyNumber(word);
  ThrowIf(!std::isfinite(value), "'", word, "' is not a finite number");
  return value;
}

double ParseNumber(const std::string& text, const std::string& place) {
  return WithContext(place, [&] { return FiniteNumber(text); });
}

static void RequireNear(const Eigen::Vector3d& position) {
  constexpr double kFarthest_m = 1e9;
  for (const double coordinate : position) {
    ThrowIf(!(std::abs(coordinate) <= kFarthest_m), "a coordinate is ", coordinate,
            " m, must be at most ", kFarthest_m, " m");
  }
}

Rigid3d RigidFromNumbers(const double* numbers) {
  constexpr double kTolerance = 0.01;
  const double* const q = numbers + 3;
  const Eigen::Vector3d translation(numbers[0], numbers[1], numbers[2]);
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  ThrowIf(!(std::abs(rotation.norm() - 1) <= kTolerance), "the norm of the quaternion is ",
          rotation.norm(), ", must be 1");
  RequireNear(translation);
  return {rotation.normalized(), translation};
}

Rigid3d RigidFromMatrix(const Eigen::Matrix4d& matrix, const std::string& place) {
  const Eigen::Matrix3d r = matrix.topLeftCorner<3, 3>();
  ThrowIf(!((r * r.transpose() - Eigen::Matrix3d::Identity()).norm() < 0.01 && r.determinant() > 0),
          place, ": the matrix is not a rigid transform");
  WithContext(place, [&] { RequireNear(matrix.topRightCorner<3, 1>()); });
  return Rigid3d(r, matrix.topRightCorner<3, 1>());
}

ParsedRigid ParseRigid(const std::vector<std::string>& words, const std::string& place) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i)
    matrix(i / 4, i % 4) = WithContext(place, [&] { return AnyNumber(words[i]); });
  for (int i = 0; i < 16; ++i) {
    if (!std::isfinite(matrix(i / 4, i % 4)))
      return {std::nullopt, Concat(place, ": '", words[i], "' is not a finite number")};
  }
  try {
    return {RigidFromMatrix(matrix, place), ""};
  } catch (const InputError& error) {
    return {std::nullopt, error.what()};
  }
}

ParsedRigid ParseRigid(const std::vector<TextRow>& rows, std::size_t first,
                       const std::string& path) {
  ThrowIf(rows.size() < first + 4, path, " ends within a 4 x 4 matrix");
  std::vector<std::string> words;
  for (std::size_t i = first; i < first + 4; ++i) {
    ThrowIf(rows[i].columns.size() != 4, rows[i].place, " has ", rows[i].columns.size(),
            " columns, must have 4");
    words.insert(words.end(), rows[i].columns.begin(), rows[i].columns.end());
  }
  return ParseRigid(words, rows[first].place);
}

Words SplitWords(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  Words words;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    if (line.empty()) return words;
    words.push_back(line.substr(0, line.find_first_of(kBlanks)));
    line.remove_prefix(words.back().size());
  }
}

std::int64_t ParseCount(std::string_view word) {
  std::int64_t count = -1;
  const char* const end = word.data() + word.size();
  const auto [parsed, error] = std::from_chars(WithoutPlus(word).data(), end, count);
  ThrowIf(error != std::errc() || parsed != end || count < 0, "the count is '", word,
          "', must be an integer of at least 0");
  return count;
}

}  // namespace surfit
