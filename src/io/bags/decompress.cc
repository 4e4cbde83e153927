#include "io/bags/decompress.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <new>

#include "surfit/core/error.h"

namespace surfit {
namespace {

// Maximum size of a chunk, bytes. Typical chunks have a few megabytes.
constexpr std::uint64_t kMaxOfChunk = std::uint64_t{256} << 20;
constexpr std::uint64_t kStep = std::uint64_t{1} << 18;  // minimum growth of the output, bytes

// Input and output buffers of a decompressor.
struct Flow {
  const char* in = nullptr;
  std::size_t in_left = 0;
  char* out = nullptr;
  std::size_t out_left = 0;

  void Advance(std::size_t taken, std::size_t given) {
    in += taken;
    in_left -= taken;
    out += given;
    out_left -= given;
  }
};

enum class Progress { kMore, kDone, kDamaged };

class Lz4Stream {
 public:
  Lz4Stream() {
    LZ4F_dctx* context = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0)
      throw std::bad_alloc();
    context_.reset(context);
  }
  Progress Run(Flow* flow) {
    std::size_t given = flow->out_left, taken = flow->in_left;
    const std::size_t left =
        LZ4F_decompress(context_.get(), flow->out, &given, flow->in, &taken, nullptr);
    if (LZ4F_isError(left) != 0) return Progress::kDamaged;
    flow->Advance(taken, given);
    return left == 0 ? Progress::kDone : Progress::kMore;
  }

 private:
  struct Free {
    void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
  };
  std::unique_ptr<LZ4F_dctx, Free> context_;
};

class ZstdStream {
 public:
  ZstdStream() : context_(ZSTD_createDCtx()) {
    if (context_ == nullptr) throw std::bad_alloc();
  }
  Progress Run(Flow* flow) {
    ZSTD_inBuffer in{flow->in, flow->in_left, 0};
    ZSTD_outBuffer out{flow->out, flow->out_left, 0};
    const std::size_t left = ZSTD_decompressStream(context_.get(), &out, &in);
    if (ZSTD_isError(left) != 0) return Progress::kDamaged;
    flow->Advance(in.pos, out.pos);
    return left == 0 ? Progress::kDone : Progress::kMore;
  }

 private:
  struct Free {
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
  };
  std::unique_ptr<ZSTD_DCtx, Free> context_;
};

class Bz2Stream {
 public:
  Bz2Stream() {
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }
  ~Bz2Stream() { BZ2_bzDecompressEnd(&stream_); }
  Bz2Stream& operator=(Bz2Stream&&) = delete;

  Progress Run(Flow* flow) {
    stream_.next_in = const_cast<char*>(flow->in);
    stream_.avail_in = static_cast<unsigned>(flow->in_left);
    stream_.next_out = flow->out;
    stream_.avail_out = static_cast<unsigned>(flow->out_left);
    const int result = BZ2_bzDecompress(&stream_);
    if (result == BZ_MEM_ERROR) throw std::bad_alloc();
    if (result != BZ_OK && result != BZ_STREAM_END) return Progress::kDamaged;
    flow->Advance(flow->in_left - stream_.avail_in, flow->out_left - stream_.avail_out);
    return result == BZ_STREAM_END ? Progress::kDone : Progress::kMore;
  }

 private:
  bz_stream stream_{};
};

template <typename Stream>
std::string Run(const std::string& bytes, std::uint64_t size, const std::string& name) {
  const auto damaged = [&] {
    return InputError(Concat(name, " is damaged: its ", bytes.size(),
                             " compressed bytes do not decompress to ", size));
  };
  Stream stream;
  std::string expanded;
  Flow flow{bytes.data(), bytes.size(), nullptr, 0};
  for (Progress progress = Progress::kMore; progress == Progress::kMore;) {
    const std::uint64_t done = expanded.size();
    // The buffer has one extra byte to detect data that are too long.
    expanded.resize(std::min(size + 1, done + std::max(done, kStep)));
    flow.out = expanded.data() + done;
    const std::size_t room = flow.out_left = expanded.size() - done;
    const std::size_t left = flow.in_left;
    progress = stream.Run(&flow);
    expanded.resize(expanded.size() - flow.out_left);
    const bool stands = flow.in_left == left && flow.out_left == room;
    if (progress == Progress::kDamaged || expanded.size() > size) throw damaged();
    if (progress == Progress::kMore && stands) throw damaged();
  }
  if (expanded.size() != size) throw damaged();
  return expanded;
}

}  // namespace

Compression ParseCompression(const std::string& word, const std::string& name) {
  if (word.empty() || word == "none") return Compression::kNone;
  if (word == "lz4") return Compression::kLz4;
  if (word == "zstd") return Compression::kZstd;
  if (word == "bz2") return Compression::kBz2;
  throw InputError(name, " has compression '", word, "', must be lz4, zstd, bz2 or none");
}

std::string Decompress(Compression compression, const std::string& bytes, std::uint64_t size,
                       const std::string& name) {
  ThrowIf(size > kMaxOfChunk, name, " claims ", size, " bytes, must have at most ", kMaxOfChunk);
  switch (compression) {
    case Compression::kLz4:
      return Run<Lz4Stream>(bytes, size, name);
    case Compression::kZstd:
      return Run<ZstdStream>(bytes, size, name);
    case Compression::kBz2:
      return Run<Bz2Stream>(bytes, size, name);
    case Compression::kNone:
      break;
  }
  ThrowIf(bytes.size() != size, name, " has ", bytes.size(), " bytes, claims ", size);
  return bytes;
}

std::string DecompressZstd(const std::string& bytes, const std::string& name) {
  const auto size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  ThrowIf(size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR, name,
          " is damaged: its zstd frame has no content size");
  return Decompress(Compression::kZstd, bytes, size, name);
}

}  // namespace surfit
