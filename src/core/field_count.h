#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

namespace surfit {

// Number of fields of a struct at compile time, to check that a table lists all fields.

// Converts to any type except the struct itself, so that a copy of the struct is not counted as a
// field.
template <typename Struct>
struct AnyField {
  template <typename T, typename = std::enable_if_t<!std::is_same_v<T, Struct>>>
  operator T() const;  // declared only
};

template <typename Struct, std::size_t>
using AnyFieldAt = AnyField<Struct>;

template <typename Struct, std::size_t... I>
auto TakesFields(std::index_sequence<I...>)
    -> decltype(Struct{AnyFieldAt<Struct, I>()...}, std::true_type());
template <typename Struct>
std::false_type TakesFields(...);

// Number of fields of an aggregate, at most `Count`. Each element of a C array counts as a field.
// Not valid for fields that are constructible from any type, such as std::optional.
template <typename Struct, std::size_t Count = 64>
constexpr std::size_t FieldCount() {
  if constexpr (Count == 0 ||
                decltype(TakesFields<Struct>(std::make_index_sequence<Count>()))::value) {
    return Count;
  } else {
    return FieldCount<Struct, Count - 1>();
  }
}

}  // namespace surfit
