#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace surfit::testing {

// Folder of a recorded sequence. It may not exist: see HasSharedData().
inline std::string SharedData(const std::string& sequence) {
  const char* const folder = std::getenv("SURFIT_DATA_DIR");
  return (folder != nullptr ? std::string(folder) : SURFIT_DATA_DIR) + "/" + sequence;
}

inline bool HasSharedData(const std::string& sequence) {
  return std::filesystem::is_directory(SharedData(sequence));
}

}  // namespace surfit::testing

// Skips the test if the sequence does not exist.
#define SURFIT_REQUIRE_SHARED_DATA(sequence)            \
  if (!surfit::testing::HasSharedData(sequence))        \
  GTEST_SKIP() << surfit::testing::SharedData(sequence) \
               << " does not exist; set SURFIT_DATA_DIR to the folder of recorded sequences"
