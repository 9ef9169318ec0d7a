// SPDX-License-Identifier: MIT
/// @file  Reads the reference rows of tests/golden.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace gyrostat::test {

/// Columns by name; lines that start with # are comments.
class Golden {
 public:
  explicit Golden(const std::string& file) {
    std::ifstream in(std::string(GYROSTAT_GOLDEN_DIR) + "/" + file);
    if (!in) throw std::runtime_error("no golden file " + file);
    std::vector<std::string> names;
    std::vector<std::vector<double>> columns;
    for (std::string line; std::getline(in, line);) {
      if (line.empty() || line[0] == '#') continue;
      std::stringstream cells(line);
      std::string cell;
      if (names.empty()) {
        while (std::getline(cells, cell, ',')) names.push_back(cell);
        columns.resize(names.size());
      } else {
        for (std::vector<double>& column : columns) {
          std::getline(cells, cell, ',');
          column.push_back(std::stod(cell));
        }
      }
    }
    for (std::size_t i = 0; i < names.size(); ++i)
      if (!columns_.emplace(names[i], std::move(columns[i])).second)
        throw std::runtime_error(names[i] + " twice in " + file);
  }

  bool has(const std::string& name) const { return columns_.count(name) != 0; }
  double at(const std::string& name, std::size_t row) const { return columns_.at(name).at(row); }

  /// Columns name_0, name_1, ... of a row.
  std::vector<double> vector(const std::string& name, std::size_t row) const {
    std::vector<double> out;
    for (int i = 0; has(name + "_" + std::to_string(i)); ++i) out.push_back(at(name + "_" + std::to_string(i), row));
    return out;
  }

  /// Largest magnitude of a vector's columns over the first `rows`.
  double scale(const std::string& name, std::size_t rows) const {
    double largest = 0;
    for (std::size_t k = 0; k < rows; ++k)
      for (const double x : vector(name, k)) largest = std::max(largest, std::abs(x));
    return largest;
  }

 private:
  std::map<std::string, std::vector<double>> columns_;
};

/// Samples that a stack is held to, and how closely, as a share of the scale of a group of columns: both sides compute in
/// double, and the largest difference, from conversions of the attitude and from cancellation in the rate error, is some 1e-12.
inline constexpr std::size_t golden_rows = 60;
inline constexpr double golden_tolerance = 1e-9;

/// Checks a vector of this sample against the row.
inline void expect_row(const Golden& golden, const char* name, std::size_t k, const std::vector<double>& ours) {
  const std::vector<double> theirs = golden.vector(name, k);
  ASSERT_EQ(theirs.size(), ours.size()) << name;
  for (std::size_t i = 0; i < ours.size(); ++i)
    EXPECT_NEAR(ours[i], theirs[i], golden_tolerance * golden.scale(name, golden_rows))
        << name << "_" << i << ", row " << k;
}

inline std::vector<double> values(const auto& u) { return {u.data(), u.data() + u.size()}; }

}  // namespace gyrostat::test
