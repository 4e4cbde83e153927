#pragma once

#include <cstddef>
#include <vector>

namespace surfit {

// Empties a buffer that is used again and again, for at most so many items. It keeps its memory,
// but not that of one which needed far more.
template <typename T>
void ClearClosely(std::size_t most, std::vector<T>* buffer) {
  if (buffer->capacity() > 2 * most) *buffer = std::vector<T>();
  buffer->clear();
}

}  // namespace surfit
