#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace surfit::testing {

// Element of a Matroska file: identifier with its marker bit, then the size in 8 bytes.
inline std::string MkvElement(std::uint32_t id, const std::string& content) {
  std::string bytes;
  for (int i = 3; i >= 0; --i) {
    const auto byte = static_cast<unsigned char>(id >> (8 * i));
    if (!bytes.empty() || byte != 0) bytes += static_cast<char>(byte);
  }
  bytes += '\x01';
  for (int i = 6; i >= 0; --i) bytes += static_cast<char>(content.size() >> (8 * i));
  return bytes + content;
}

// Unsigned number, big endian, without leading zeros.
inline std::string MkvNumber(std::uint32_t id, std::uint64_t value) {
  std::string bytes;
  for (int i = 7; i >= 0; --i) {
    const auto byte = static_cast<unsigned char>(value >> (8 * i));
    if (!bytes.empty() || byte != 0 || i == 0) bytes += static_cast<char>(byte);
  }
  return MkvElement(id, bytes);
}

// Recording of an Azure Kinect in the form of k4arecord. The time scale is 1 us. Tracks are
// V_MS/VFW/FOURCC. Clusters have simple blocks and block groups.
class MkvWriter {
 public:
  // `fourcc`: pixel format of the Windows header. Returns the number of the track.
  int AddTrack(const std::string& name, int width, int height, const std::string& fourcc) {
    std::string head(40, '\0');  // BITMAPINFOHEADER
    head[0] = 40;
    head.replace(16, 4, fourcc);
    const std::string video = MkvNumber(0xb0, width) + MkvNumber(0xba, height);
    ++tracks_;
    entries_ += MkvElement(0xae, MkvNumber(0xd7, tracks_) + MkvNumber(0x73c5, 1000 + tracks_) +
                                     MkvNumber(0x83, 1) + MkvElement(0x536e, name) +
                                     MkvElement(0x86, "V_MS/VFW/FOURCC") +
                                     MkvElement(0x63a2, head) + MkvElement(0xe0, video));
    return tracks_;
  }

  void AddTag(const std::string& name, const std::string& value) {
    tags_ += MkvElement(
        0x7373, MkvElement(0x63c0, "") +
                    MkvElement(0x67c8, MkvElement(0x45a3, name) + MkvElement(0x4487, value)));
  }

  void AddAttachment(const std::string& name, const std::string& bytes) {
    attachments_ += MkvElement(0x61a7, MkvElement(0x466e, name) +
                                           MkvElement(0x4660, "application/octet-stream") +
                                           MkvElement(0x465c, bytes) + MkvNumber(0x46ae, 77));
  }

  // Begins a cluster. Times of frames are relative to it, up to 32 ms.
  void BeginCluster(std::uint64_t time_us) {
    clusters_.push_back(MkvNumber(0xe7, time_us));
    time_us_ = time_us;
  }
  void AddFrame(int track, std::uint64_t time_us, const std::string& bytes, bool in_group = false) {
    const auto relative = static_cast<std::uint16_t>(time_us - time_us_);
    std::string block(1, static_cast<char>(0x80 | track));
    block += static_cast<char>(relative >> 8);
    block += static_cast<char>(relative);
    block += in_group ? '\0' : '\x80';
    block += bytes;
    clusters_.back() += in_group ? MkvElement(0xa0, MkvElement(0xa1, block) + MkvNumber(0x9b, 1))
                                 : MkvElement(0xa3, block);
  }

  std::string File() const {
    std::string segment = MkvElement(0xec, std::string(50, '\0'));  // void, for the seek head
    segment +=
        MkvElement(0x1549a966, MkvNumber(0x2ad7b1, 1000) + MkvElement(0x7ba9, "Azure Kinect"));
    segment += MkvElement(0x1654ae6b, entries_);
    if (!attachments_.empty()) segment += MkvElement(0x1941a469, attachments_);
    segment += MkvElement(0x1254c367, tags_);
    for (const std::string& cluster : clusters_) segment += MkvElement(0x1f43b675, cluster);
    return MkvElement(0x1a45dfa3, MkvElement(0x4282, "matroska")) + MkvElement(0x18538067, segment);
  }

 private:
  int tracks_ = 0;
  std::string entries_, tags_, attachments_;
  std::vector<std::string> clusters_;
  std::uint64_t time_us_ = 0;
};

}  // namespace surfit::testing
