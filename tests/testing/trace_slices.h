#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace surfit::testing {

// Slice of a trace file.
struct Slice {
  std::string name;
  int frame = -1;
  int thread = 0;
  std::int64_t begin_ns = 0, end_ns = 0;
};

// Slices of a trace file in order of their end. Other events must be thread names.
inline std::vector<Slice> ReadSlices(const std::string& path) {
  std::ifstream file(path);
  const auto ns = [](const nlohmann::json& microseconds) {
    return static_cast<std::int64_t>(std::llround(1000 * microseconds.get<double>()));
  };
  std::vector<Slice> slices;
  for (const nlohmann::json& event : nlohmann::json::parse(file)) {
    if (event["ph"] != "X") {
      EXPECT_EQ(event["name"], "thread_name");
      continue;
    }
    Slice slice;
    slice.name = event["name"];
    slice.thread = event["tid"];
    slice.begin_ns = ns(event["ts"]);
    slice.end_ns = slice.begin_ns + ns(event["dur"]);
    if (event.contains("args")) slice.frame = event["args"]["frame"];
    slices.push_back(slice);
  }
  return slices;
}

// Expects that slices of one thread are nested or disjoint.
inline void ExpectNesting(const std::vector<Slice>& slices) {
  for (const Slice& a : slices) {
    EXPECT_LE(a.begin_ns, a.end_ns);
    for (const Slice& b : slices) {
      if (a.thread != b.thread) continue;
      const bool crossing = a.begin_ns < b.begin_ns && b.begin_ns < a.end_ns && a.end_ns < b.end_ns;
      EXPECT_FALSE(crossing) << a.name << " and " << b.name;
    }
  }
}

}  // namespace surfit::testing
