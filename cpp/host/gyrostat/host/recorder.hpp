// SPDX-License-Identifier: MIT
/// @file  Chosen channels of a run, kept in preallocated rows.
#pragma once
#include "gyrostat/host/channels.hpp"

namespace gyrostat::host {

class Recorder {
 public:
  explicit Recorder(ChannelReader reader);

  /// Numbers in a row, the time included.
  std::size_t width() const noexcept;
  /// Room for so many rows; to be called once, before the first one is recorded.
  void reserve(std::size_t rows);
  bool needs_previous() const noexcept { return reader_.needs_previous(); }
  void record(const Moment& now);

  struct Channel {
    ChannelInfo info;
    std::vector<double> data;  ///< rows x size
  };
  std::vector<Channel> take() &&;
  const std::vector<double>& times() const noexcept { return t_; }

 private:
  ChannelReader reader_;
  std::vector<std::vector<double>> data_;
  std::vector<double> t_;
};

}  // namespace gyrostat::host
