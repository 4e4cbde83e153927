#pragma once

#include <ostream>
#include <string>

#include "surfit/mesh/texture_mesh.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

// The formats of meshes that may have a picture; null: vertices have the colours.

// With a picture, `material` is the name of the .mtl file beside it.
void WriteObjMesh(const TriangleMesh& mesh, const MeshTexture* texture, const std::string& material,
                  std::ostream& out);
// A material of this name's stem that shows the picture as it is.
void WriteMtl(const std::string& picture, std::ostream& out);

void WriteGlbMesh(const TriangleMesh& mesh, const MeshTexture* texture, std::ostream& out);

// The picture as a JPEG. Throws InputError.
std::string EncodeTexture(const MeshTexture& texture);

}  // namespace surfit
