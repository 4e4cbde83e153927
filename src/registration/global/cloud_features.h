#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// Thinned cloud for global registration: one point per occupied cell of a voxel grid.
struct KeyPoints {
  std::vector<Eigen::Vector3f> points;   // centroids of the cells, m
  std::vector<Eigen::Vector3f> normals;  // unit length; (0, 0, 0): no plane
};

// Centroids of the occupied cells of a grid, in the order of the cells. Requires finite points and
// cell_m > 0.
std::vector<Eigen::Vector3f> VoxelCentroids(const std::vector<Eigen::Vector3f>& points,
                                            double cell_m);

// Key points with normals. A plane is fitted to the centroids within 2.5 cells. Normals face
// `viewpoint`.
KeyPoints MakeKeyPoints(const std::vector<Eigen::Vector3f>& points, double cell_m,
                        const Eigen::Vector3d& viewpoint);

// Fast point feature histogram (Rusu, Blodow and Beetz 2009), with the square root of each bin, so
// that Euclidean distances are Hellinger distances.
inline constexpr int kFpfhBins = 33;
using Fpfh = std::array<float, kFpfhBins>;

// Histograms of all key points, from neighbours within the radius. 0 without a normal or without
// neighbours.
std::vector<Fpfh> FindFpfh(const KeyPoints& keys, double radius_m);

// Index pair of a source and a target key point with similar histograms.
struct KeyMatch {
  int source = 0;
  int target = 0;
};

// Nearest histograms, at most `max_count`: mutual matches precede all other matches. Both groups
// are in ascending order of the ratio of the nearest to the second-nearest squared distance. Source
// histograms of 0 have no match.
std::vector<KeyMatch> MatchFpfh(const std::vector<Fpfh>& source, const std::vector<Fpfh>& target,
                                int max_count);

// Pose with the number of matches that agree with it.
struct KeyConsensus {
  Rigid3d target_from_source;
  int inliers = 0;
};

// Poses on which matches agree, most inliers first. Two matches are compatible if the distances of
// their points, and the angles of their normals, agree in both clouds. The matches that share the
// most compatible matches with a seed are fitted (second-order compatibility: Chen et al., SC2-PCR,
// 2022; compare Shi, Yang and Carlone, ROBIN, 2021). `tolerance_m`: distance of an inlier. Similar
// poses are merged. A pose needs three inliers. `matches` begins with the best matches, because
// only the first 1000 are seeds.
std::vector<KeyConsensus> FindKeyConsensus(const KeyPoints& source, const KeyPoints& target,
                                           const std::vector<KeyMatch>& matches, double tolerance_m,
                                           int max_count);

}  // namespace surfit
