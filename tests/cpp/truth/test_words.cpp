// SPDX-License-Identifier: MIT
#include "gyrostat/truth/words.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

namespace gyrostat::truth::test_words {
namespace {

constexpr auto draws = static_cast<std::uint64_t>(WordDomain::draws);

TEST(Words, AreThePublishedPhilox) {
  // Known answer of philox4x64-10: counter and key all zero.
  const auto zero = words(0, 0, 1, std::array{WordStream{0, 4}}, 0, 0);
  EXPECT_EQ(zero, (std::vector<std::uint64_t>{0x16554d9eca36314c, 0xdb20fe9d672d0fdc, 0xd7e772cee186176b,
                                              0x7e68b68aec7ba23b}));
  // Seed 7, run 1234, stream "initial.mrp".
  const auto mrp = words(7, 1234, 1235, std::array{WordStream{0x4bb90ee972c2688a, 4}}, draws, 0);
  EXPECT_EQ(mrp, (std::vector<std::uint64_t>{0x97e8ff95e512bf1d, 0xcc0500335dbb28d1, 0x5aaab592b05b9c92,
                                             0xc8e2f92a2fe552ca}));
}

TEST(Words, OfARunDependOnNoOtherRunAndNoOtherStream) {
  const std::array streams{WordStream{11, 3}, WordStream{22, 9}, WordStream{33, 0}};
  const auto all = words(5, 100, 107, streams, draws, 2);
  ASSERT_EQ(all.size(), 7u * 12u);
  for (std::uint64_t run = 0; run < 7; ++run) {
    const auto alone = words(5, 100 + run, 101 + run, std::array{WordStream{22, 9}}, draws, 2);
    for (std::size_t j = 0; j < 9; ++j) EXPECT_EQ(all[run * 12 + 3 + j], alone[j]);
    const auto fewer = words(5, 100 + run, 101 + run, std::array{WordStream{22, 2}}, draws, 2);
    EXPECT_EQ(fewer, (std::vector<std::uint64_t>{alone[0], alone[1]}));
  }
}

TEST(Words, DifferByEveryPartOfTheirKey) {
  const std::array one{WordStream{11, 1}};
  const auto word = words(5, 100, 101, one, draws, 0)[0];
  EXPECT_NE(word, words(6, 100, 101, one, draws, 0)[0]);
  EXPECT_NE(word, words(5, 101, 102, one, draws, 0)[0]);
  EXPECT_NE(word, words(5, 100, 101, std::array{WordStream{12, 1}}, draws, 0)[0]);
  EXPECT_NE(word, words(5, 100, 101, one, draws + 1, 0)[0]);
  EXPECT_NE(word, words(5, 100, 101, one, draws, 1)[0]);
}

}  // namespace
}  // namespace gyrostat::truth::test_words
