#include "surfit/registration/residual_type.h"

#include "core/named_values.h"

namespace surfit {
namespace {

constexpr NamedValue<ResidualType> kTypes[] = {
    {"point_to_point", ResidualType::kPointToPoint},
    {"point_to_plane", ResidualType::kPointToPlane},
    {"symmetric_point_to_plane", ResidualType::kSymmetricPointToPlane},
    {"plane_to_plane", ResidualType::kPlaneToPlane}};

}  // namespace

std::vector<std::string> ResidualTypeNames() { return NamesOf(kTypes); }

ResidualType ResidualTypeFromName(const std::string& name) {
  return ValueOf("residual", name, kTypes);
}

std::string ToString(ResidualType type) { return NameOf(type, kTypes); }

NeededNormals NormalsNeededBy(ResidualType type) {
  switch (type) {
    case ResidualType::kPointToPoint:
      return NeededNormals::kNone;
    case ResidualType::kPointToPlane:
      return NeededNormals::kTarget;
    case ResidualType::kSymmetricPointToPlane:
    case ResidualType::kPlaneToPlane:
      break;
  }
  return NeededNormals::kBoth;
}

}  // namespace surfit
