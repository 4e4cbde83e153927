#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/binary_descriptor.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// Image features with depth, as structure of arrays.
struct FeaturePoints {
  std::vector<Eigen::Vector3d> points;  // in the camera frame, m
  std::vector<double> sigmas_m;         // isotropic standard deviation
  std::vector<BinaryDescriptor> descriptors;

  int size() const { return static_cast<int>(points.size()); }
};

// Depth of a pixel, m: median of the valid depths in its 5 x 5 neighbourhood; 0: no valid depth.
double DepthOfFeature(const Image<float>& depth_m, double u, double v);

// Standard deviation of the image position of a feature, px.
inline constexpr double kFeaturePlaceSigmaPx = 1.5;

// Isotropic standard deviation in m of a point at this depth, for an image position with the
// standard deviation `place_sigma_px`.
double SigmaOfFeature(double depth_m, double place_sigma_px, const DepthSensor& sensor,
                      const ErrorModel& error_model);

// ORB features (Rublee et al. 2011) with depth, at most `max_count`. Selects the strongest features
// per cell of a grid. `color` must be registered to `surface`. Empty without colour.
FeaturePoints FindFeatures(const Image<Rgb8>& color, const FrameLevel& surface,
                           const ErrorModel& error_model, int max_count);

// Index pair of a source and a target feature with similar descriptors.
struct FeatureMatch {
  int source = 0;
  int target = 0;
};

// Mutually nearest descriptors that pass the distance threshold and the ratio test. The result
// still contains outliers.
std::vector<FeatureMatch> MatchFeatures(const FeaturePoints& source, const FeaturePoints& target);

// Pose that a set of feature matches supports.
struct Consensus {
  Rigid3d target_from_source;
  std::vector<int> inliers;  // indices of the matches, ascending
};

// Weighted least-squares fit of the source points to the target points (Kabsch 1976; Umeyama 1991
// without scale). Weights follow from the standard deviations. `used` needs at least three matches
// that are not collinear.
Rigid3d FitPose(const FeaturePoints& source, const FeaturePoints& target,
                const std::vector<FeatureMatch>& matches, const std::vector<int>& used);

inline constexpr int kConsensusSamples = 20000;

// RANSAC (Fischler and Bolles 1981) with samples of three matches and a fixed seed. Returns up to
// `max_count` refined poses, in descending order of inliers before refinement. A pose needs four
// inliers within three sigmas. Empty for fewer than four matches. Poses that share more than half
// of their inliers are duplicates. At most `max_tries` samples with equal side lengths in both
// views are evaluated.
std::vector<Consensus> FindConsensus(const FeaturePoints& source, const FeaturePoints& target,
                                     const std::vector<FeatureMatch>& matches, int max_count,
                                     int max_tries = kConsensusSamples);

// Brightness (0: black, 1: white). Each level has half the resolution of the previous one.
using GreyPyramid = std::vector<Image<float>>;

// Pyramid of three levels. `color` must not be empty.
GreyPyramid MakeGreyPyramid(const Image<Rgb8>& color);

// Corners (Shi and Tomasi 1994) at pixels with valid depth, with a minimum spacing. Returns up to
// `max_count` corners in px, the strongest first. `depth_m` (0: missing) must have the size of the
// finest level, which is not checked.
std::vector<Eigen::Vector2f> FindCorners(const GreyPyramid& grey, const Image<float>& depth_m,
                                         int max_count);

// Tracks corners (px of the finest level) from image to image of one size (Lucas and Kanade 1981;
// inverse compositional: Baker and Matthews 2004). Works coarse to fine and is invariant to gain
// and offset of the brightness.
class CornerTracks {
 public:
  CornerTracks() = default;
  CornerTracks(GreyPyramid first, std::vector<Eigen::Vector2f> corners);

  struct Track {
    int corner;                   // index of the corner
    Eigen::Vector2f first, last;  // position in the first and the last image, px
  };
  using Expect = std::function<Eigen::Vector2f(const Track&)>;

  // Tracks all corners to the next image, from the initial position `expect(track)` in px. The
  // search range is 12 px per pyramid level. Corners that are not found are removed. `next` must
  // have the size of the first image. `expect` is called from several threads and must not be null.
  void Follow(GreyPyramid next, const Expect& expect);

  // Corners found in all images so far.
  const std::vector<Track>& tracks() const { return tracks_; }

  // Corners whose patches still match the first image, refined by that match. A second match starts
  // at `expect(track)`, and the better match is used, because tracks can jump between repetitions
  // of a texture. Lost corners are not removed.
  std::vector<Track> Lasting(const Expect& expect) const;

 private:
  GreyPyramid first_, last_;
  std::vector<Track> tracks_;
};

}  // namespace surfit
