#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

namespace surfit {

// Takes the place of a field of any type, but not of the struct itself, as a copy of it would.
template <typename Struct>
struct AnyField {
  template <typename T, typename = std::enable_if_t<!std::is_same_v<T, Struct>>>
  operator T() const;  // never defined: only its type is looked at
};

template <typename Struct, std::size_t>
using AnyFieldAt = AnyField<Struct>;

template <typename Struct, std::size_t... I>
auto TakesFields(std::index_sequence<I...>)
    -> decltype(Struct{AnyFieldAt<Struct, I>()...}, std::true_type());
template <typename Struct>
std::false_type TakesFields(...);

// How many fields a plain struct has: as many as initialise it. Not for structs with a field that
// can be made from anything, such as std::optional.
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
