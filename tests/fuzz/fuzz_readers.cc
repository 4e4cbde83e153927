// Fuzzes a file reader with libFuzzer:
//   fuzz_readers --target=NAME [--seeds=DIR] [libFuzzer flags] CORPUS...
// Writes the seeds of the target into DIR, which should be one of the corpora.
#include <cstdint>
#include <fstream>
#include <iostream>
#include <memory>

#include "fuzz/targets.h"

namespace surfit::testing {
namespace {

std::unique_ptr<FuzzedReader> reader;  // NOLINT: libFuzzer passes no context

const FuzzTarget* FindTarget(const std::string& name) {
  for (const FuzzTarget& target : FuzzTargets()) {
    if (target.name == name) return &target;
  }
  return nullptr;
}

void WriteSeeds(const FuzzTarget& target, const std::string& folder) {
  for (std::size_t i = 0; i < target.seeds.size(); ++i) {
    std::ofstream(folder + "/seed" + std::to_string(i), std::ios::binary) << target.seeds[i];
  }
}

}  // namespace
}  // namespace surfit::testing

// libFuzzer ignores flags that begin with two dashes.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  using namespace surfit::testing;
  const std::string kFlag = "--target=", kSeedFlag = "--seeds=";
  const FuzzTarget* target = nullptr;
  std::string seeds;
  for (int i = 1; i < *argc; ++i) {
    const std::string argument = (*argv)[i];
    if (argument.rfind(kFlag, 0) == 0) target = FindTarget(argument.substr(kFlag.size()));
    if (argument.rfind(kSeedFlag, 0) == 0) seeds = argument.substr(kSeedFlag.size());
  }
  if (target != nullptr) {
    if (!seeds.empty()) WriteSeeds(*target, seeds);
    reader = std::make_unique<FuzzedReader>(*target);
    return 0;
  }
  std::cerr << "error: --target= must be one of";
  for (const FuzzTarget& target : FuzzTargets()) std::cerr << " " << target.name;
  std::cerr << "\n";
  std::exit(1);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  surfit::testing::reader->Takes({reinterpret_cast<const char*>(bytes), count});
  return 0;
}
