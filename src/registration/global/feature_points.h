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

// Points that can be found again in another image, with what they look like.
struct FeaturePoints {
  std::vector<Eigen::Vector3d> points;  // in the camera's frame, metres
  std::vector<double> sigmas_m;         // standard deviation of each, in any direction
  std::vector<BinaryDescriptor> descriptors;

  int size() const { return static_cast<int>(points.size()); }
};

// The depth of the surface at a pixel: the median of the valid neighbours; 0 without any.
double DepthOfFeature(const Image<float>& depth_m, double u, double v);

// Of a feature in an image from elsewhere.
inline constexpr double kFeaturePlaceSigmaPx = 1.5;

// Standard deviation in metres, in any direction, of a point at this depth, of which images tell
// the place to so many pixels.
double SigmaOfFeature(double depth_m, double place_sigma_px, const DepthSensor& sensor,
                      const ErrorModel& error_model);

// ORB features (Rublee et al. 2011) of the image, the strongest of each cell of a grid, lifted by
// the depth of the surface that it shares pixels with. Features without depth are left out. At most
// `max_count`; none where there is no colour.
FeaturePoints FindFeatures(const Image<Rgb8>& color, const FrameLevel& surface,
                           const ErrorModel& error_model, int max_count);

// Indices of a source and a target feature that look alike.
struct FeatureMatch {
  int source = 0;
  int target = 0;
};

// Features whose descriptors are each other's nearest, near enough, and nearer than the second
// nearest by a clear ratio. What wrong ones remain is for consensus to tell.
std::vector<FeatureMatch> MatchFeatures(const FeaturePoints& source, const FeaturePoints& target);

// A pose, and the matches that agree with it.
struct Consensus {
  Rigid3d target_from_source;
  std::vector<int> inliers;  // indices of the matches, ascending
};

// The pose that brings the matched source points to their target points by weighted least squares
// (Kabsch 1976; Umeyama 1991 without scale), weights from the points' sigmas. At least three of
// `used`, not on a line.
Rigid3d FitPose(const FeaturePoints& source, const FeaturePoints& target,
                const std::vector<FeatureMatch>& matches, const std::vector<int>& used);

// How many samples are drawn.
inline constexpr int kConsensusSamples = 20000;

// Random sample consensus (Fischler and Bolles 1981) with three matches a sample, drawn from a
// fixed seed: the poses that most matches agree with (four at least, within three sigmas), refined
// on these, the best first, at most `max_count`. Poses that share half of their inliers are one.
// At most `max_tries` samples whose sides are as long in both views are tried, of all that are
// drawn.
std::vector<Consensus> FindConsensus(const FeaturePoints& source, const FeaturePoints& target,
                                     const std::vector<FeatureMatch>& matches, int max_count,
                                     int max_tries = kConsensusSamples);

// Brightness (0 = black, 1 = white), each image half as wide as the one before.
using GreyPyramid = std::vector<Image<float>>;

GreyPyramid MakeGreyPyramid(const Image<Rgb8>& color);

// Pixels whose surroundings can be found again in another image: those where brightness changes
// most in all directions (Shi and Tomasi 1994), where there is depth, not near each other, the
// strongest first, at most `max_count`.
std::vector<Eigen::Vector2f> FindCorners(const GreyPyramid& grey, const Image<float>& depth_m,
                                         int max_count);

// Corners that are followed from image to image by their patches (Lucas and Kanade 1981, inverse
// compositional: Baker and Matthews 2004), coarse to fine, gain and offset of the brightness taken
// out.
class CornerTracks {
 public:
  CornerTracks() = default;
  CornerTracks(GreyPyramid first, std::vector<Eigen::Vector2f> corners);

  struct Track {
    int corner;                   // its index
    Eigen::Vector2f first, last;  // px, in the first and in the last image
  };
  using Expect = std::function<Eigen::Vector2f(const Track&)>;

  // Goes on to the next image, where a corner is looked for from `expect(track)` on, px, in about a
  // dozen pixels. Corners that are not found are lost.
  void Follow(GreyPyramid next, const Expect& expect);

  // Of the corners that still look as in the first image.
  std::vector<Track> Lasting() const;

 private:
  GreyPyramid first_, last_;
  std::vector<Track> tracks_;
};

}  // namespace surfit
