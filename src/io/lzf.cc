#include "io/lzf.h"

#include "surfit/core/error.h"

namespace surfit {
namespace {

class Expander {
 public:
  Expander(std::string_view compressed, std::size_t size) : rest_(compressed), size_(size) {
    if (size / kMostLzfExpansion > compressed.size()) Refuse();
    out_.reserve(size);
  }

  std::string Run() {
    while (!rest_.empty()) {
      const std::size_t control = NextByte();
      if (control < 32) {
        CopyLiterals(control + 1);
      } else {
        // Three bits of length, of which 7 means that more follows, and 13 bits of distance.
        std::size_t length = control >> 5;
        if (length == 7) length += NextByte();
        const std::size_t distance = ((control & 31) << 8) + NextByte() + 1;
        CopyMatch(length + 2, distance);
      }
    }
    if (out_.size() != size_) Refuse();
    return std::move(out_);
  }

 private:
  [[noreturn]] void Refuse() const {
    throw InputError(Concat("the compressed data is damaged, it must expand to ", size_, " bytes"));
  }

  std::size_t NextByte() {
    if (rest_.empty()) Refuse();
    const auto byte = static_cast<unsigned char>(rest_.front());
    rest_.remove_prefix(1);
    return byte;
  }

  void CopyLiterals(std::size_t count) {
    if (count > rest_.size() || count > size_ - out_.size()) Refuse();
    out_.append(rest_.substr(0, count));
    rest_.remove_prefix(count);
  }

  // A match may reach into what it puts out itself.
  void CopyMatch(std::size_t count, std::size_t distance) {
    if (distance > out_.size() || count > size_ - out_.size()) Refuse();
    for (std::size_t i = 0; i < count; ++i) out_.push_back(out_[out_.size() - distance]);
  }

  std::string_view rest_;
  std::size_t size_;
  std::string out_;
};

}  // namespace

std::string ExpandLzf(std::string_view compressed, std::size_t size) {
  return Expander(compressed, size).Run();
}

}  // namespace surfit
