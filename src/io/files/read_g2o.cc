#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>
#include <string_view>
#include <unordered_map>

#include "core/files.h"
#include "core/named_values.h"
#include "io/files/g2o_order.h"
#include "io/files/text.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/io/g2o.h"

namespace surfit {
namespace {

enum class IndefiniteInformation { kRefuse, kProject, kBlocks };

constexpr NamedValue<IndefiniteInformation> kIndefiniteInformation[] = {
    {"refuse", IndefiniteInformation::kRefuse},
    {"project", IndefiniteInformation::kProject},
    {"blocks", IndefiniteInformation::kBlocks}};

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kPoseWords = 7, kPositionWords = 3, kPlanarWords = 3,
                      kPlanarPositionWords = 2;

constexpr std::size_t UpperTriangle(std::size_t size) { return size * (size + 1) / 2; }

Rigid3d ParsePose(const std::string_view* words) {
  double v[kPoseWords];
  for (std::size_t i = 0; i < kPoseWords; ++i) v[i] = FiniteNumber(words[i]);
  return RigidFromNumbers(v);
}

// Pose of SE(2) from x, y and angle in rad.
Rigid3d ParsePlanarPose(const std::string_view* words) {
  const double half = FiniteNumber(words[2]) / 2;
  const double v[] = {FiniteNumber(words[0]), FiniteNumber(words[1]), 0, 0, 0,
                      std::sin(half),         std::cos(half)};
  return RigidFromNumbers(v);
}

Eigen::Vector3d ParsePosition(const std::string_view* words, std::size_t count) {
  double v[kPoseWords] = {0, 0, 0, 0, 0, 0, 1};
  for (std::size_t i = 0; i < count; ++i) v[i] = FiniteNumber(words[i]);
  return RigidFromNumbers(v).translation;
}

// Entry of an information matrix. The maximum of 1e30 is a standard deviation of 1e-15.
double InformationOf(std::string_view word) {
  constexpr double kMost = 1e30;
  const double value = FiniteNumber(word);
  if (std::abs(value) <= kMost) return value;
  throw InputError("an entry of the information matrix is ", word, ", must be at most 1e30");
}

// Reads an upper triangle into the first `size` rows and columns `order` of a matrix of zeros.
template <typename Matrix, std::size_t kSize>
Matrix ParseTriangle(const std::string_view* words, const int (&order)[kSize],
                     std::size_t size = kSize) {
  Matrix information = Matrix::Zero();
  for (std::size_t i = 0; i < kSize && i < size; ++i) {
    for (std::size_t j = i; j < kSize && j < size; ++j) {
      information(order[i], order[j]) = information(order[j], order[i]) = InformationOf(*words++);
    }
  }
  return information;
}

// Nearest positive semidefinite matrix.
template <typename Matrix>
Matrix Projected(const Matrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(symmetric);
  const Matrix root =
      eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  const Matrix product = root.transpose() * root;
  return (product + product.transpose()) / 2;
}

Matrix6d Blocks(const Matrix6d& information) {
  Matrix6d blocks = Matrix6d::Zero();
  for (const int k : {0, 3}) {
    const Eigen::Matrix3d block = information.block<3, 3>(k, k);
    blocks.block<3, 3>(k, k) = IsInformation(block) ? block : Projected(block);
  }
  return blocks;
}

template <typename Matrix>
double SmallestEigenvalue(const Matrix& information) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(information).eigenvalues()(0);
}

void RequireWords(const Words& words, std::size_t count) {
  ThrowIf(words.size() != count, words[0], " has ", words.size(), " words, must have ", count);
}

// Parses line by line. Finish() resolves the ids, because vertices may follow their edges.
class G2oReader {
 public:
  explicit G2oReader(const G2oOptions& options)
      : odometry_(options.odometry),
        indefinite_(ValueOf("indefinite_information", options.indefinite_information,
                            kIndefiniteInformation)) {}

  void ReadLine(std::string_view line, int number) {
    const Words words = SplitWords(line.substr(0, line.find('#')));
    if (words.empty()) return;
    line_ = number;
    if (words[0] == "FIX") {
      for (std::size_t i = 1; i < words.size(); ++i)
        fixed_.emplace_back(ParseCount(words[i]), number);
    } else if (!ReadPoseLine(words) && !ReadPlanarLine(words)) {
      ++file_.ignored_lines[std::string(words[0])];
      if (words[0].substr(0, 6) == "VERTEX" && words.size() > 1)
        ignored_vertices_.emplace(words[1]);
    }
  }

  // Resolves all ids. Calls at(line) before each lookup, so that errors name the line.
  template <typename At>
  G2oFile Finish(const At& at) {
    PoseGraph& graph = file_.graph;
    if (graph.poses.empty()) AddVertices();
    for (const auto& [id, line] : fixed_) {
      at(line);
      if (index_of_.count(id) == 0 && ignored_vertices_.count(std::to_string(id)) > 0) {
        ++file_.ignored_lines["FIX"];
      } else {
        graph.poses[Find(id)].fixed = true;
      }
    }
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      at(ends_[i].line);
      graph.edges[i].a = Find(ends_[i].to);
      graph.edges[i].b = Find(ends_[i].from);
    }
    for (std::size_t i = 0; i < prior_of_.size(); ++i) {
      at(prior_of_[i].line);
      graph.priors[i].pose = Find(prior_of_[i].from);
      if (prior_of_[i].to >= 0) graph.priors[i].pose_from_sensor = Offset(prior_of_[i].to);
    }
    for (std::size_t i = 0; i < position_of_.size(); ++i) {
      at(position_of_[i].line);
      graph.positions[i].pose = Find(position_of_[i].from);
      if (position_of_[i].to < 0) continue;
      graph.positions[i].sensor_in_pose = Offset(position_of_[i].to).translation;
    }
    graph.planar = dimension_ == 2;
    SelectOdometry(odometry_, &graph);
    if (file_.chained_count > 0) ChainPosesOf(&graph);
    return std::move(file_);
  }

 private:
  // Ids of poses. For priors, `to` is the id of the parameter, or kNoOffset.
  struct Ends {
    std::int64_t from, to;
    int line;
  };
  static constexpr std::int64_t kNoOffset = -1;

  // Returns false for another tag.
  bool ReadPoseLine(const Words& words) {
    if (words[0] == "VERTEX_SE3:QUAT") {
      Require(3, words, 2 + kPoseWords);
      AddVertex(words[1], ParsePose(&words[2]));
    } else if (words[0] == "EDGE_SE3:QUAT") {
      Require(3, words, 3 + kPoseWords + UpperTriangle(6));
      AddEdge(words, ParsePose(&words[3]), ParsePoseInformation(&words[3 + kPoseWords]));
    } else if (words[0] == "PARAMS_SE3OFFSET") {
      Require(3, words, 2 + kPoseWords);
      const std::int64_t id = ParseCount(words[1]);
      ThrowIf(!offsets_.emplace(id, ParsePose(&words[2])).second, "the id ", id,
              " of a parameter must be unique");
    } else if (words[0] == "EDGE_SE3_PRIOR") {
      Require(3, words, 3 + kPoseWords + UpperTriangle(6));
      AddPrior(words[1], ParseCount(words[2]), ParsePose(&words[3]),
               ParsePoseInformation(&words[3 + kPoseWords]));
    } else if (words[0] == "EDGE_SE3_XYZPRIOR") {
      Require(3, words, 3 + kPositionWords + UpperTriangle(3));
      AddPosition(words[1], ParseCount(words[2]), ParsePosition(&words[3], kPositionWords),
                  ParsePositionInformation(&words[3 + kPositionWords], 3));
    } else if (words[0] == "EDGE_POINTXYZ_PRIOR") {
      Require(3, words, 2 + kPositionWords + UpperTriangle(3));
      AddPosition(words[1], kNoOffset, ParsePosition(&words[2], kPositionWords),
                  ParsePositionInformation(&words[2 + kPositionWords], 3));
    } else {
      return false;
    }
    return true;
  }

  bool ReadPlanarLine(const Words& words) {
    if (words[0] == "VERTEX_SE2") {
      Require(2, words, 2 + kPlanarWords);
      AddVertex(words[1], ParsePlanarPose(&words[2]));
    } else if (words[0] == "EDGE_SE2") {
      Require(2, words, 3 + kPlanarWords + UpperTriangle(3));
      AddEdge(words, ParsePlanarPose(&words[3]), ParsePlanarInformation(&words[3 + kPlanarWords]));
    } else if (words[0] == "EDGE_PRIOR_SE2") {
      Require(2, words, 2 + kPlanarWords + UpperTriangle(3));
      AddPrior(words[1], kNoOffset, ParsePlanarPose(&words[2]),
               ParsePlanarInformation(&words[2 + kPlanarWords]));
    } else if (words[0] == "EDGE_PRIOR_SE2_XY") {
      Require(2, words, 2 + kPlanarPositionWords + UpperTriangle(2));
      AddPosition(words[1], kNoOffset, ParsePosition(&words[2], kPlanarPositionWords),
                  ParsePositionInformation(&words[2 + kPlanarPositionWords], 2));
    } else {
      return false;
    }
    return true;
  }

  void Require(int dimension, const Words& words, std::size_t count) {
    RequireWords(words, count);
    ThrowIf(dimension_ != 0 && dimension_ != dimension, words[0], " is in SE(", dimension,
            "), must be in SE(", dimension_, ") as the lines before");
    dimension_ = dimension;
  }

  Matrix6d ParsePoseInformation(const std::string_view* words) {
    return Accepted(ParseTriangle<Matrix6d>(words, kPoseOrder));
  }
  Matrix6d ParsePlanarInformation(const std::string_view* words) {
    return Accepted(ParseTriangle<Matrix6d>(words, kPlanarOrder));
  }
  Eigen::Matrix3d ParsePositionInformation(const std::string_view* words, std::size_t size) {
    return Accepted(ParseTriangle<Eigen::Matrix3d>(words, kPositionOrder, size));
  }

  template <typename Matrix>
  Matrix Accepted(const Matrix& information) {
    if (IsInformation(information)) return information;
    ThrowIf(indefinite_ == IndefiniteInformation::kRefuse,
            "the information matrix has the eigenvalue ", SmallestEigenvalue(information),
            ", must be positive semidefinite: see --indefinite_information");
    ++file_.indefinite_count;
    if constexpr (Matrix::RowsAtCompileTime == 6) {
      if (indefinite_ == IndefiniteInformation::kBlocks) return Blocks(information);
    }
    return Projected(information);
  }

  void AddVertex(std::string_view word, const Rigid3d& world_from_pose) {
    const std::int64_t id = ParseCount(word);
    ThrowIf(!index_of_.emplace(id, file_.graph.poses.size()).second, "the id ", id,
            " of a vertex must be unique");
    file_.graph.poses.push_back({id, world_from_pose});
  }

  void AddEdge(const Words& words, const Rigid3d& i_from_j, const Matrix6d& information) {
    const Ends ends{ParseCount(words[1]), ParseCount(words[2]), line_};
    ThrowIf(ends.from == ends.to, "an edge must connect two different poses");
    PoseGraphEdge edge;
    edge.a_from_b = i_from_j.Inverse();
    edge.information = information;
    file_.graph.edges.push_back(edge);
    ends_.push_back(ends);
  }

  void AddPrior(std::string_view id, std::int64_t offset, const Rigid3d& world_from_sensor,
                const Matrix6d& information) {
    prior_of_.push_back({ParseCount(id), offset, line_});
    PoseGraphPrior prior;
    prior.world_from_sensor = world_from_sensor;
    prior.information = information;
    file_.graph.priors.push_back(prior);
  }

  void AddPosition(std::string_view id, std::int64_t offset, const Eigen::Vector3d& sensor_in_world,
                   const Eigen::Matrix3d& information) {
    position_of_.push_back({ParseCount(id), offset, line_});
    PoseGraphPosition position;
    position.sensor_in_world = sensor_in_world;
    position.information = information;
    file_.graph.positions.push_back(position);
  }

  // Adds a vertex for each id of a file without vertices, in ascending order.
  void AddVertices() {
    std::set<std::int64_t> ids;
    for (const Ends& ends : ends_) ids.insert({ends.from, ends.to});
    for (const Ends& ends : prior_of_) ids.insert(ends.from);
    for (const Ends& ends : position_of_) ids.insert(ends.from);
    for (const std::int64_t id : ids) {
      index_of_.emplace(id, file_.graph.poses.size());
      file_.graph.poses.push_back({id, Rigid3d()});
    }
    file_.chained_count = ids.size();
  }

  std::size_t Find(std::int64_t id) const {
    const auto found = index_of_.find(id);
    ThrowIf(found == index_of_.end(), "there is no vertex with id ", id);
    return found->second;
  }

  const Rigid3d& Offset(std::int64_t id) const {
    const auto found = offsets_.find(id);
    ThrowIf(found == offsets_.end(), "there is no PARAMS_SE3OFFSET with id ", id);
    return found->second;
  }

  std::string odometry_;
  IndefiniteInformation indefinite_;
  G2oFile file_;
  int line_ = 0;
  int dimension_ = 0;  // 2: SE(2); 3: SE(3); 0: not known yet
  std::unordered_map<std::int64_t, std::size_t> index_of_;
  std::set<std::string, std::less<>> ignored_vertices_;  // ids of vertices of other types
  std::unordered_map<std::int64_t, Rigid3d> offsets_;
  std::vector<Ends> ends_, prior_of_, position_of_;
  std::vector<std::pair<std::int64_t, int>> fixed_;
};

}  // namespace

std::vector<std::string> IndefiniteInformationNames() { return NamesOf(kIndefiniteInformation); }

void G2oOptions::Visit(OptionVisitor& v) {
  v.Add(
      odometry, "odometry",
      "trusted edges; consecutive: neighbours in the order of ids; spanning_tree: the first edges "
      "of the file that form a tree; none: no edge",
      OneOf(OdometryNames()), AsFlag());
  v.Add(indefinite_information, "indefinite_information",
        "indefinite information matrices; refuse: error; project: set negative eigenvalues to 0; "
        "blocks: drop the covariance of rotation and translation",
        OneOf(IndefiniteInformationNames()), AsFlag());
}

G2oFile ReadG2o(const std::string& path, const G2oOptions& options) {
  Validate(options);
  const std::string text = ReadFileOrPipe(path);
  G2oReader reader(options);
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
  ThrowIf(file.graph.poses.empty(), path,
          " has no VERTEX_SE3:QUAT, VERTEX_SE2 or edge line, must have at least one", ignored);
  return file;
}

}  // namespace surfit
