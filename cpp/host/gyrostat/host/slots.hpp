// SPDX-License-Identifier: MIT
/// @file  The numbers of a scenario that differ from flight to flight, by their dotted paths:
///        "initial.omega_BN_B.1", "faults.0.remaining", "observer.kappa", "seed".
#pragma once
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "gyrostat/host/assembly.hpp"

namespace gyrostat::host {

/// A path that names a vector or a matrix stands for all its elements; a value an actuator that is written as one number, or
/// not at all, for one number. Where a waveform stands, a number becomes a constant one.
class Slots {
 public:
  /// @param a  what the scenario is assembled to
  /// @throws std::invalid_argument for a path that is no number of the scenario, with the nearest name, or that stands twice
  Slots(Table scenario, const Assembly& a, const std::vector<std::string>& paths);

  /// One name a number, in the order in which values are written.
  const std::vector<std::string>& columns() const noexcept { return columns_; }
  /// The scenario with every one of them in place.
  const Table& table() const noexcept { return table_; }

  /// A copy of the scenario whose numbers can be written.
  class Copy {
   public:
    explicit Copy(const Slots& slots);
    Copy(const Copy&) = delete;
    Copy& operator=(const Copy&) = delete;
    /// `values` in the order of `columns`; whole numbers stay whole.
    const Table& with(std::span<const double> values);

   private:
    Table table_;
    std::vector<Value*> numbers_;
    const std::vector<bool>& whole_;
  };

 private:
  using Step = std::variant<std::string, std::size_t>;  ///< into a table, into a list
  using Path = std::vector<Step>;

  struct Target;
  Target target_of(const Assembly& a, const std::string& path, std::vector<std::string> words);
  void add(const Assembly& a, const std::string& path);
  void take(const std::string& path, const Path& steps, const Value& value, bool whole);
  void refuse_gaps();
  static Value& at(Table& table, const Path& steps);

  Table table_;
  std::vector<std::string> columns_;
  std::vector<Path> paths_;
  std::vector<bool> whole_;
};

}  // namespace gyrostat::host
