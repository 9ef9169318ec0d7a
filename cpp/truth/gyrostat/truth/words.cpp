// SPDX-License-Identifier: MIT
#include "gyrostat/truth/words.hpp"

#include <Random123/philox.h>

#include <algorithm>

namespace gyrostat::truth {

std::vector<std::uint64_t> words(std::uint64_t seed, std::uint64_t first, std::uint64_t last,
                                 std::span<const WordStream> streams, std::uint64_t domain, std::uint64_t part) {
  std::uint64_t width = 0;
  for (const WordStream& s : streams) width += s.count;
  std::vector<std::uint64_t> out;
  out.reserve(static_cast<std::size_t>((last - first) * width));
  for (std::uint64_t run = first; run < last; ++run) {
    for (const WordStream& s : streams) {
      for (std::uint64_t j = 0; j < s.count; j += 4) {
        const auto four = r123::Philox4x64()({{j / 4, s.name, part, domain}}, {{seed, run}});
        const std::uint64_t left = std::min<std::uint64_t>(4, s.count - j);
        out.insert(out.end(), four.begin(), four.begin() + static_cast<std::ptrdiff_t>(left));
      }
    }
  }
  return out;
}

}  // namespace gyrostat::truth
