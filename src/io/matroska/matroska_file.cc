#include "io/matroska/matroska_file.h"

#include <optional>

#include "surfit/core/error.h"

namespace surfit {
namespace {

// Identifiers of elements, with the marker bit of their length. They are unique in the format.
enum ElementId : std::uint32_t {
  kEbml = 0x1a45dfa3,
  kSegment = 0x18538067,
  kInfo = 0x1549a966,
  kTimestampScale = 0x2ad7b1,
  kTracks = 0x1654ae6b,
  kTrackEntry = 0xae,
  kTrackNumber = 0xd7,
  kTrackType = 0x83,
  kTrackName = 0x536e,
  kCodecId = 0x86,
  kCodecPrivate = 0x63a2,
  kContentEncodings = 0x6d80,
  kVideo = 0xe0,
  kPixelWidth = 0xb0,
  kPixelHeight = 0xba,
  kColourSpace = 0x2eb524,
  kAttachments = 0x1941a469,
  kAttachedFile = 0x61a7,
  kFileName = 0x466e,
  kFileData = 0x465c,
  kTags = 0x1254c367,
  kTag = 0x7373,
  kSimpleTag = 0x67c8,
  kTagName = 0x45a3,
  kTagString = 0x4487,
  kCluster = 0x1f43b675,
  kTimestamp = 0xe7,
  kSimpleBlock = 0xa3,
  kBlockGroup = 0xa0,
  kBlock = 0xa1,
};

bool HasChildren(std::uint32_t id) {
  switch (id) {
    case kSegment:
    case kInfo:
    case kTracks:
    case kTrackEntry:
    case kVideo:
    case kAttachments:
    case kAttachedFile:
    case kTags:
    case kTag:
    case kSimpleTag:
    case kCluster:
    case kBlockGroup:
      return true;
    default:
      return false;
  }
}

struct Element {
  std::uint32_t id = 0;
  std::uint64_t at = 0;               // first byte of the content
  std::optional<std::uint64_t> size;  // std::nullopt: unknown
};

// Reads the elements in the order of the file. Identifiers are unique, so the ends of parents need
// not be known.
class ElementReader {
 public:
  explicit ElementReader(const BinaryFile& file) : file_(file) {}

  MatroskaContent Read() {
    const std::optional<Element> head = Next();
    ThrowIf(!head || head->id != kEbml || !head->size, file_.path(), " is no Matroska file");
    at_ = head->at + *head->size;
    while (at_ < file_.size()) {
      const std::optional<Element> element = Next();
      if (!element) break;
      if (HasChildren(element->id)) {
        Begin(element->id);
        at_ = element->at;
        continue;
      }
      ThrowIf(!element->size, file_.path(), " is damaged: the element at byte ", element->at,
              " has no size");
      if (!file_.Has(element->at, *element->size)) {
        content_.is_truncated = true;
        break;
      }
      Take(*element);
      at_ = element->at + *element->size;
    }
    return std::move(content_);
  }

 private:
  // Number of 1 to 8 bytes. The leading zero bits of the first byte give the length.
  struct Number {
    int bytes = 0;
    std::uint64_t with_marker = 0;
    std::uint64_t value = 0;  // without the marker bit
    bool is_unknown = false;  // all bits of the value are 1
  };
  static std::optional<Number> NumberAt(const std::string& bytes, std::size_t at, int longest) {
    if (at >= bytes.size()) return std::nullopt;
    const auto first = static_cast<unsigned char>(bytes[at]);
    Number number;
    number.bytes = 1;
    while (number.bytes <= longest && (first >> (8 - number.bytes) & 1) == 0) ++number.bytes;
    if (number.bytes > longest || at + number.bytes > bytes.size()) return std::nullopt;
    for (int i = 0; i < number.bytes; ++i)
      number.with_marker = number.with_marker << 8 | static_cast<unsigned char>(bytes[at + i]);
    const std::uint64_t marker = std::uint64_t{1} << (7 * number.bytes);
    number.value = number.with_marker - marker;
    number.is_unknown = number.value == marker - 1;
    return number;
  }

  // Header of the element at `at_`. std::nullopt if the file ends in it.
  std::optional<Element> Next() {
    constexpr std::uint64_t kLongestHead = 12;
    const std::uint64_t left = file_.size() - at_;
    const std::string bytes = file_.Read(at_, std::min(left, kLongestHead));
    const auto id = NumberAt(bytes, 0, 4);
    const auto size = id ? NumberAt(bytes, id->bytes, 8) : std::nullopt;
    if (!id || !size) {
      ThrowIf(left >= kLongestHead, file_.path(), " is damaged: there is no element at byte ", at_);
      content_.is_truncated = true;
      return std::nullopt;
    }
    Element element;
    element.id = static_cast<std::uint32_t>(id->with_marker);
    element.at = at_ + id->bytes + size->bytes;
    if (!size->is_unknown) element.size = size->value;
    return element;
  }

  void Begin(std::uint32_t id) {
    if (id == kTrackEntry) content_.tracks.emplace_back();
    if (id == kAttachedFile) content_.attachments.emplace_back();
    if (id == kSimpleTag) tag_name_.clear();
  }

  void Take(const Element& element) {
    if (element.id == kTimestampScale) scale_ns_ = Unsigned(element);
    if (element.id == kTimestamp) cluster_ = Unsigned(element);
    if (element.id == kSimpleBlock || element.id == kBlock) TakeBlock(element);
    if (element.id == kTagName) tag_name_ = Text(element);
    if (element.id == kTagString) content_.tags.emplace(tag_name_, Text(element));
    if (!content_.tracks.empty()) TakeOfTrack(element, &content_.tracks.back());
    if (content_.attachments.empty()) return;
    MatroskaAttachment& attachment = content_.attachments.back();
    if (element.id == kFileName) attachment.name = Text(element);
    if (element.id == kFileData) {
      attachment.at = element.at;
      attachment.count = *element.size;
    }
  }

  void TakeOfTrack(const Element& element, MatroskaTrack* track) const {
    constexpr std::size_t kFormatAt = 16, kWindowsHead = 40;  // BITMAPINFOHEADER::biCompression
    const auto pixels = [&] {
      const std::uint64_t value = Unsigned(element);
      ThrowIf(value < 1 || value > 16384, file_.path(), ": a track is ", value,
              " pixels wide or high, must be 1 to 16384");
      return static_cast<int>(value);
    };
    switch (element.id) {
      case kTrackNumber:
        track->number = Unsigned(element);
        break;
      case kTrackType:
        track->type = Unsigned(element);
        break;
      case kTrackName:
        track->name = Text(element);
        break;
      case kCodecId:
        track->codec = Text(element);
        break;
      case kCodecPrivate:
        if (*element.size >= kWindowsHead)
          track->pixel_format = file_.Read(element.at + kFormatAt, 4);
        break;
      case kColourSpace:
        if (track->pixel_format.empty()) track->pixel_format = Text(element);
        break;
      case kPixelWidth:
        track->size.width = pixels();
        break;
      case kPixelHeight:
        track->size.height = pixels();
        break;
      case kContentEncodings:
        track->is_encoded = true;
        break;
      default:
        break;
    }
  }

  // Track number, 16-bit time relative to the cluster (big endian), flags, data.
  void TakeBlock(const Element& element) {
    constexpr std::uint64_t kLongestHead = 11;
    const std::string bytes = file_.Read(element.at, std::min(*element.size, kLongestHead));
    const auto track = NumberAt(bytes, 0, 8);
    ThrowIf(!track || bytes.size() < track->bytes + 3U, file_.path(),
            " is damaged: the block at byte ", element.at, " is too short");
    const auto byte = [&](int i) {
      return static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[track->bytes + i]));
    };
    const auto relative = static_cast<std::int16_t>(byte(0) << 8 | byte(1));
    constexpr std::uint64_t kMost_ns = std::uint64_t{1} << 61;
    ThrowIf(scale_ns_ < 1 || scale_ns_ > 1000000000 || cluster_ > kMost_ns / scale_ns_,
            file_.path(), ": the block at byte ", element.at, " has the time ", cluster_,
            " in units of ", scale_ns_, " ns, must be below 2^61 ns");
    const std::int64_t units = static_cast<std::int64_t>(cluster_) + relative;
    const auto scale_ns = static_cast<std::int64_t>(scale_ns_);
    const std::uint64_t head = track->bytes + 3;
    content_.blocks.push_back({track->value, units * scale_ns, element.at + head,
                               *element.size - head, (byte(2) & 6) != 0});
  }

  std::uint64_t Unsigned(const Element& element) const {
    ThrowIf(*element.size > 8, file_.path(), " is damaged: the number at byte ", element.at,
            " has ", *element.size, " bytes, must have at most 8");
    std::uint64_t value = 0;
    for (const char byte : file_.Read(element.at, *element.size))
      value = value << 8 | static_cast<unsigned char>(byte);
    return value;
  }
  std::string Text(const Element& element) const {
    constexpr std::uint64_t kLongestText = 65536;
    ThrowIf(*element.size > kLongestText, file_.path(), " is damaged: the text at byte ",
            element.at, " has ", *element.size, " bytes, must have at most ", kLongestText);
    std::string text = file_.Read(element.at, *element.size);
    return text.substr(0, text.find('\0'));
  }

  const BinaryFile& file_;
  MatroskaContent content_;
  std::uint64_t at_ = 0;
  std::uint64_t scale_ns_ = 1000000;
  std::uint64_t cluster_ = 0;  // time of the cluster, in units of scale_ns_
  std::string tag_name_;
};

}  // namespace

MatroskaContent ReadMatroska(const BinaryFile& file) { return ElementReader(file).Read(); }

}  // namespace surfit
