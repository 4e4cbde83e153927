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

// Every coding once: what stands in tests/io/corpus.
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

// Reads all that can be read; refusing is fine. Returns whether any frame could.
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

// What deflate can make of a file of that size at most, as floats, and what reading takes besides.
std::size_t Promise(std::size_t file_size) { return 2 * 1032 * file_size + (1 << 20); }

void ReadMutations(const std::string& ending, int count) {
  const TempFolder folder;
  folder.Write("mutated.klg.yaml", SmallCameraYaml());  // which .klg files need
  const int level = std::exchange(FLAGS_minloglevel, google::GLOG_ERROR);
  Random random(7);
  int read = 0, tried = 0;
  for (const SeedFile& seed : SeedFiles()) {
    if (seed.name.find(ending) == std::string::npos) continue;
    for (int i = 0; i < count / 3 + 1; ++i, ++tried) {
      const std::string bytes = Mutated(seed.bytes, &random);
      std::filesystem::remove(folder / ("mutated" + ending));  // quicker than to write over it
      const std::string path = folder.Write("mutated" + ending, bytes);
      ResetLargestAllocation();
      read += ReadAsFarAsPossible(path) ? 1 : 0;
      ASSERT_LE(LargestAllocation(), Promise(bytes.size())) << seed.name << ", mutation " << i;
    }
  }
  FLAGS_minloglevel = level;
  ASSERT_GE(tried, count);
  // Or else the mutations would be so coarse that hardly any gets beyond the header.
  EXPECT_GT(read, tried / 10);
  EXPECT_LT(read, tried);
}

// A camera stands beside each .klg file. SURFIT_WRITE_CORPUS in the environment writes it anew.
TEST(Corpus, HoldsWhatTheEncodersWrite) {
  for (const SeedFile& seed : SeedFiles()) {
    const std::string path = std::string(SURFIT_CORPUS_DIR) + "/" + seed.name;
    if (std::getenv("SURFIT_WRITE_CORPUS") != nullptr) WriteBytes(path, seed.bytes);
    EXPECT_TRUE(ReadAsFarAsPossible(path)) << path;
  }
  // Without a codec, whose versions may differ, to the byte.
  EXPECT_EQ(ReadBytes(std::string(SURFIT_CORPUS_DIR) + "/raw_raw.klg"), KlgFile(2, false, ""));
}

// Small files that claim 16384 x 16384 pixels, where depth alone would take 512 MB.
TEST(Mutated, HugeImagesAreRefusedBeforeTheyTakeMemory) {
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

TEST(Mutated, KlgFilesAreReadOrRefused) { ReadMutations(".klg", 400); }
TEST(Mutated, SensFilesAreReadOrRefused) { ReadMutations(".sens", 400); }
TEST(TenThousandMutated, KlgFilesAreReadOrRefused) { ReadMutations(".klg", 10000); }
TEST(TenThousandMutated, SensFilesAreReadOrRefused) { ReadMutations(".sens", 10000); }

}  // namespace
}  // namespace surfit::testing
