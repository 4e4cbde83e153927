#include "apps/export/image_poses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "apps/export/color_lens.h"
#include "core/median.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using Vector6 = Rigid3d::Vector6;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct Level {
  int halvings, rounds;
};
constexpr Level kLevels[] = {{2, 3}, {1, 3}, {0, 4}};
constexpr int kFinest = 2;                // index in kLevels
constexpr int kMaxColumnsOfLevel = 1000;  // of the finest level
constexpr int kMaxImagesOfGroup = 300;    // per group
constexpr int kStepsPerRound = 2;         // of Gauss-Newton
constexpr int kMinImagesOfSurfel = 4;     // that show a surfel
constexpr int kMinSurfelsOfImage = 200;   // of an image
constexpr double kSharedSurfels = 25;     // number of neighbouring surfels with correlated errors
constexpr double kTracked_m = 0.002, kTracked_rad = 0.005;  // errors of tracked poses
constexpr double kMaxRmsRatio = 0.95;  // RMS residual after / before; exact poses reach 0.99
constexpr double kMaxDistance2 = 38;   // chi-square, 6 degrees of freedom, probability 1e-6
constexpr float kOutside = std::numeric_limits<float>::quiet_NaN();

// Kernel of Geman and McClure.
double KernelWeight(double residual, double scale) {
  const double share = residual / scale, s = 1 + share * share;
  return 1 / (s * s);
}
double KernelCost(double residual, double scale) {
  const double r2 = residual * residual;
  return r2 / (1 + r2 / (scale * scale));
}

// Surfel of an image.
struct Visible {
  std::int32_t surfel = 0;
  double after_middle_s = 0;  // capture time of its row after that of the middle row
};

// Image with its brightness and its poses, which transform points from the world to the camera.
struct RegisteredImage {
  Rigid3d tracked, pose;
  CameraMotion motion;
  std::vector<Image<float>> levels;
  std::vector<Visible> surfels;
  std::vector<float> values;  // brightness of `surfels` at `pose`, kOutside beyond the border

  Vector6 Change() const { return FirstOrderIncrement(tracked, pose); }
};

Vector6 PriorInformation() {
  Vector6 information;
  information << Eigen::Vector3d::Constant(1 / (kTracked_rad * kTracked_rad)),
      Eigen::Vector3d::Constant(1 / (kTracked_m * kTracked_m));
  return information;
}

// Robust mean brightness of each surfel over the images.
class SurfelBrightness {
 public:
  explicit SurfelBrightness(std::size_t surfels) : sums_(surfels), means_(surfels) {}

  void Update(const std::vector<RegisteredImage>& images) {
    scale_ = 0;
    SumUp(images);
    std::vector<double> residuals;
    ForEach(images, [&](std::int32_t k, double value) {
      if (Has(k)) residuals.push_back(std::abs(value - means_[k]));
    });
    constexpr double kSigmasOfMedian = 1.48, kMinScale = 1e-4;
    scale_ = std::max(kMinScale, 3 * kSigmasOfMedian * MedianOf(std::move(residuals)));
    for (int pass = 0; pass < 2; ++pass) SumUp(images);
    double squares = 0, weights = 1e-12;
    ForEach(images, [&](std::int32_t k, double value) {
      if (!Has(k)) return;
      const double residual = value - means_[k], weight = KernelWeight(residual, scale_);
      squares += weight * residual * residual;
      weights += weight;
    });
    rms_ = std::max(kMinScale / 3, std::sqrt(squares / weights));
  }

  // True if enough images show the surfel.
  bool Has(std::int32_t k) const { return sums_[k].images >= kMinImagesOfSurfel; }
  double Residual(std::int32_t k, double value) const { return value - means_[k]; }
  double scale() const { return scale_; }  // width of the kernel
  double rms() const { return rms_; }

 private:
  struct Sum {
    double value = 0, weight = 0;
    int images = 0;
  };

  template <typename Call>
  static void ForEach(const std::vector<RegisteredImage>& images, const Call& call) {
    for (const RegisteredImage& image : images) {
      for (std::size_t j = 0; j < image.surfels.size(); ++j) {
        if (!std::isnan(image.values[j])) call(image.surfels[j].surfel, image.values[j]);
      }
    }
  }

  // New means. The weights are those of the former means, or 1 if the scale is 0.
  void SumUp(const std::vector<RegisteredImage>& images) {
    std::fill(sums_.begin(), sums_.end(), Sum());
    ForEach(images, [&](std::int32_t k, double value) {
      const double weight = scale_ == 0 ? 1 : KernelWeight(value - means_[k], scale_);
      sums_[k].value += weight * value;
      sums_[k].weight += weight;
      ++sums_[k].images;
    });
    for (std::size_t k = 0; k < sums_.size(); ++k) {
      means_[k] = sums_[k].value / std::max(1e-12, sums_[k].weight);
    }
  }

  std::vector<Sum> sums_;
  std::vector<double> means_;
  double scale_ = 0, rms_ = 0;
};

// Group of images that are registered to each other.
class ImageGroup {
 public:
  ImageGroup(const ColorCamera& camera, const SurfelMap& map, std::vector<PosedImage> images)
      : camera_(camera),
        posed_(std::move(images)),
        points_(FindSparsePoints(map, camera.lens, posed_)),
        brightness_(points_.points.size()),
        images_(posed_.size()) {
    while ((camera.lens.width >> skipped_halvings_) > kMaxColumnsOfLevel) ++skipped_halvings_;
    for (std::size_t i = 0; i < images_.size(); ++i) {
      RegisteredImage& image = images_[i];
      image.tracked = image.pose = posed_[i].world_from_color.Inverse();
      image.motion = MotionOfColorCamera(posed_[i].source.motion, camera.color_from_depth);
      for (const PointView& view : points_.views[i]) {
        const double rows = (view.pixel.y() + 0.5) / camera.lens.height - 0.5;
        image.surfels.push_back({view.point, rows * camera.readout_s});
      }
    }
  }

  // Reads the images, and finds their poses.
  void Register(const ColorReader& read, const std::function<void(int)>& progress) {
    std::vector<ColorImage> sources;
    for (const PosedImage& image : posed_) sources.push_back(image.source);
    read(sources, [&](std::size_t i, const Image<Rgb8>& color) {
      progress(static_cast<int>(i));
      std::vector<int> halvings;
      for (const Level& level : kLevels) halvings.push_back(level.halvings + skipped_halvings_);
      images_[i].levels = FilteredBrightness(color, halvings);
    });
    UpdateBrightness(kFinest);
    rms_before_ = brightness_.rms();
    for (int level = 0; level <= kFinest; ++level) {
      for (int round = 0; round < kLevels[level].rounds; ++round) {
        UpdateBrightness(level);
        ForEachImage([&](RegisteredImage* image) { Align(level, image); });
      }
    }
    UpdateBrightness(kFinest);
  }

  // Takes over the poses of images that are registered, and counts images by outcome.
  void Finish(const std::function<void(std::size_t, const Rigid3d&)>& take,
              std::vector<double>* changes_m, std::vector<double>* changes_rad,
              ImageRegistration* result) const {
    const bool has_gain = brightness_.rms() <= kMaxRmsRatio * rms_before_;
    for (std::size_t i = 0; i < images_.size(); ++i) {
      const RegisteredImage& image = images_[i];
      const Vector6 change = image.Change();
      if (SurfelCount(image) < kMinSurfelsOfImage) {
        ++result->too_few_surfels;
      } else if (!(change.dot(PriorInformation().cwiseProduct(change)) < kMaxDistance2)) {
        ++result->contradicting;
      } else if (!has_gain || !(Cost(image, image.pose) < Cost(image, image.tracked))) {
        ++result->without_gain;
      } else {
        ++result->registered;
        changes_rad->push_back(change.head<3>().norm());
        changes_m->push_back(change.tail<3>().norm());
        take(i, image.pose.Inverse());
      }
    }
  }

  double rms_before() const { return rms_before_; }
  double rms_after() const { return brightness_.rms(); }

 private:
  struct Seen {
    BrightnessSample sample;
    Eigen::Vector3d point;     // in the camera at the capture time of its row
    Eigen::Vector3d by_point;  // derivative of the brightness, 1/m
  };

  void ForEachImage(const std::function<void(RegisteredImage*)>& call) {
    ParallelFor(0, static_cast<int>(images_.size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) call(&images_[i]);
    });
  }

  std::optional<Seen> SeenAt(const RegisteredImage& image, int level, const Rigid3d& pose,
                             const Visible& visible) const {
    const Eigen::Vector3d at_middle =
        pose * points_.points[visible.surfel].position_in_world.cast<double>();
    const CameraMotion& motion = image.motion;
    const Eigen::Vector3d point =
        at_middle - visible.after_middle_s * (motion.angular_velocity_rad_per_s.cross(at_middle) +
                                              motion.velocity_m_per_s);
    const std::optional<LensPoint> seen = ProjectByLens(camera_.lens, point);
    if (!seen) return {};
    const std::optional<BrightnessSample> sample =
        BrightnessAt(image.levels[level], kLevels[level].halvings + skipped_halvings_, seen->pixel);
    if (!sample) return {};
    return Seen{*sample, point, seen->by_point.transpose() * sample->slope};
  }

  void UpdateBrightness(int level) {
    ForEachImage([&](RegisteredImage* image) {
      image->values.clear();
      for (const Visible& visible : image->surfels) {
        const std::optional<Seen> seen = SeenAt(*image, level, image->pose, visible);
        image->values.push_back(seen ? static_cast<float>(seen->sample.value) : kOutside);
      }
    });
    brightness_.Update(images_);
  }

  // Number of surfels with a mean brightness.
  int SurfelCount(const RegisteredImage& image) const {
    return static_cast<int>(
        std::count_if(image.surfels.begin(), image.surfels.end(),
                      [&](const Visible& visible) { return brightness_.Has(visible.surfel); }));
  }

  // Gauss-Newton steps of one image, with the current brightness of surfels.
  void Align(int level, RegisteredImage* image) const {
    if (SurfelCount(*image) < kMinSurfelsOfImage) return;
    const double unit = 1 / (brightness_.rms() * brightness_.rms() * kSharedSurfels);
    for (int step = 0; step < kStepsPerRound; ++step) {
      Matrix6 hessian = PriorInformation().asDiagonal();
      Vector6 gradient = PriorInformation().cwiseProduct(image->Change());
      for (const Visible& visible : image->surfels) {
        if (!brightness_.Has(visible.surfel)) continue;
        const std::optional<Seen> seen = SeenAt(*image, level, image->pose, visible);
        if (!seen) continue;
        const double residual = brightness_.Residual(visible.surfel, seen->sample.value);
        const double weight = unit * KernelWeight(residual, brightness_.scale());
        Vector6 jacobian;
        jacobian << seen->point.cross(seen->by_point), seen->by_point;
        hessian += weight * jacobian * jacobian.transpose();
        gradient += weight * residual * jacobian;
      }
      const Vector6 motion = hessian.ldlt().solve(-gradient);
      image->pose = LeftIncrement<double>(motion, image->pose);
    }
  }

  // Mean cost of the residuals in the finest image.
  double Cost(const RegisteredImage& image, const Rigid3d& pose) const {
    double sum = 0, count = 1e-12;
    for (const Visible& visible : image.surfels) {
      if (!brightness_.Has(visible.surfel)) continue;
      const std::optional<Seen> seen = SeenAt(image, kFinest, pose, visible);
      if (!seen) continue;
      sum +=
          KernelCost(brightness_.Residual(visible.surfel, seen->sample.value), brightness_.scale());
      ++count;
    }
    return sum / count;
  }

  const ColorCamera& camera_;
  const std::vector<PosedImage> posed_;
  const SparsePoints points_;
  SurfelBrightness brightness_;
  std::vector<RegisteredImage> images_;
  int skipped_halvings_ = 0;  // number of halvings from the image to the finest level
  double rms_before_ = 0;
};

}  // namespace

CameraMotion MotionOfColorCamera(const CameraMotion& motion, const Rigid3d& color_from_depth) {
  const Eigen::Vector3d origin_in_depth = color_from_depth.Inverse().translation;
  CameraMotion result;
  result.angular_velocity_rad_per_s = color_from_depth.rotation * motion.angular_velocity_rad_per_s;
  result.velocity_m_per_s =
      color_from_depth.rotation *
      (motion.velocity_m_per_s + motion.angular_velocity_rad_per_s.cross(origin_in_depth));
  return result;
}

ImageRegistration RegisterImages(const ColorCamera& camera, const SurfelMap& map,
                                 const ColorReader& read, const std::function<void(int)>& progress,
                                 std::vector<PosedImage>* images) {
  const std::size_t groups = (images->size() + kMaxImagesOfGroup - 1) / kMaxImagesOfGroup;
  ImageRegistration result;
  std::vector<double> changes_m, changes_rad;
  for (std::size_t first = 0; first < groups; ++first) {
    std::vector<PosedImage> part;
    for (std::size_t i = first; i < images->size(); i += groups) part.push_back((*images)[i]);
    ImageGroup group(camera, map, std::move(part));
    group.Register(read,
                   [&](int i) { progress(static_cast<int>(first * images->size() / groups) + i); });
    group.Finish(
        [&](std::size_t i, const Rigid3d& pose) {
          (*images)[first + i * groups].world_from_color = pose;
        },
        &changes_m, &changes_rad, &result);
    result.rms_before += group.rms_before() / static_cast<double>(groups);
    result.rms_after += group.rms_after() / static_cast<double>(groups);
  }
  result.median_change_m = MedianOf(std::move(changes_m));
  result.median_change_rad = MedianOf(std::move(changes_rad));
  return result;
}

}  // namespace surfit
