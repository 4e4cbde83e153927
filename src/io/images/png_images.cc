// Decodes and encodes PNG files without gamma conversion. Plain files are decoded by plain_png.cc,
// all others by libpng.
#include <png.h>
#include <zlib.h>  // Z_BEST_SPEED, Z_RLE

#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <new>
#include <utility>
#include <vector>

#include "io/images/image_kinds.h"

namespace surfit {
namespace {

static_assert(sizeof(Rgb8) == 3, "rows are read as red, green, blue");

// libpng reports errors by longjmp().
[[noreturn]] void JumpOut(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void IgnoreWarning(png_structp, png_const_charp) {}

// Returns false if libpng fails in `task`. longjmp() skips destructors, so `task` must not create
// objects with a destructor.
template <typename Task>
bool Succeeds(png_structp png, const Task& task) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  task();
  return true;
}

struct PngSource {
  const char* next;
  std::size_t left;
};

void TakeBytes(png_structp png, png_bytep to, std::size_t count) {
  auto* const source = static_cast<PngSource*>(png_get_io_ptr(png));
  if (count > source->left) png_error(png, "truncated");
  std::memcpy(to, source->next, count);
  source->next += count;
  source->left -= count;
}

template <typename T>
std::vector<png_bytep> RowsOf(const Image<T>& image) {
  std::vector<png_bytep> rows(image.height());
  for (int v = 0; v < image.height(); ++v)
    rows[v] = reinterpret_cast<png_bytep>(const_cast<T*>(image.row(v)));
  return rows;
}

struct PngStructs {
  bool of_writer;
  png_structp png = nullptr;
  png_infop info = nullptr;

  // Throws std::bad_alloc.
  explicit PngStructs(bool is_writer)
      : of_writer(is_writer),
        png((is_writer ? png_create_write_struct : png_create_read_struct)(
            PNG_LIBPNG_VER_STRING, nullptr, JumpOut, IgnoreWarning)) {
    if (png != nullptr) info = png_create_info_struct(png);
    if (info != nullptr) return;
    Destroy();
    throw std::bad_alloc();
  }
  ~PngStructs() { Destroy(); }
  PngStructs& operator=(PngStructs&&) = delete;

 private:
  void Destroy() {
    if (of_writer) {
      png_destroy_write_struct(&png, &info);
    } else {
      png_destroy_read_struct(&png, &info, nullptr);
    }
  }
};

class PngReader {
 public:
  // Reads the header. Throws InputError with `path`. Both arguments must outlive the reader.
  PngReader(const std::string& bytes, const std::string& path)
      : path_(path), source_{bytes.data(), bytes.size()} {
    Require(Succeeds(png_, [this] {
      png_set_read_fn(png_, &source_, TakeBytes);
      png_read_info(png_, info_);
    }));
  }
  PngReader& operator=(PngReader&&) = delete;

  int type() const { return png_get_color_type(png_, info_); }
  int bits() const { return png_get_bit_depth(png_, info_); }
  int channels() const {
    return type() == PNG_COLOR_TYPE_PALETTE ? 3 : png_get_channels(png_, info_);
  }

  // 16-bit counts in host byte order.
  Image<std::uint16_t> ReadCounts() {
    return Read<std::uint16_t>([this] { png_set_swap(png_); });
  }

  Image<std::uint8_t> ReadBytes() {
    return Read<std::uint8_t>([this] { png_set_expand_gray_1_2_4_to_8(png_); });
  }

  Image<Rgb8> ReadColor() {
    return Read<Rgb8>([this] {
      png_set_strip_16(png_);
      png_set_palette_to_rgb(png_);
      png_set_expand_gray_1_2_4_to_8(png_);
      png_set_gray_to_rgb(png_);
      png_set_strip_alpha(png_);
    });
  }

 private:
  template <typename T, typename Convert>
  Image<T> Read(const Convert& convert) {
    Image<T> image(png_get_image_width(png_, info_), png_get_image_height(png_, info_));
    const std::vector<png_bytep> rows = RowsOf(image);
    Require(Succeeds(png_, [&] {
      convert();
      png_set_interlace_handling(png_);
      png_read_update_info(png_, info_);
      if (png_get_rowbytes(png_, info_) != sizeof(T) * image.width()) png_error(png_, "odd rows");
      png_read_image(png_, const_cast<png_bytepp>(rows.data()));
      png_read_end(png_, nullptr);
    }));
    return image;
  }

  void Require(bool holds) const {
    if (!holds) throw DamagedImage(path_);
  }

  const std::string& path_;
  PngSource source_;
  const PngStructs structs_{/*is_writer=*/false};
  png_structp png_ = structs_.png;
  png_infop info_ = structs_.info;
};

class PngWriter {
 public:
  template <typename T>
  std::string Write(const Image<T>& image, int bits, int type) {
    const std::vector<png_bytep> rows = RowsOf(image);
    const bool written = Succeeds(png_, [&] {
      png_set_write_fn(png_, this, Append, nullptr);
      png_set_IHDR(png_, info_, image.width(), image.height(), bits, type, PNG_INTERLACE_NONE,
                   PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
      // These settings are much faster than the default settings. The files are one third larger.
      png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
      png_set_compression_level(png_, Z_BEST_SPEED);
      png_set_compression_strategy(png_, Z_RLE);
      png_write_info(png_, info_);
      if (bits > 8) png_set_swap(png_);
      png_write_image(png_, const_cast<png_bytepp>(rows.data()));
      png_write_end(png_, nullptr);
    });
    if (written) return std::move(bytes_);
    throw InputError("cannot encode a PNG of ", image.width(), " x ", image.height(),
                     " pixels: out of memory, or the image is empty");
  }

 private:
  // Converts std::bad_alloc to a libpng error: exceptions must not pass through C code.
  static void Append(png_structp png, png_bytep from, std::size_t count) {
    bool done = true;
    try {
      auto* const writer = static_cast<PngWriter*>(png_get_io_ptr(png));
      writer->bytes_.append(reinterpret_cast<const char*>(from), count);
    } catch (const std::bad_alloc&) {
      done = false;
    }
    if (!done) png_error(png, "no memory");
  }

  std::string bytes_;
  const PngStructs structs_{/*is_writer=*/true};
  png_structp png_ = structs_.png;
  png_infop info_ = structs_.info;
};

}  // namespace

RawDepth DecodeDepthPng(const std::string& bytes, const std::string& path) {
  if (auto counts = ReadPlainCounts(PngChunks(bytes, path))) return std::move(*counts);
  PngReader reader(bytes, path);
  if (reader.type() == PNG_COLOR_TYPE_GRAY && reader.bits() == 16) return reader.ReadCounts();
  throw NotADepthImage(reader.channels(), reader.bits(), path);
}

Image<std::uint8_t> DecodeConfidencePng(const std::string& bytes, const std::string& path) {
  PngChunks(bytes, path);
  PngReader reader(bytes, path);
  if (reader.type() == PNG_COLOR_TYPE_GRAY && reader.bits() <= 8) return reader.ReadBytes();
  throw NotAConfidenceImage(reader.channels(), reader.bits(), path);
}

Image<Rgb8> DecodeColorPng(const std::string& bytes, const std::string& path) {
  if (auto color = ReadPlainColor(PngChunks(bytes, path))) return std::move(*color);
  return PngReader(bytes, path).ReadColor();
}

std::string EncodePng(const Image<Rgb8>& image) {
  return PngWriter().Write(image, 8, PNG_COLOR_TYPE_RGB);
}

std::string EncodePng(const Image<std::uint16_t>& image) {
  return PngWriter().Write(image, 16, PNG_COLOR_TYPE_GRAY);
}

std::string EncodePng(const Image<std::uint8_t>& image) {
  return PngWriter().Write(image, 8, PNG_COLOR_TYPE_GRAY);
}

}  // namespace surfit
