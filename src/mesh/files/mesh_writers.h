#pragma once

#include <ostream>
#include <string>

#include "surfit/mesh/texture_mesh.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

// Null texture: vertices have colours, if the mesh has any. `material`: name of the .mtl file in
// the same folder; not used without texture. The functions write to memory or a file stream, whose
// errors the caller checks.
void WriteObjMesh(const TriangleMesh& mesh, const MeshTexture* texture, const std::string& material,
                  std::ostream& out);
// Writes a material with the image `picture`, without shading.
void WriteMtl(const std::string& picture, std::ostream& out);

// Writes binary glTF 2.0 with the texture inside the file.
void WriteGlbMesh(const TriangleMesh& mesh, const MeshTexture* texture, std::ostream& out);

// JPEG file of a texture. Throws InputError if encoding fails.
std::string EncodeTexture(const MeshTexture& texture);

}  // namespace surfit
