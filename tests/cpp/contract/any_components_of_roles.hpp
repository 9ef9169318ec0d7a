// SPDX-License-Identifier: MIT
/// @file  What compiles the components of a role.
#pragma once
#include "contract/counted_eigen.hpp"  // first

#include <array>

#include "any_components.hpp"

namespace gyrostat::test {

template <class Role>
std::span<const Maker<Role>> makers() {
  using List = ListOf<Role>;
  static constexpr auto all = []<std::size_t... i>(std::index_sequence<i...>) {
    return std::array{maker_of<typename List::template at<typename Role::Scalar, i>>()...};
  }(std::make_index_sequence<List::count>{});
  return all;
}

}  // namespace gyrostat::test
