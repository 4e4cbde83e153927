#include "surfit/io/g2o.h"

#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <limits>
#include <locale>
#include <set>
#include <string_view>
#include <unordered_map>

#include "core/files.h"
#include "io/files/text.h"
#include "surfit/core/atomic_file.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::size_t kPoseWords = 7, kInformationWords = 21;

Rigid3d ParsePose(const std::string_view* words) {
  double v[kPoseWords];
  for (std::size_t i = 0; i < kPoseWords; ++i) v[i] = FiniteNumber(words[i]);
  return RigidFromNumbers(v);
}

// Parses an entry of an information matrix. The maximum absolute value, 1e30, corresponds to a
// standard deviation of 1e-15.
double InformationOf(std::string_view word) {
  constexpr double kMost = 1e30;
  const double value = FiniteNumber(word);
  if (std::abs(value) <= kMost) return value;
  throw InputError("an entry of the information matrix is ", word, ", must be at most 1e30");
}

// Converts from the order (translation, rotation) of g2o to (rotation, translation).
Eigen::Matrix<double, 6, 6> ParseInformation(const std::string_view* words) {
  Eigen::Matrix<double, 6, 6> information;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      const int row = (i + 3) % 6, column = (j + 3) % 6;
      information(row, column) = information(column, row) = InformationOf(*words++);
    }
  }
  ThrowIf(!IsInformation(information), "the information matrix must be positive semidefinite");
  return information;
}

void RequireWords(const Words& words, std::size_t count) {
  ThrowIf(words.size() != count, words[0], " has ", words.size(), " words, must have ", count);
}

// Parses line by line. Finish() resolves the ids, because vertices may follow their edges.
class G2oReader {
 public:
  void ReadLine(std::string_view line, int number) {
    const Words words = SplitWords(line.substr(0, line.find('#')));
    if (words.empty()) return;
    if (words[0] == "VERTEX_SE3:QUAT") {
      ReadVertex(words);
    } else if (words[0] == "EDGE_SE3:QUAT") {
      ReadEdge(words, number);
    } else if (words[0] == "FIX") {
      for (std::size_t i = 1; i < words.size(); ++i)
        fixed_.emplace_back(ParseCount(words[i]), number);
    } else {
      ++file_.ignored_lines[std::string(words[0])];
      if (words[0].substr(0, 6) == "VERTEX" && words.size() > 1)
        ignored_vertices_.emplace(words[1]);
    }
  }

  // Resolves all ids. Calls at(line) before each lookup, so that errors name the line.
  template <typename At>
  G2oFile Finish(const At& at) {
    for (const auto& [id, line] : fixed_) {
      at(line);
      if (index_of_.count(id) == 0 && ignored_vertices_.count(std::to_string(id)) > 0) {
        ++file_.ignored_lines["FIX"];
      } else {
        file_.graph.poses[Find(id)].fixed = true;
      }
    }
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      at(ends_[i].line);
      file_.graph.edges[i].a = Find(ends_[i].to);
      file_.graph.edges[i].b = Find(ends_[i].from);
    }
    return std::move(file_);
  }

 private:
  struct Ends {
    std::int64_t from, to;
    int line;
  };

  void ReadVertex(const Words& words) {
    RequireWords(words, 2 + kPoseWords);
    const std::int64_t id = ParseCount(words[1]);
    ThrowIf(!index_of_.emplace(id, file_.graph.poses.size()).second, "the id ", id,
            " of a vertex must be unique");
    file_.graph.poses.push_back({id, ParsePose(&words[2])});
  }

  void ReadEdge(const Words& words, int line) {
    RequireWords(words, 3 + kPoseWords + kInformationWords);
    const Ends ends{ParseCount(words[1]), ParseCount(words[2]), line};
    ThrowIf(ends.from == ends.to, "an edge must connect two different poses");
    PoseGraphEdge edge;
    edge.a_from_b = ParsePose(&words[3]).Inverse();
    edge.information = ParseInformation(&words[3 + kPoseWords]);
    edge.loop = std::abs(ends.from - ends.to) != 1;
    file_.graph.edges.push_back(edge);
    ends_.push_back(ends);
  }

  std::size_t Find(std::int64_t id) const {
    const auto found = index_of_.find(id);
    ThrowIf(found == index_of_.end(), "there is no vertex with id ", id);
    return found->second;
  }

  G2oFile file_;
  std::unordered_map<std::int64_t, std::size_t> index_of_;
  std::set<std::string, std::less<>> ignored_vertices_;  // ids of vertices of other types
  std::vector<Ends> ends_;
  std::vector<std::pair<std::int64_t, int>> fixed_;
};

void WritePose(const Rigid3d& pose, std::ostream& out) {
  for (int i = 0; i < 3; ++i) out << ' ' << pose.translation[i];
  for (int i = 0; i < 4; ++i) out << ' ' << pose.rotation.coeffs()[i];
}

void WriteEdge(const PoseGraph& graph, const PoseGraphEdge& edge, std::ostream& out) {
  out << "EDGE_SE3:QUAT " << graph.poses[edge.b].id << ' ' << graph.poses[edge.a].id;
  WritePose(edge.a_from_b.Inverse(), out);
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) out << ' ' << edge.information((i + 3) % 6, (j + 3) % 6);
  }
  out << '\n';
}

}  // namespace

G2oFile ReadG2o(const std::string& path) {
  const std::string text = ReadFileOrPipe(path);
  G2oReader reader;
  int line_number = 0;
  G2oFile file;
  try {
    for (std::string_view rest = WithoutByteOrderMark(text); !rest.empty();) {
      const std::string_view line = rest.substr(0, rest.find('\n'));
      rest.remove_prefix(std::min(line.size() + 1, rest.size()));
      reader.ReadLine(line, ++line_number);
    }
    file = reader.Finish([&](int line) { line_number = line; });
  } catch (const InputError& error) {
    throw InputError(path, ":", line_number, ": ", error.what());
  }
  std::string ignored;
  for (const auto& [word, count] : file.ignored_lines)
    ignored += Concat(ignored.empty() ? "; ignored: " : ", ", count, " ", word);
  ThrowIf(file.graph.poses.empty(), path, " has no VERTEX_SE3:QUAT line, must have at least one",
          ignored);
  return file;
}

void WriteG2o(const PoseGraph& graph, const std::string& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.imbue(std::locale::classic());
    out << std::setprecision(std::numeric_limits<double>::max_digits10);
    for (const PoseGraphPose& pose : graph.poses) {
      out << "VERTEX_SE3:QUAT " << pose.id;
      WritePose(pose.world_from_pose, out);
      out << '\n';
    }
    for (const PoseGraphPose& pose : graph.poses) {
      if (pose.fixed) out << "FIX " << pose.id << '\n';
    }
    for (const PoseGraphEdge& edge : graph.edges) WriteEdge(graph, edge, out);
  });
}

}  // namespace surfit
