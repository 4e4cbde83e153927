#include "surfit/io/trajectory_files.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iomanip>
#include <locale>
#include <string_view>

#include "core/files.h"
#include "io/files/text.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::string_view kSeparators = " \t,\r";
constexpr const char* kHead = "# timestamp tx ty tz qx qy qz qw\n";

// Removes the next column from the line and returns it; empty at the end of the line.
std::string_view TakeColumn(std::string_view* line) {
  line->remove_prefix(std::min(line->find_first_not_of(kSeparators), line->size()));
  const std::string_view column = line->substr(0, line->find_first_of(kSeparators));
  line->remove_prefix(column.size());
  return column;
}

StampedPose ParsePose(std::string_view line) {
  std::array<double, 8> v;
  std::size_t count = 0;
  for (std::string_view column; !(column = TakeColumn(&line)).empty(); ++count) {
    const double value = FiniteNumber(column);
    if (count < v.size()) v[count] = value;
  }
  ThrowIf(count != v.size(), count, " columns, must be 8");
  return {v[0], RigidFromNumbers(&v[1])};
}

// Calls parse(line) for each line, except empty lines and comments. Adds file and line number to
// the messages of InputErrors.
template <typename Parse>
void ForEachLine(const std::string& path, const Parse& parse) {
  const std::string text = ReadFileOrPipe(path);
  int line_number = 0;
  for (std::string_view rest = WithoutByteOrderMark(text); !rest.empty();) {
    ++line_number;
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    const std::size_t first = line.find_first_not_of(kSeparators);
    if (first == line.npos || line[first] == '#') continue;
    try {
      parse(line);
    } catch (const InputError& error) {
      throw InputError(path, ":", line_number, ": ", error.what());
    }
  }
}

void AppendFixed(double value, int decimals, std::string* line) {
  std::array<char, 400> text;  // the longest double has 309 digits before the point
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value,
                                    std::chars_format::fixed, decimals);
  line->append(text.data(), result.ptr);
}

void RequireFinite(const StampedPose& pose) {
  const Rigid3d& rigid = pose.world_from_camera;
  ThrowIf(!std::isfinite(pose.stamp_s) || !rigid.translation.allFinite() ||
              !rigid.rotation.coeffs().allFinite(),
          "the pose at ", pose.stamp_s, " s is not finite");
}

std::string LineOf(const StampedPose& pose) {
  const Eigen::Vector3d& t = pose.world_from_camera.translation;
  const Eigen::Vector4d& q = pose.world_from_camera.rotation.coeffs();  // x y z w, as in the file
  RequireFinite(pose);
  std::string line;
  AppendFixed(pose.stamp_s, 6, &line);
  for (const double value : {t.x(), t.y(), t.z(), q[0], q[1], q[2], q[3]}) {
    line += ' ';
    AppendFixed(value, 9, &line);
  }
  return line + '\n';
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
              [&](std::string_view line) { stamps_s.push_back(FiniteNumber(TakeColumn(&line))); });
  std::sort(stamps_s.begin(), stamps_s.end());
  return stamps_s;
}

void WriteTumTrajectory(const Trajectory& trajectory, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << kHead;
    for (const StampedPose& pose : trajectory) out << LineOf(pose);
  });
}

TumTrajectoryWriter::TumTrajectoryWriter(const std::string& path) : file_(path) {
  file_.Append(kHead);
}

void TumTrajectoryWriter::Append(const StampedPose& pose) { file_.Append(LineOf(pose)); }

void WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.imbue(std::locale::classic());
    out << std::fixed << std::setprecision(9);
    for (const StampedPose& pose : trajectory) {
      const Eigen::Matrix3d rotation = pose.world_from_camera.rotation.toRotationMatrix();
      const Eigen::Vector3d& translation = pose.world_from_camera.translation;
      RequireFinite(pose);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out << rotation(i, j) << ' ';
        out << translation[i] << (i < 2 ? ' ' : '\n');
      }
    }
  });
}

}  // namespace surfit
