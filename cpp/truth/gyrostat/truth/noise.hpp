// SPDX-License-Identifier: MIT
/// @file  Standard normal deviates by counter: a function of (seed, run, stream, tick, version), the same on
///        every machine.
///
/// Philox4x64-10 gives four words (Salmon, Moraes, Dror, Shaw 2011), Box and Muller's form two deviates of two words:
/// sqrt(-2 ln u) (cos, sin)(2 pi v). Logarithm, sine and cosine are polynomials over exactly reduced arguments, without the
/// mathematical library: half its time, and no bits that depend on its version. Source: G. Box, M. Muller, Ann. Math. Stat. 29
/// (1958); coefficients of the logarithm as in fdlibm (Sun Microsystems), of sine and cosine as in Cephes (S. Moshier).
#pragma once
#include <Random123/philox.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "gyrostat/core/attitude.hpp"
#include "gyrostat/core/signals.hpp"

namespace gyrostat::truth {

namespace detail {

/// In [1, 2): the 52 leading bits of a word.
inline double unit_of(std::uint64_t word) noexcept { return std::bit_cast<double>((word >> 12) | 0x3ff0000000000000u); }

/// ln u for positive normal u, to 3e-16 of max(1, |ln u|): u = 2^e m with m in [sqrt(1/2), sqrt(2)), and
/// ln m = 2 f + f R(f^2), f = (m - 1) / (m + 1).
inline double logarithm(double u) noexcept {
  constexpr std::uint64_t one = 0x3ff0000000000000u, root_half = 0x3fe6a09e667f3bcdu;
  const std::uint64_t shifted = std::bit_cast<std::uint64_t>(u) + (one - root_half);
  const double e = std::bit_cast<double>((shifted >> 52) | 0x4330000000000000u) - (0x1p52 + 1023);
  const double m = std::bit_cast<double>((shifted & 0x000fffffffffffffu) + root_half);
  const double f = (m - 1) / (m + 1), z = f * f, w = z * z;
  const double odd =
      0.6666666666666735130 + w * (0.2857142874366239149 + w * (0.1818357216161805012 + w * 0.1479819860511658591));
  const double even = 0.3999999999940941908 + w * (0.2222219843214978396 + w * 0.1531383769920937332);
  return e * 0.693147180559945309 + (2 * f + f * (z * odd + w * even));
}

struct OnCircle {
  double cosine, sine;
};

/// cos and sin of 2 pi v for v in [0, 1): the nearest quarter turn exactly, the rest by polynomials. Without branches:
/// which quarter it is cannot be predicted.
inline OnCircle circle(double v) noexcept {
  const double quarters = 4 * v, rounded = quarters + 0x1.8p52;
  const double x = (quarters - (rounded - 0x1.8p52)) * 1.57079632679489662, z = x * x, w = z * z;
  const double s = (-1.66666666666666307295e-1 + z * 8.33333333332211858878e-3) +
                   w * ((-1.98412698295895385996e-4 + z * 2.75573136213857245213e-6) +
                        w * (-2.50507477628578072866e-8 + z * 1.58962301576546568060e-10));
  const double c = (4.16666666666665929218e-2 + z * -1.38888888888730564116e-3) +
                   w * ((2.48015872888517045348e-5 + z * -2.75573141792967388112e-7) +
                        w * (2.08757008419747316778e-9 + z * -1.13585365213876817300e-11));
  const std::uint64_t sine = std::bit_cast<std::uint64_t>(x + x * z * s);
  const std::uint64_t cosine = std::bit_cast<std::uint64_t>(1 - 0.5 * z + w * c);
  const std::uint64_t quarter = std::bit_cast<std::uint64_t>(rounded);  // its last two bits
  const std::uint64_t changed = (sine ^ cosine) & (0 - (quarter & 1));  // odd quarters change them over
  return {std::bit_cast<double>(cosine ^ changed ^ (((quarter + 1) & 2) << 62)),
          std::bit_cast<double>(sine ^ changed ^ ((quarter & 2) << 62))};
}

/// sqrt(-2 ln u), u uniform in (0, 1): half a step of 2^-52 away from both ends.
inline double radius(std::uint64_t word) noexcept { return std::sqrt(-2 * logarithm(unit_of(word) - (1 - 0x1p-53))); }

}  // namespace detail

/// Three standard normal numbers of a stream at a tick; any of them alone, in any order.
inline Vec3<double> standard_normals(std::uint64_t seed, std::uint64_t run, std::uint64_t stream, Tick tick,
                                     std::uint64_t version = 0) noexcept {
  const r123::Philox4x64::ctr_type w = r123::Philox4x64()({{tick, stream, version, 0}}, {{seed, run}});
  double r[2];
  detail::OnCircle at[2];
  for (std::size_t i = 0; i < 2; ++i) r[i] = detail::radius(w[2 * i + 1]);  // both at once, where the processor can
  for (std::size_t i = 0; i < 2; ++i) at[i] = detail::circle(detail::unit_of(w[2 * i]) - 1);
  return {r[0] * at[0].sine, r[0] * at[0].cosine, r[1] * at[1].sine};
}

/// Four numbers of a stream at a tick, uniform in [0, 1), in steps of 2^-52.
inline std::array<double, 4> standard_uniforms(std::uint64_t seed, std::uint64_t run, std::uint64_t stream, Tick tick,
                                               std::uint64_t version = 0) noexcept {
  const r123::Philox4x64::ctr_type w = r123::Philox4x64()({{tick, stream, version, 0}}, {{seed, run}});
  return {detail::unit_of(w[0]) - 1, detail::unit_of(w[1]) - 1, detail::unit_of(w[2]) - 1, detail::unit_of(w[3]) - 1};
}

/// The rotation by a small vector phi; exact to rounding below 1e-2 rad, by `quat_exp` beyond.
inline Quat<double> small_rotation(const Vec3<double>& phi) noexcept {
  const double q = 0.25 * (phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2]);  // (angle / 2)^2
  if (q > 2.5e-5) return quat_exp(phi);
  const double k = 0.5 * (1 - q * (1.0 / 6 - q * (1.0 / 120 - q / 5040)));
  return {1 - q * (0.5 - q * (1.0 / 24 - q / 720)), k * phi[0], k * phi[1], k * phi[2]};
}

}  // namespace gyrostat::truth
