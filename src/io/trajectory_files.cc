#include "surfit/io/trajectory_files.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <iomanip>
#include <locale>
#include <string_view>
#include <system_error>

#include "core/read_file.h"
#include "io/text.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::string_view kSeparators = " \t,\r";
// Files carry 4 or more decimals of a unit quaternion; anything further off is another column.

// The next column of the line, which is removed from it; empty at the end.
std::string_view TakeColumn(std::string_view* line) {
  line->remove_prefix(std::min(line->find_first_not_of(kSeparators), line->size()));
  const std::string_view column = line->substr(0, line->find_first_of(kSeparators));
  line->remove_prefix(column.size());
  return column;
}

double NumberIn(std::string_view column) {
  double value = 0;
  const char* const end = column.data() + column.size();
  const auto [parsed, error] = std::from_chars(column.data(), end, value);
  if (error != std::errc() || parsed != end || !std::isfinite(value)) {
    throw InputError(Concat("'", column, "' is not a finite number"));
  }
  return value;
}

StampedPose ParsePose(std::string_view line) {
  std::array<double, 8> v;
  std::size_t count = 0;
  for (std::string_view column; !(column = TakeColumn(&line)).empty(); ++count) {
    const double value = NumberIn(column);
    if (count < v.size()) v[count] = value;
  }
  if (count != v.size()) throw InputError(Concat(count, " columns, must be 8"));
  const Eigen::Quaterniond rotation(v[7], v[4], v[5], v[6]);  // w first here, last in the file
  const double norm = rotation.norm();
  if (std::abs(norm - 1) > kQuaternionNormTolerance) {
    throw InputError(Concat("the norm of the quaternion is ", norm, ", must be 1"));
  }
  return {v[0], Rigid3d(rotation.normalized(), {v[1], v[2], v[3]})};
}

// Calls parse(line) for each line that is neither empty nor a comment, and adds file and line
// number to the message of an InputError that it throws.
template <typename Parse>
void ForEachLine(const std::string& path, const Parse& parse) {
  const std::string text = ReadFile(path);
  int line_number = 0;
  for (std::string_view rest = text; !rest.empty();) {
    ++line_number;
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    const std::size_t first = line.find_first_not_of(kSeparators);
    if (first == line.npos || line[first] == '#') continue;
    try {
      parse(line);
    } catch (const InputError& error) {
      throw InputError(Concat(path, ":", line_number, ": ", error.what()));
    }
  }
}

void AppendFixed(double value, int decimals, std::string* line) {
  std::array<char, 400> text;  // the longest double has 309 digits before the point
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value,
                                    std::chars_format::fixed, decimals);
  line->append(text.data(), result.ptr);
}

}  // namespace

Trajectory ReadTumTrajectory(const std::string& path) {
  Trajectory trajectory;
  ForEachLine(path, [&](std::string_view line) { trajectory.push_back(ParsePose(line)); });
  std::stable_sort(
      trajectory.begin(), trajectory.end(),
      [](const StampedPose& a, const StampedPose& b) { return a.stamp_s < b.stamp_s; });
  return trajectory;
}

std::vector<double> ReadTumStamps(const std::string& path) {
  std::vector<double> stamps_s;
  ForEachLine(path,
              [&](std::string_view line) { stamps_s.push_back(NumberIn(TakeColumn(&line))); });
  std::sort(stamps_s.begin(), stamps_s.end());
  return stamps_s;
}

TumTrajectoryWriter::TumTrajectoryWriter(const std::string& path)
    : path_(path), file_(path, std::ios::binary | std::ios::trunc) {
  Write("# timestamp tx ty tz qx qy qz qw\n");
}

void TumTrajectoryWriter::Append(const StampedPose& pose) {
  const Eigen::Vector3d& t = pose.world_from_camera.translation;
  const Eigen::Vector4d& q = pose.world_from_camera.rotation.coeffs();  // x y z w, as in the file
  CHECK(std::isfinite(pose.stamp_s) && t.allFinite() && q.allFinite());
  std::string line;
  AppendFixed(pose.stamp_s, 6, &line);
  for (const double value : {t.x(), t.y(), t.z(), q[0], q[1], q[2], q[3]}) {
    line += ' ';
    AppendFixed(value, 9, &line);
  }
  line += '\n';
  Write(line);
}

void TumTrajectoryWriter::Write(const std::string& line) {
  file_ << line << std::flush;
  if (!file_) {
    const std::error_code reason(errno, std::generic_category());
    throw InputError(Concat("cannot write '", path_, "': ", reason.message()));
  }
}

void WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.imbue(std::locale::classic());
    out << std::fixed << std::setprecision(9);
    for (const StampedPose& pose : trajectory) {
      const Eigen::Matrix3d rotation = pose.world_from_camera.rotation.toRotationMatrix();
      const Eigen::Vector3d& translation = pose.world_from_camera.translation;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out << rotation(i, j) << ' ';
        out << translation[i] << (i < 2 ? ' ' : '\n');
      }
    }
  });
}

}  // namespace surfit
