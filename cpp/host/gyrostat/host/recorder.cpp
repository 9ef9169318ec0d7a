// SPDX-License-Identifier: MIT
#include "gyrostat/host/recorder.hpp"

#include <algorithm>

namespace gyrostat::host {

Recorder::Recorder(ChannelReader reader) : reader_(std::move(reader)), data_(reader_.channels().size()) {}

std::size_t Recorder::width() const noexcept {
  std::size_t numbers = 1;
  for (const ChannelInfo& c : reader_.channels()) numbers += static_cast<std::size_t>(c.size);
  return numbers;
}

void Recorder::reserve(std::size_t rows) {
  t_.reserve(rows);
  for (std::size_t i = 0; i < data_.size(); ++i)
    data_[i].resize(rows * static_cast<std::size_t>(reader_.channels()[i].size));
}

void Recorder::record(const Moment& now) {
  reader_.read(now);
  for (std::size_t i = 0; i < data_.size(); ++i) {
    const std::span<const double> x = reader_[i];
    std::copy(x.begin(), x.end(), data_[i].data() + t_.size() * x.size());
  }
  t_.push_back(now.t);
}

std::vector<Recorder::Channel> Recorder::take() && {
  std::vector<Channel> out;
  for (std::size_t i = 0; i < data_.size(); ++i) {
    const ChannelInfo& info = reader_.channels()[i];
    data_[i].resize(t_.size() * static_cast<std::size_t>(info.size));
    out.push_back({info, std::move(data_[i])});
  }
  return out;
}

}  // namespace gyrostat::host
