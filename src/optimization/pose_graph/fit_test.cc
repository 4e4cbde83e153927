#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <random>

#include "optimization/pose_graph/optimize_pose_graph.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Factor = Eigen::SimplicialLDLT<SparseMatrix>;

// Linearisation at the poses of an optimised graph, without its outliers.
struct Linearized {
  Linearized(const PoseGraph& graph, const PoseGraphSummary& summary)
      : used(graph.edges.size(), true) {
    for (const std::size_t i : summary.outlier_edges) used[i] = false;
    std::vector<Rigid3d> poses;
    for (const PoseGraphPose& pose : graph.poses) poses.push_back(pose.world_from_pose);
    PoseGraphProblem problem(graph, poses, ChainPoses(graph).held);
    system = problem.Linearize(used);
  }

  // Returns false if the information of the poses is singular.
  bool Factorize() {
    const SparseMatrix information = system.jacobian.transpose() * system.jacobian;
    factor.compute(information);
    if (factor.info() != Eigen::Success) return false;
    const Eigen::VectorXd pivots = factor.vectorD();
    return pivots.size() == 0 || pivots.minCoeff() > kMinPivot * pivots.maxCoeff();
  }

  // Rounding of the sums over the edges of a graph leaves a pivot of 1e-16 of the largest pivot.
  static constexpr double kMinPivot = 1e-15;

  std::vector<bool> used;
  PoseGraphProblem::Linearization system;
  Factor factor;
};

template <typename Matrix>
int RankOf(const Matrix& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(information, Eigen::EigenvaluesOnly);
  const auto& values = eigen.eigenvalues();
  constexpr double kSmall = 1e-9;
  return static_cast<int>((values.array() > kSmall * values.maxCoeff()).count());
}

// Probability that a chi-square variable with k degrees of freedom is larger than x (Wilson,
// Hilferty: The distribution of chi-square, 1931). The error is below 0.001 for k >= 3.
double ChiSquareTail(double x, double k) {
  if (k <= 0) return 1;
  const double variance = 2 / (9 * k);
  const double z = (std::cbrt(x / k) - (1 - variance)) / std::sqrt(variance);
  return std::erfc(z / std::sqrt(2)) / 2;
}

struct ClassSums {
  double squared_error = 0, rank = 0, leverage = 0;

  double Freedom() const { return rank - leverage; }
  double Ratio() const { return Freedom() > 0.5 ? squared_error / Freedom() : 0; }
};

// Probability of an error in TestFit() for correct results.
constexpr double kSignificance = 1e-3;
// Maximum ratio of the variance factors (ClassSums::Ratio()) of odometry and loop closures. The
// ratio is 0.5 to 2.1 for 12 public graphs without wrong loops, and above 10 at wrong minima.
constexpr double kMostContrast = 4;

// Returns whether the ratio of `large` is significantly above kMostContrast times the ratio of
// `small`. Uses the F-test in the normal approximation of Paulson, 1942.
bool Exceeds(const ClassSums& large, const ClassSums& small) {
  if (large.Ratio() <= 0 || small.Ratio() <= 0) return false;
  const double f = large.Ratio() / (kMostContrast * small.Ratio());
  const double v1 = 2 / (9 * large.Freedom()), v2 = 2 / (9 * small.Freedom());
  const double root = std::cbrt(f);
  const double z = ((1 - v2) * root - (1 - v1)) / std::sqrt(v1 + v2 * root * root);
  return f > 1 && std::erfc(z / std::sqrt(2)) / 2 < kSignificance;
}

// Information matrices of public graphs are often wrong by a common factor. Therefore a large
// chi-square is no reason for doubt if odometry and loop closures contribute equally. Accepted
// wrong loop closures increase the residuals of odometry.
std::string ReasonForDoubt(const PoseGraph& graph, const PoseGraphSummary& summary,
                           const PoseGraphFit& fit, const ClassSums& odometry,
                           const ClassSums& loops) {
  const std::size_t rejected = summary.outlier_edges.size();
  if (2 * rejected > summary.loop_count) {
    return Concat(rejected, " of ", summary.loop_count, " loop closures are rejected");
  }
  if (Exceeds(odometry, loops)) {
    return Concat("the residuals of odometry are too large for those of ",
                  summary.loop_count - rejected, " accepted loop closures: ", odometry.Ratio(),
                  " and ", loops.Ratio(), " per degree of freedom");
  }
  if (fit.p_value >= kSignificance) return "";
  std::string chi_square = Concat("chi-square is ", fit.chi_square, " for ", fit.degrees_of_freedom,
                                  " degrees of freedom");
  if (Exceeds(loops, odometry)) {
    return Concat(chi_square, ", and loop closures do not fit: ", loops.Ratio(),
                  " per degree of freedom, odometry ", odometry.Ratio());
  }
  const bool is_comparable = odometry.Ratio() > 0 && loops.Ratio() > 0;
  if (!is_comparable || !(graph.priors.empty() && graph.positions.empty())) return chi_square;
  return "";
}

// Traces of the parts of the hat matrix H = J (J^T J)^-1 J^T of odometry and loop closures. Uses
// the estimator of Hutchinson, which is the mean of z^T H z over vectors z of random signs.
void EstimateLeverage(const PoseGraph& graph, const Linearized& at, ClassSums* odometry,
                      ClassSums* loops) {
  constexpr int kVectors = 8;
  std::mt19937_64 rng(1);
  const auto& system = at.system;
  for (int k = 0; k < kVectors; ++k) {
    Eigen::VectorXd of_odometry = Eigen::VectorXd::Zero(system.jacobian.rows());
    Eigen::VectorXd of_loops = of_odometry;
    for (std::size_t i = 0; i < graph.edges.size(); ++i) {
      if (!at.used[i]) continue;
      Eigen::VectorXd& z = graph.edges[i].loop ? of_loops : of_odometry;
      for (int r = 0; r < system.edge_rows; ++r) z[system.first_row[i] + r] = rng() & 1 ? 1 : -1;
    }
    for (const auto& [z, sums] : {std::pair{&of_odometry, odometry}, std::pair{&of_loops, loops}}) {
      const Eigen::VectorXd by_pose = system.jacobian.transpose() * *z;
      sums->leverage += by_pose.dot(at.factor.solve(by_pose)) / kVectors;
    }
  }
}

}  // namespace

double DegreesOfFreedom(const PoseGraph& graph, const ChainedPoses& chained,
                        const std::vector<std::size_t>& left_out) {
  std::vector<bool> is_measured(graph.poses.size(), false);
  double freedom = 0;
  auto next = left_out.begin();
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (next != left_out.end() && *next == i) {
      ++next;
      continue;
    }
    is_measured[graph.edges[i].a] = is_measured[graph.edges[i].b] = true;
    freedom += RankOf(graph.edges[i].information);
  }
  for (const PoseGraphPrior& prior : graph.priors) {
    is_measured[prior.pose] = true;
    freedom += RankOf(prior.information);
  }
  for (const PoseGraphPosition& position : graph.positions) {
    is_measured[position.pose] = true;
    freedom += RankOf(position.information);
  }
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    if (is_measured[i] && !chained.held[i]) freedom -= graph.planar ? 3 : 6;
  }
  return std::max(0., freedom);
}

PoseGraphFit TestFit(const PoseGraph& graph, const PoseGraphSummary& summary) {
  PoseGraphFit fit;
  Linearized at(graph, summary);
  ClassSums odometry, loops;
  double prior_error = 0;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (!at.used[i]) continue;
    ClassSums& sums = graph.edges[i].loop ? loops : odometry;
    sums.squared_error += SquaredError(graph, graph.edges[i]);
    sums.rank += RankOf(graph.edges[i].information);
  }
  for (const PoseGraphPrior& prior : graph.priors) {
    prior_error += SquaredError(graph, prior);
  }
  for (const PoseGraphPosition& position : graph.positions) {
    prior_error += SquaredError(graph, position);
  }
  fit.chi_square = odometry.squared_error + loops.squared_error + prior_error;
  fit.degrees_of_freedom = DegreesOfFreedom(graph, ChainPoses(graph), summary.outlier_edges);
  fit.p_value = ChiSquareTail(fit.chi_square, fit.degrees_of_freedom);
  if (at.Factorize() && at.system.jacobian.cols() > 0) {
    EstimateLeverage(graph, at, &odometry, &loops);
    fit.odometry_ratio = odometry.Ratio();
    fit.loop_ratio = loops.Ratio();
  }
  fit.reason = ReasonForDoubt(graph, summary, fit, odometry, loops);
  fit.doubtful = !fit.reason.empty();
  return fit;
}

std::optional<std::vector<Eigen::Matrix<double, 6, 6>>> MarginalCovariances(
    const PoseGraph& graph, const PoseGraphSummary& summary,
    const std::vector<std::size_t>& poses) {
  for (const std::size_t pose : poses) {
    ThrowIf(pose >= graph.poses.size(), "a covariance is requested of pose ", pose,
            ", must be one of ", graph.poses.size());
  }
  Linearized at(graph, summary);
  if (!at.Factorize()) return std::nullopt;
  const int size = graph.planar ? 3 : 6;
  std::vector<Eigen::Matrix<double, 6, 6>> covariances;
  const ChainedPoses chained = ChainPoses(graph);
  for (const std::size_t pose : poses) {
    covariances.emplace_back(Eigen::Matrix<double, 6, 6>::Zero());
    const int first = at.system.first_column[pose];
    if (first < 0) {
      if (!chained.held[pose]) return std::nullopt;
      continue;
    }
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(at.system.jacobian.cols(), size);
    columns.middleRows(first, size).setIdentity();
    const Eigen::MatrixXd block = Eigen::MatrixXd(at.factor.solve(columns)).middleRows(first, size);
    if (graph.planar) {  // parameters are (x, y, angle)
      const int order[] = {3, 4, 2};
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) covariances.back()(order[i], order[j]) = block(i, j);
      }
    } else {
      covariances.back() = block;
    }
  }
  return covariances;
}

}  // namespace surfit
