#include "surfit/io/surfel_ply.h"

#include "io/ply_writer.h"

namespace surfit {

void WriteSurfelPly(const SurfelMap& map, const std::string& path) {
  constexpr PlyType kFloat = PlyType::kFloat32, kByte = PlyType::kUint8, kInt = PlyType::kInt32;
  const std::vector<PlyProperty> properties = {
      {"x", kFloat},      {"y", kFloat},      {"z", kFloat},          {"nx", kFloat},
      {"ny", kFloat},     {"nz", kFloat},     {"red", kByte},         {"green", kByte},
      {"blue", kByte},    {"radius", kFloat}, {"confidence", kFloat}, {"first_seen", kInt},
      {"last_seen", kInt}};
  const std::vector<std::int32_t> ids = map.Ids();
  WritePlyVertices(path, ids.size(), properties, [&](std::size_t i, PlyRow* row) {
    const Surfel s = map[ids[i]];
    for (const float value : s.position_in_world) row->Put(value);
    for (const float value : s.normal_in_world) row->Put(value);
    for (const std::uint8_t value : {s.color.r, s.color.g, s.color.b}) row->Put(value);
    for (const float value : {s.radius_m, s.confidence}) row->Put(value);
    for (const std::int32_t value : {s.first_seen, s.last_seen}) row->Put(value);
  });
}

}  // namespace surfit
