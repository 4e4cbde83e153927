// Runs the fuzz targets without libFuzzer: on the corpus files and on mutations of them.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "fuzz/targets.h"
#include "testing/matchers.h"
#include "testing/mutations.h"

namespace surfit::testing {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> KeptFiles(const FuzzTarget& target) {
  std::vector<std::string> files = target.seeds;
  const std::string folder = Concat(SURFIT_FUZZ_CORPUS, "/", target.name);
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    files.push_back(ReadBytes(entry.path().string()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string NameOf(const ::testing::TestParamInfo<FuzzTarget>& info) { return info.param.name; }

class FuzzCorpus : public ::testing::TestWithParam<FuzzTarget> {
 protected:
  // A mutation is read or rejected, and the memory stays proportional to its size.
  void ReadMutations(int count) const {
    const std::vector<std::string> files = KeptFiles(GetParam());
    const FuzzedReader reader(GetParam());
    Random random(7);
    int taken = 0;
    for (int i = 0; i < count; ++i) {
      taken += reader.Takes(Mutated(files[Below(files.size(), &random)], &random)) ? 1 : 0;
    }
    EXPECT_LT(taken, count);
  }
};

TEST(FuzzTargets, AreListedInCMake) {
  std::istringstream words(SURFIT_FUZZ_TARGETS);
  std::vector<std::string> fuzzed;
  for (std::string word; words >> word;) fuzzed.push_back(word);
  std::vector<std::string> targets;
  for (const FuzzTarget& target : FuzzTargets()) targets.push_back(target.name);
  EXPECT_EQ(targets, fuzzed);
}

// Mutations are useful only if one file of the corpus is valid.
TEST_P(FuzzCorpus, ContainsValidFile) {
  const FuzzedReader reader(GetParam());
  const std::vector<std::string> files = KeptFiles(GetParam());
  int taken = 0;
  std::size_t size = 0;
  for (const std::string& bytes : files) {
    taken += reader.Takes(bytes) ? 1 : 0;
    size += bytes.size();
  }
  EXPECT_GE(taken, 1);
  EXPECT_LE(size, 20000u);
}

TEST_P(FuzzCorpus, MutationsAreReadOrRejected) { ReadMutations(100); }

INSTANTIATE_TEST_SUITE_P(Readers, FuzzCorpus, ::testing::ValuesIn(FuzzTargets()), NameOf);

class ThousandsOfMutations : public FuzzCorpus {};

TEST_P(ThousandsOfMutations, AreReadOrRejected) { ReadMutations(5000); }

INSTANTIATE_TEST_SUITE_P(Readers, ThousandsOfMutations, ::testing::ValuesIn(FuzzTargets()), NameOf);

}  // namespace
}  // namespace surfit::testing
