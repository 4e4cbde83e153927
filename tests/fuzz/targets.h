#pragma once

#include <string>
#include <vector>

#include "testing/temp_folder.h"

namespace surfit::testing {

// Reader of untrusted files. The initial inputs are `seeds`, and the files of the folder `name` in
// tests/fuzz/corpus, if it exists.
struct FuzzTarget {
  std::string name;
  std::string file;                           // name of the fuzzed file in the folder
  void (*prepare)(const TempFolder& folder);  // writes the other files of the folder
  void (*read)(const std::string& folder);    // throws InputError for invalid files
  std::vector<std::string> seeds = {};        // valid files
};

const std::vector<FuzzTarget>& FuzzTargets();
// The targets of phones, Matroska, OpenEXR, NumPy and inertial sensors. They are a part of
// FuzzTargets().
std::vector<FuzzTarget> DeviceTargets();

// Reads bytes as one of the targets, in a temporary folder.
class FuzzedReader {
 public:
  explicit FuzzedReader(const FuzzTarget& target);

  // Returns true if the reader accepts the bytes, false if it throws InputError. Other exceptions
  // propagate.
  bool Takes(const std::string& bytes) const;

 private:
  const FuzzTarget& target_;
  TempFolder folder_;
};

}  // namespace surfit::testing
