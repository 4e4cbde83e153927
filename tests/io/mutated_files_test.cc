#include <glog/logging.h>
#include <gtest/gtest.h>

#include <utility>

#include "surfit/core/error.h"
#include "surfit/io/sequence.h"
#include "testing/largest_allocation.h"
#include "testing/mutations.h"
#include "testing/recordings.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

struct SeedFile {
  std::string name;
  std::string bytes;
};

// Files of every encoding: the contents of tests/io/corpus.
std::vector<SeedFile> SeedFiles() {
  SensEncoder zlib_jpeg, raw_png;
  zlib_jpeg.color_coding = ".jpg";
  raw_png.color_coding = ".png";
  raw_png.depth_coding = 0;
  SensEncoder raw_color;
  return {{"zlib_jpeg.klg", KlgFile(3, true, ".jpg")}, {"raw_raw.klg", KlgFile(2, false, "")},
          {"zlib_none.klg", KlgFile(2, true, "none")}, {"zlib_jpeg.sens", zlib_jpeg.File(3)},
          {"raw_png.sens", raw_png.File(2)},           {"zlib_raw.sens", raw_color.File(2)}};
}

// Reads all frames. InputError is allowed. Returns true if at least one frame was readable.
bool ReadAsFarAsPossible(const std::string& path) {
  bool any = false;
  try {
    for (const ReadResult& result : ReadAll(OpenSequence(OptionsOf(path)).get()))
      any = any || result.frame.has_value();
  } catch (const InputError& error) {
    EXPECT_STRNE(error.what(), "");
  }
  return any;
}

// Maximum allocation for a file of this size: deflate expands by at most 1032, counts become
// floats, plus 1 MiB.
std::size_t Promise(std::size_t file_size) { return 2 * 1032 * file_size + (1 << 20); }

void ReadMutations(const std::string& ending, int count) {
  const TempFolder folder;
  folder.Write("mutated.klg.yaml", SmallCameraYaml());  // required for .klg files
  const int level = std::exchange(FLAGS_minloglevel, google::GLOG_ERROR);
  Random random(7);
  int read = 0, tried = 0;
  for (const SeedFile& seed : SeedFiles()) {
    if (seed.name.find(ending) == std::string::npos) continue;
    for (int i = 0; i < count / 3 + 1; ++i, ++tried) {
      const std::string bytes = Mutated(seed.bytes, &random);
      std::filesystem::remove(folder / ("mutated" + ending));  // faster than overwriting
      const std::string path = folder.Write("mutated" + ending, bytes);
      ResetLargestAllocation();
      read += ReadAsFarAsPossible(path) ? 1 : 0;
      ASSERT_LE(LargestAllocation(), Promise(bytes.size())) << seed.name << ", mutation " << i;
    }
  }
  FLAGS_minloglevel = level;
  ASSERT_GE(tried, count);
  // Otherwise the mutations are too coarse to get past the header.
  EXPECT_GT(read, tried / 10);
  EXPECT_LT(read, tried);
}

// Each .klg file has a camera file. The environment variable SURFIT_WRITE_CORPUS rewrites the
// corpus.
TEST(Corpus, MatchesTheEncoders) {
  for (const SeedFile& seed : SeedFiles()) {
    const std::string path = std::string(SURFIT_CORPUS_DIR) + "/" + seed.name;
    if (std::getenv("SURFIT_WRITE_CORPUS") != nullptr) WriteBytes(path, seed.bytes);
    EXPECT_TRUE(ReadAsFarAsPossible(path)) << path;
  }
  // The uncompressed file is compared bytewise: codec versions may differ.
  EXPECT_EQ(ReadBytes(std::string(SURFIT_CORPUS_DIR) + "/raw_raw.klg"), KlgFile(2, false, ""));
}

// Small files that claim 16384 x 16384 pixels (512 MB of depth).
TEST(Mutated, HugeImagesAreRejectedBeforeAllocation) {
  const TempFolder folder;
  std::string sens = SensEncoder().File(1);
  const std::size_t sizes_at = 4 + 8 + 6 + 4 * 64 + 2 * 4;
  for (int i = 0; i < 4; ++i) sens.replace(sizes_at + 4 * i, 4, LittleEndian(16384));
  folder.Write("huge.sens", sens);
  std::string klg = KlgFile(1, true, ".jpg");
  const std::size_t frame_at = klg.find("\xFF\xC0");  // of JPEG: length, bits, height, width
  ASSERT_NE(frame_at, klg.npos);
  klg.replace(frame_at + 5, 4, std::string("\x40\x00\x40\x00", 4));
  folder.Write("huge.klg", klg);
  for (const char* name : {"huge.sens", "huge.klg"}) {
    ResetLargestAllocation();
    EXPECT_FALSE(ReadAsFarAsPossible(folder / name));
    EXPECT_LT(LargestAllocation(), 1u << 20) << name;
  }
}

TEST(Mutated, KlgFilesAreReadOrRejected) { ReadMutations(".klg", 400); }
TEST(Mutated, SensFilesAreReadOrRejected) { ReadMutations(".sens", 400); }
TEST(TenThousandMutated, KlgFilesAreReadOrRejected) { ReadMutations(".klg", 10000); }
TEST(TenThousandMutated, SensFilesAreReadOrRejected) { ReadMutations(".sens", 10000); }

}  // namespace
}  // namespace surfit::testing
