#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace surfit {

// The positions of finite points in the order of a Z-curve (Morton 1966) through their bounding
// cube: points that follow each other lie near each other, so that searches in a tree over them,
// and with them, find memory in the cache. Fewer than 2^32 points; of equal ones in their order.
std::vector<std::uint32_t> MortonOrder(const std::vector<Eigen::Vector3f>& points);

}  // namespace surfit
