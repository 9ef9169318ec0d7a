// SPDX-License-Identifier: MIT
/// @file  Random words by counter, for all that is drawn beside sensor noise: a word is a function of who asks for it.
///
/// Word j of a stream is Philox4x64-10 with key (seed, run) and counter (j div 4, name, part, domain), element j mod 4
/// (Salmon, Moraes, Dror, Shaw 2011). Nothing is stored and nothing depends on what else is drawn.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace gyrostat::truth {

/// Last word of the counter: what the words are for. Domain 0 is sensor noise (`noise.hpp`).
enum class WordDomain : std::uint64_t { noise = 0, draws = 1, chains = 2, optimisers = 3, nets = 4 };

/// A number of words that belong together, under a name.
struct WordStream {
  std::uint64_t name;  ///< hash of its name
  std::uint64_t count;
};

/// The words of runs first to last - 1: a row a run, the streams behind each other.
std::vector<std::uint64_t> words(std::uint64_t seed, std::uint64_t first, std::uint64_t last,
                                 std::span<const WordStream> streams, std::uint64_t domain, std::uint64_t part);

}  // namespace gyrostat::truth
