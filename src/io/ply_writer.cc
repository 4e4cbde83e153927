#include "io/ply_writer.h"

#include <glog/logging.h>

#include "surfit/core/atomic_file.h"

namespace surfit {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "PLY bodies are copied from memory");

void WritePlyVertices(const std::string& path, std::size_t count,
                      const std::vector<PlyProperty>& properties,
                      const std::function<void(std::size_t, PlyRow*)>& fill) {
  std::size_t row_size = 0;
  for (const PlyProperty& property : properties) row_size += PlySize(property.type);
  const PlyElement vertex{"vertex", static_cast<std::int64_t>(count), properties};
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << FormatPlyHeader({vertex});
    PlyRow row;
    for (std::size_t i = 0; i < count; ++i) {
      row.Clear();
      fill(i, &row);
      DCHECK_EQ(row.bytes().size(), row_size);
      out.write(row.bytes().data(), row.bytes().size());
    }
  });
}

}  // namespace surfit
