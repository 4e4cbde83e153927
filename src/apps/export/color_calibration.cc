#include "apps/export/color_calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "apps/export/color_lens.h"
#include "apps/export/map_visibility.h"
#include "output/pictures/pictures.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using ColorMatrix = Eigen::Matrix<double, kColorParameters, kColorParameters>;

constexpr int kImages = 120;  // maximum number of images
constexpr int kMinImages = 10;
constexpr int kSurfels = 40000;   // maximum number of surfels
constexpr int kMinSurfels = 500;  // with at least kMinViews views
constexpr int kMinViews = 4;
constexpr int kVisibilityColumns = 160;
constexpr int kGrain = 256;
constexpr int kCoarseIterations = 5, kFineIterations = 8;
constexpr int kHalvings[] = {3, 2, 1, 0};  // number of image halvings, per level
// Number of neighbouring observations with fully correlated errors.
constexpr double kSharedObservations = 25;

// Filtered log brightness of an image at several resolutions.
using BrightnessLevels = std::vector<Image<float>>;

// A surfel with the images that show it.
struct SeenSurfel {
  Eigen::Vector3d position;
  std::vector<int> views;
};

struct NormalEquations {
  ColorMatrix hessian = ColorMatrix::Zero();
  ColorParameters gradient = ColorParameters::Zero();
  double weighted_squares = 0, weights = 0;
  std::size_t observations = 0;

  NormalEquations& operator+=(const NormalEquations& other) {
    hessian += other.hessian;
    gradient += other.gradient;
    weighted_squares += other.weighted_squares;
    weights += other.weights;
    observations += other.observations;
    return *this;
  }
  double Rms() const { return std::sqrt(weighted_squares / std::max(weights, 1e-9)); }
};

struct ColorState {
  ColorCamera camera;
  double latency_s = 0;

  void Add(const ColorParameters& step) {
    camera.color_from_depth = LeftIncrement<double>(step.head<6>(), camera.color_from_depth);
    camera.lens.fx *= 1 + step[6];
    camera.lens.fy *= 1 + step[7];
    camera.lens.cx += step[8];
    camera.lens.cy += step[9];
    latency_s += step[10];
  }
  ColorParameters ChangeFrom(const ColorState& given) const {
    ColorParameters change;
    const Rigid3d motion = camera.color_from_depth * given.camera.color_from_depth.Inverse();
    change << QuaternionLog(motion.rotation), motion.translation,
        camera.lens.fx / given.camera.lens.fx - 1, camera.lens.fy / given.camera.lens.fy - 1,
        camera.lens.cx - given.camera.lens.cx, camera.lens.cy - given.camera.lens.cy,
        latency_s - given.latency_s;
    return change;
  }
};

class ColorProblem {
 public:
  ColorProblem(std::vector<ColorImage> images, std::vector<BrightnessLevels> levels,
               std::vector<SeenSurfel> surfels)
      : images_(std::move(images)), levels_(std::move(levels)), surfels_(std::move(surfels)) {
    for (const ColorImage& image : images_) {
      depth_from_world_.push_back(image.world_from_depth.Inverse());
    }
  }

  // Normal equations at `state`. `scale`: width of the kernel. With `by_image`, adds the gradient
  // of each image.
  NormalEquations Linearize(const ColorState& state, int level, double scale,
                            std::vector<ColorParameters>* by_image = nullptr) const {
    const int count = static_cast<int>(surfels_.size());
    const int blocks = (count + kGrain - 1) / kGrain;
    std::vector<std::vector<ColorParameters>> parts(by_image ? blocks : 0);
    NormalEquations sum = ParallelSum(0, count, kGrain, NormalEquations(), [&](int begin, int end) {
      NormalEquations part;
      std::vector<ColorParameters>* gradients = nullptr;
      if (by_image) {
        gradients = &parts[begin / kGrain];
        gradients->assign(images_.size(), ColorParameters::Zero());
      }
      for (int i = begin; i < end; ++i) {
        AddSurfel(surfels_[i], state, level, scale, &part, gradients);
      }
      return part;
    });
    for (const auto& part : parts) {
      for (std::size_t i = 0; i < part.size(); ++i) (*by_image)[i] += part[i];
    }
    return sum;
  }

  std::size_t image_count() const { return images_.size(); }

 private:
  struct Row {
    int image;
    double value;
    ColorParameters jacobian;
  };

  void AddSurfel(const SeenSurfel& surfel, const ColorState& state, int level, double scale,
                 NormalEquations* sum, std::vector<ColorParameters>* by_image) const {
    std::vector<Row> rows;
    rows.reserve(surfel.views.size());
    for (const int image : surfel.views) {
      if (std::optional<Row> row = RowOf(surfel.position, image, state, level)) {
        rows.push_back(*row);
      }
    }
    if (static_cast<int>(rows.size()) < kMinViews) return;
    double mean = 0;
    for (const Row& row : rows) mean += row.value / static_cast<double>(rows.size());
    std::vector<double> weights(rows.size());
    // One step of reweighting makes the mean robust.
    for (int pass = 0; pass < 2; ++pass) {
      double weighted = 0, total = 1e-12;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const double share = (rows[i].value - mean) / scale, s = 1 + share * share;
        weights[i] = 1 / (s * s);
        weighted += weights[i] * rows[i].value;
        total += weights[i];
      }
      mean = weighted / total;
    }
    ColorParameters mean_jacobian = ColorParameters::Zero();
    double total = 1e-12;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      mean_jacobian += weights[i] * rows[i].jacobian;
      total += weights[i];
    }
    mean_jacobian /= total;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const ColorParameters jacobian = rows[i].jacobian - mean_jacobian;
      const double residual = rows[i].value - mean;
      sum->hessian.selfadjointView<Eigen::Lower>().rankUpdate(jacobian, weights[i]);
      sum->gradient += weights[i] * residual * jacobian;
      sum->weighted_squares += weights[i] * residual * residual;
      sum->weights += weights[i];
      ++sum->observations;
      if (by_image) (*by_image)[rows[i].image] += weights[i] * residual * jacobian;
    }
  }

  std::optional<Row> RowOf(const Eigen::Vector3d& point_in_world, int i, const ColorState& state,
                           int level) const {
    const ColorImage& image = images_[i];
    const PinholeCamera& lens = state.camera.lens;
    const Rigid3d& color_from_depth = state.camera.color_from_depth;
    const Eigen::Vector3d in_depth = depth_from_world_[i] * point_in_world;
    // The row of the point is captured `shift_s` after the pose of the image.
    const Eigen::Vector3d velocity =
        -(image.motion.angular_velocity_rad_per_s.cross(in_depth) + image.motion.velocity_m_per_s);
    double shift_s = -state.latency_s;
    std::optional<LensPoint> seen;
    for (int pass = 0; pass < 2; ++pass) {
      seen = ProjectByLens(lens, color_from_depth * (in_depth + shift_s * velocity));
      if (!seen) return {};
      shift_s =
          -state.latency_s + ((seen->pixel.y() + 0.5) / lens.height - 0.5) * state.camera.readout_s;
    }
    const Eigen::Vector3d moved = in_depth + shift_s * velocity;
    const Eigen::Vector3d x = color_from_depth * moved;
    seen = ProjectByLens(lens, x);
    if (!seen) return {};
    const std::optional<BrightnessSample> value =
        BrightnessAt(levels_[i][level], kHalvings[level], seen->pixel);
    if (!value) return {};
    const Eigen::RowVector2d by_pixel = value->slope.transpose();
    const Eigen::RowVector3d by_point = by_pixel * seen->by_point;
    Row row;
    row.image = i;
    row.value = value->value;
    row.jacobian.head<3>() = x.cross(by_point.transpose());
    row.jacobian.segment<3>(3) = by_point.transpose();
    row.jacobian[6] = by_pixel[0] * lens.fx * seen->distorted.x();
    row.jacobian[7] = by_pixel[1] * lens.fy * seen->distorted.y();
    row.jacobian[8] = by_pixel[0];
    row.jacobian[9] = by_pixel[1];
    row.jacobian[10] = -by_point.dot(color_from_depth.rotation * velocity);
    return row;
  }

  std::vector<ColorImage> images_;
  std::vector<Rigid3d> depth_from_world_;
  std::vector<BrightnessLevels> levels_;
  std::vector<SeenSurfel> surfels_;
};

std::vector<SeenSurfel> SurfelsInImages(const ColorCamera& camera,
                                        const std::vector<ColorImage>& images,
                                        const SurfelMap& map) {
  const std::vector<Surfel> reliable = ReliableSurfels(map);
  const std::size_t stride = std::max<std::size_t>(1, (reliable.size() + kSurfels - 1) / kSurfels);
  std::vector<SeenSurfel> surfels;
  std::vector<Eigen::Vector3d> normals;
  for (std::size_t i = 0; i < reliable.size(); i += stride) {
    surfels.push_back({reliable[i].position_in_world.cast<double>(), {}});
    normals.emplace_back(reliable[i].normal_in_world.cast<double>());
  }
  MapDepth depth(map, camera.lens, kVisibilityColumns);
  for (std::size_t image = 0; image < images.size(); ++image) {
    const Rigid3d world_from_color =
        images[image].world_from_depth * camera.color_from_depth.Inverse();
    depth.Render(world_from_color);
    const Rigid3d color_from_world = world_from_color.Inverse();
    for (std::size_t i = 0; i < surfels.size(); ++i) {
      if (depth.IsVisible(color_from_world * surfels[i].position,
                          color_from_world.rotation * normals[i])) {
        surfels[i].views.push_back(static_cast<int>(image));
      }
    }
  }
  surfels.erase(std::remove_if(surfels.begin(), surfels.end(),
                               [](const SeenSurfel& surfel) {
                                 return static_cast<int>(surfel.views.size()) < kMinViews;
                               }),
                surfels.end());
  return surfels;
}

ColorParameters PriorInformation(const CalibrationPrior& prior) {
  const auto information = [](double sigma) { return sigma > 0 ? 1 / (sigma * sigma) : 0; };
  ColorParameters diagonal;
  diagonal.head<3>().setConstant(information(prior.color_rotation_rad));
  diagonal.segment<3>(3).setConstant(information(prior.color_translation_m));
  diagonal.segment<2>(6).setConstant(information(prior.focal_relative_sigma));
  diagonal.segment<2>(8).setConstant(information(prior.center_px));
  diagonal[10] = information(prior.color_latency_s);
  return diagonal;
}

class ColorSolver {
 public:
  ColorSolver(const ColorProblem& problem, const ColorState& given, const CalibrationPrior& prior)
      : problem_(problem), given_(given), prior_(prior) {}

  // Returns false if a system cannot be solved.
  bool Solve(ColorCalibration* result) {
    const int levels = static_cast<int>(std::size(kHalvings));
    double scale = 0;
    ColorState state = given_;
    for (int level = 0; level < levels; ++level) {
      scale = ScaleAt(given_, level);
      const int iterations = level + 1 < levels ? kCoarseIterations : kFineIterations;
      for (int i = 0; i < iterations; ++i) {
        const NormalEquations system = problem_.Linearize(state, level, scale);
        if (system.observations == 0) return false;
        const ColorParameters step = StepOf(system, state);
        if (!step.allFinite()) return false;
        state.Add(step);
      }
    }
    Judge(state, levels - 1, scale, result);
    return true;
  }

 private:
  // Width of the kernel: three times the robust RMS of the residuals.
  double ScaleAt(const ColorState& state, int level) const {
    double scale = 1;
    for (int pass = 0; pass < 3; ++pass) {
      scale = 3 * std::max(1e-4, problem_.Linearize(state, level, scale).Rms());
    }
    return scale;
  }

  // Information of one observation, in units of the residual.
  static double WeightOf(const NormalEquations& system) {
    const double rms = std::max(system.Rms(), 1e-6);
    return 1 / (rms * rms * kSharedObservations);
  }

  ColorMatrix HessianOf(const NormalEquations& system) const {
    ColorMatrix hessian =
        WeightOf(system) * ColorMatrix(system.hessian.selfadjointView<Eigen::Lower>());
    hessian.diagonal() += PriorInformation(prior_);
    AddAspect(&hessian);
    return hessian;
  }

  // Adds the prior of fx / fy.
  void AddAspect(ColorMatrix* hessian) const {
    if (!(prior_.aspect_relative_sigma > 0)) return;
    const double information = 1 / std::pow(prior_.aspect_relative_sigma, 2);
    (*hessian)(6, 6) += information;
    (*hessian)(7, 7) += information;
    (*hessian)(6, 7) -= information;
    (*hessian)(7, 6) -= information;
  }

  ColorParameters StepOf(const NormalEquations& system, const ColorState& state) const {
    const ColorParameters change = state.ChangeFrom(given_);
    ColorMatrix prior = ColorMatrix::Zero();
    prior.diagonal() = PriorInformation(prior_);
    AddAspect(&prior);
    const ColorParameters gradient = WeightOf(system) * system.gradient + prior * change;
    return HessianOf(system).ldlt().solve(-gradient);
  }

  void Judge(const ColorState& state, int level, double scale, ColorCalibration* result) const {
    std::vector<ColorParameters> by_image(problem_.image_count(), ColorParameters::Zero());
    const NormalEquations system = problem_.Linearize(state, level, scale, &by_image);
    ColorMatrix scatter = ColorMatrix::Zero();
    const double weight = WeightOf(system);
    for (const ColorParameters& gradient : by_image) {
      scatter += weight * weight * gradient * gradient.transpose();
    }
    const ColorMatrix inverse = HessianOf(system).inverse();
    // Gradient covariance: the scatter over the images plus the information of the prior.
    ColorMatrix prior = ColorMatrix::Zero();
    prior.diagonal() = PriorInformation(prior_);
    AddAspect(&prior);
    const ColorMatrix covariance = inverse * (scatter + prior) * inverse;
    result->change = state.ChangeFrom(given_);
    result->sigmas = covariance.diagonal().cwiseMax(0).cwiseSqrt();
    result->distance2 = result->change.dot(covariance.ldlt().solve(result->change));
    result->limit2 = kColorParameters + 3 * std::sqrt(2. * kColorParameters);
    result->rms_before = problem_.Linearize(given_, level, scale).Rms();
    result->rms_after = system.Rms();
    result->observations = system.observations;
    result->is_estimated =
        result->distance2 > result->limit2 && result->rms_after < result->rms_before;
    if (!result->is_estimated) return;
    result->camera = state.camera;
    result->latency_s = state.latency_s;
  }

  const ColorProblem& problem_;
  const ColorState given_;
  const CalibrationPrior& prior_;
};

}  // namespace

ColorCalibration EstimateColorCamera(const ColorCamera& given, const CalibrationPrior& prior,
                                     const SequenceOptions& sequence,
                                     const std::vector<ColorImage>& images, const SurfelMap& map,
                                     const std::function<void(int)>& progress) {
  ColorCalibration result;
  result.camera = given;
  std::vector<ColorImage> chosen = ChooseImages(images, kImages);
  if (static_cast<int>(chosen.size()) < kMinImages) return result;
  std::vector<SeenSurfel> surfels = SurfelsInImages(given, chosen, map);
  if (static_cast<int>(surfels.size()) < kMinSurfels) return result;
  std::vector<BrightnessLevels> levels;
  ReadColorImages(sequence, chosen, [&](std::size_t i, const Image<Rgb8>& color) {
    progress(static_cast<int>(i));
    levels.push_back(FilteredBrightness(color, {std::begin(kHalvings), std::end(kHalvings)}));
  });
  result.images = static_cast<int>(chosen.size());
  const ColorProblem problem(std::move(chosen), std::move(levels), std::move(surfels));
  ColorSolver(problem, {given, 0}, prior).Solve(&result);
  return result;
}

}  // namespace surfit
