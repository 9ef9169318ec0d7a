// SPDX-License-Identifier: MIT
// Random words of campaigns.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <stdexcept>

#include "gyrostat/truth/words.hpp"

namespace gyrostat::bindings {
namespace {

namespace py = pybind11;
using namespace py::literals;
using Words = std::vector<std::uint64_t>;

constexpr std::uint64_t most = std::uint64_t{1} << 31;

py::array_t<std::uint64_t> words(std::uint64_t seed, std::uint64_t first, std::uint64_t last, const Words& names,
                                 const Words& counts, std::uint64_t domain, std::uint64_t part) {
  if (names.size() != counts.size()) throw std::invalid_argument("names and counts differ in length");
  if (last < first) throw std::invalid_argument("last lies before first");
  std::vector<truth::WordStream> streams;
  std::uint64_t width = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (counts[i] > most) throw std::invalid_argument("more words than are made at once");
    streams.push_back({names[i], counts[i]});
    width += counts[i];
  }
  if (width > 0 && last - first > most / width) throw std::invalid_argument("more words than are made at once");
  auto* made = new Words;
  const py::capsule owner(made, [](void* p) { delete static_cast<Words*>(p); });
  {
    const py::gil_scoped_release no_gil;
    *made = truth::words(seed, first, last, streams, domain, part);
  }
  const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(last - first), static_cast<py::ssize_t>(width)};
  return py::array_t<std::uint64_t>(shape, made->data(), owner);
}

}  // namespace

void bind_words(py::module_& m) {
  m.def(
      "words", &words, "seed"_a, "first"_a, "last"_a, "names"_a, "counts"_a,
      "domain"_a = static_cast<std::uint64_t>(truth::WordDomain::draws), "part"_a = 0,
      "Random words of runs first to last - 1, shape (last - first, sum(counts)): of each stream, named by a hash, its "
      "count. Word j is Philox4x64-10 with key (seed, run) and counter (j div 4, name, part, domain), element j mod "
      "4.");
}

}  // namespace gyrostat::bindings
