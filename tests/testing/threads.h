#pragma once

#include <initializer_list>
#include <vector>

#include "surfit/core/parallel.h"

namespace surfit::testing {

// Results of a call with each of these numbers of threads, in this order.
template <typename Call>
auto AtThreads(std::initializer_list<int> thread_counts, const Call& call) {
  std::vector<decltype(call())> results;
  for (const int threads : thread_counts) {
    const ThreadLimit limit(threads);
    results.push_back(call());
  }
  return results;
}

}  // namespace surfit::testing
