// SPDX-License-Identifier: MIT
// Coverage-guided: any bytes as measurements and references of any stack of the catalogue. Whatever comes in, no sanitizer
// reports, and the command is finite and inside its limits. `make fuzz` builds and runs it.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "../../benchmarks/scenarios.hpp"
#include "gyrostat/host/assembly.hpp"

namespace {

using namespace gyrostat;

/// Numbers from the fuzzer's bytes; zeros when they are used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool empty() const { return left_ == 0; }

  template <class T>
  T take() {
    T value{};
    const std::size_t n = std::min(sizeof(T), left_);
    std::memcpy(&value, data_, n);
    data_ += n;
    left_ -= n;
    return value;
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

host::Table scenario(std::uint8_t observer, std::uint8_t detector, std::uint8_t controller, std::uint8_t allocator) {
  const auto chosen = [](const auto& family, std::uint8_t i) {
    const std::vector<std::string> names = family.names();
    return host::Table{{"type", names[i % names.size()]}};
  };
  host::Table s = bench::ftc_4rw("rk4");
  s.set("allow_unstable", true);
  s.set("observer", chosen(host::catalogue().observers, observer));
  s.set("detector", chosen(host::catalogue().detectors, detector));
  s.set("controller", chosen(host::catalogue().controllers, controller));
  s.set("allocator", chosen(host::catalogue().allocators, allocator));
  return s;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  const auto o = in.take<std::uint8_t>(), d = in.take<std::uint8_t>(), c = in.take<std::uint8_t>(),
             a = in.take<std::uint8_t>();
  const host::Assembly assembly = host::assemble(scenario(o, d, c, a));
  host::Stack stack = host::make_stack(assembly, {});
  const Vehicle<double>& vehicle = assembly.setup.vehicle;
  Measurement<double> y;
  y.q_NB = assembly.initial.q_NB;
  y.h_w = VecN<double>::Zero(vehicle.actuators());
  Reference<double> ref;
  for (Tick k = 0; k < 200 && !in.empty(); ++k) {
    y.tick = k;
    // A mask says which numbers change, so that short inputs reach far.
    const auto mask = in.take<std::uint16_t>();
    for (int i = 0; i < 4; ++i)
      if (mask >> i & 1) y.q_NB.coeffs()[i] = in.take<double>();
    for (int i = 0; i < 3; ++i)
      if (mask >> (4 + i) & 1) y.omega_BN_B[i] = in.take<double>();
    for (int i = 0; i < 4; ++i)
      if (mask >> (7 + i) & 1) y.h_w[i] = in.take<double>();
    if (mask >> 11 & 1) ref.q_NR.coeffs()[in.take<std::uint8_t>() % 4] = in.take<double>();
    if (mask >> 12 & 1) ref.omega_RN_R[in.take<std::uint8_t>() % 3] = in.take<double>();
    if (mask >> 13 & 1) ref.omegadot_RN_R[in.take<std::uint8_t>() % 3] = in.take<double>();
    if (mask >> 14 & 1) y.euler.angles[in.take<std::uint8_t>() % 3] = in.take<double>();
    if (mask >> 15 & 1) y.euler.rates[in.take<std::uint8_t>() % 3] = in.take<double>();
    const VecN<double>& u = stack.step(y, ref).u;
    for (int i = 0; i < vehicle.actuators(); ++i) {
      if (!(u[i] >= vehicle.u_lo[i] && u[i] <= vehicle.u_up[i])) {
        std::fprintf(stderr, "command %d = %g is outside [%g, %g]\n", i, u[i], vehicle.u_lo[i], vehicle.u_up[i]);
        std::abort();
      }
    }
  }
  return 0;
}
